// The heading that a plan asks of a blade or a roller, and of the arm that turns it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "impedraw/experiment/plan.h"

namespace impedraw {

// The leading of the tool from the posture q on: its heading there, and how far the arm can turn it
// about its axis on the spot, either way, by inverse kinematics. The arm keeps
// preflight.joint_margin and kHeadingReserve off that: elsewhere its base stands otherwise. Nothing
// for a tool that is not led.
inline constexpr double kHeadingReserve = 0.6;  // [rad]
std::optional<ToolHeading> heading_of(const Scenario& scenario, const ArmModel& arm,
                                      const JointVector& q);

// Cuts strokes that turn the tool further between two corners than the arm can: there it is lifted,
// and turned back. The parts keep their strokes' numbers. Adds a note that says where.
std::vector<PlacedStroke> cut_where_turned(std::vector<PlacedStroke> strokes,
                                           const ToolHeading& heading, double corner_angle,
                                           std::vector<std::string>* notes);

// Throws InputError where the face does not fit the lines or the surface: an edge that is longer
// than a straight between two corners, whose ends leave a bend by more than 0.2 mm, or, on a curved
// surface, do not touch. Nothing for a tool that is not led.
void require_fit(const Scenario& scenario, const Plan& plan, const SurfaceHeight& surface,
                 const SettingErrors& setting_errors);

}  // namespace impedraw
