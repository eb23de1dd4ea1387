// The fit of a tool's face to the lines and the surface.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "impedraw/experiment/plan.h"

namespace impedraw {

// Throws InputError where the face does not fit the lines or the surface: an edge whose ends leave
// a corner or a bend by more than 0.2 mm, or, on a curved surface, do not touch; a pad of whose rim
// nothing touches.
void require_fit(const Scenario& scenario, const Plan& plan, const SurfaceHeight& surface,
                 const SettingErrors& setting_errors);

// Throws InputError where a setting of another kind of tool was given: by --set, or in the file
// that gives tool.kind. What a scenario has for its own tool may stay when another is taken
// instead.
void require_own_settings(const ToolSettings& tool, const Places& places);

// Throws InputError where the force presses a pad's foam nearly flat, or where friction turns a pad
// with joints onto its edge.
void require_foam(const Scenario& scenario, const SettingErrors& setting_errors);

// The heading that a plan asks of a blade or a roller, and of the arm that turns it.

// The leading of the tool from the posture q on: its heading there, and how far the arm can turn it
// about its axis on the spot, either way, by inverse kinematics. The arm keeps
// preflight.joint_margin and kHeadingReserve off that: elsewhere its base stands otherwise. On a
// circle 0.6 rad leave 8 % of it out, 0.25 rad 1 %. Nothing for a tool that is not led.
inline constexpr double kHeadingReserve = 0.25;  // [rad]
std::optional<ToolHeading> heading_of(const Scenario& scenario, const ArmModel& arm,
                                      const JointVector& q);

// Cuts strokes that turn the tool further between two corners than the arm can: there it is lifted,
// and turned back. An arm that turns it by less than 360° has headings that it does not reach: what
// needs these is a part of its own, so that the others are whole. The parts keep their strokes'
// numbers. Adds a note that says where. `reserve`: by how much more than a range below 360° a line
// may turn to either side and is left whole [rad].
std::vector<PlacedStroke> cut_where_turned(std::vector<PlacedStroke> strokes,
                                           const ToolHeading& heading, double reserve,
                                           const Pose& X_WP, double corner_angle,
                                           std::vector<std::string>* notes);

}  // namespace impedraw
