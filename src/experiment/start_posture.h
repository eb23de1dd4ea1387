// The posture in which an arm starts, and the settings that have one entry per joint.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/common/pose.h"
#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/belief.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/settings/setting_error.h"

namespace impedraw {

// Throws InputError if a setting of the joints is given with another number of entries than the arm
// of `urdf` has joints, or a posture of the settings or of the description is beyond their ranges.
void check_joint_settings(const Scenario& scenario, const std::filesystem::path& urdf,
                          const ArmModel& arm, const SettingErrors& setting_errors);

inline constexpr double kMarginLength = 0.3;  // converts angles to lengths [m/rad]

// The margin of a posture, as place_auto.h defines it: 1 in the middle of the joint ranges and far
// from singular, 0 at a limit or singular. `terms` are those of the posture afterwards.
double posture_margin(ArmModel& arm, ArmTerms* terms, const JointVector& q);

// The tip is at arm.start and the pen normal to the drawing plane of X_WP. The inverse kinematics
// starts from arm.posture_seed, else from the rest posture that the arm's description names
// (arm_notes.h). Without one it starts from the iiwa's working posture, for an arm of seven joints,
// and otherwise from postures spread over the joint ranges. Of what these reach, the arm starts
// with the greatest distance from singularities and joint limits, preferably with its links on the
// pen's side of the surface, and so that the tip can be led to just above the places of `drawing`
// [m, W], one after the other, with no link in the canvas. It is searched for so, too, where the
// iiwa's posture does not lead there; and where the default arm.start is out of reach, nearer to
// the base: settings.start_p_WE is set, and a note says so. Where a link touches the canvas in the
// posture from a seed, it is searched for so, too. `touching`: names the link that does; empty:
// none. Throws InputError if arm.start is out of reach, or a link touches in every posture that was
// found.
JointVector start_posture(ArmSettings& settings, ArmModel& arm, const Pose& X_WP,
                          const std::vector<Eigen::Vector3d>& drawing,
                          const SettingErrors& setting_errors,
                          const std::function<std::string(const JointVector&)>& touching,
                          std::vector<std::string>* notes);

// The rest posture of the null space: arm.q_0 if given. Otherwise the tip is on the surface at the
// drawing's centre, or, if there is none, at the middle of the first of `strokes` that has one.
JointVector rest_posture(const ArmSettings& settings, const PlacedArtwork& artwork,
                         const std::vector<PlacedStroke>& strokes, const Belief& belief);

}  // namespace impedraw
