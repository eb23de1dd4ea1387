// A plan's notes on doubtful places: a rough surface, where the wrap is not certain, where the
// force cannot follow the widths, and why the planner's surface ends.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/drawing/placement.h"
#include "impedraw/experiment/belief.h"
#include "impedraw/experiment/plan.h"
#include "impedraw/perception/normals.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

// A rough surface: a note, and the choice of the pen's axis where the scenario leaves it open.

// Finer patches than the plan's are in use under the drawing: at over a tenth of some 500 places
// along it, perception's normal is 0.02 rad off the plan's.
//
// On a smooth surface the estimated normal is the better axis of the pen, also where a hand pushes
// it off its line, and whatever pushes it aside is a hand. On a rough one the plan's smoothed
// normals are the better axis, and the surface itself pushes the tip aside.
bool is_rough(const Belief& belief, const Plan& plan);

inline constexpr double kRoughNormalError = 30.0;  // [deg]
inline constexpr double kRoughFeltShare = 0.5;     // FeltNormalSettings

// A note on a surface that is too rough for a calm force, as the cameras show it.
//
// The force scatters by heights that the fitted patches do not follow: their residual,
// RMS along the strokes. On plates with noise (0.1 to 1 mm, grid 1 to 6 mm) and ribs (0.3 to 2 mm,
// 5 to 30 mm long) at 50 mm/s and 5 N, the force's standard deviation was 0.4 to 1.1 N above a
// residual of 0.06 mm, and 0.05 to 0.3 N below, but for noise on a grid of 1 mm. Only for cameras
// without noise, which has a residual, too.

// The note, or nullopt on calm ground. `strokes` are in the drawing plane, `X_WP` its pose. Looks
// at the same places.
std::optional<std::string> roughness_note(const std::vector<PlacedStroke>& strokes,
                                          const SurfaceHeight& surface, const Pose& X_WP,
                                          const SurfaceEstimator& seen);

// By how much the drawing would lie elsewhere on the surface, RMS, if the same cells were laid flat
// with the heights as the finest patches see them [m]. 0 where these add nothing; infinite where
// the cells cannot be laid flat with them. The plan must have a wrap.
double wrap_doubt(const Plan& plan, const Belief& belief);
void note_wrap(double doubt, std::vector<std::string>* notes);

// Notes where an engraver is asked for a groove deeper than was held, or on a canvas that may move.
std::vector<std::string> engraver_notes(const Scenario& scenario);

// A note where dry friction of the joints [Nm] is more than a fifth of the normal force at the tip,
// and no wrench shows it; nullopt else. q: a posture on the drawing, n_W the normal there.
// Each joint takes its part of the force away, or adds it, as it turns. On the standard bowl at 5 N
// friction of 0.5 Nm in every joint cost a tenth of the coverage, 1 Nm a sixth of the ink.
std::optional<std::string> friction_note(const Scenario& scenario, ArmModel arm,
                                         const JointVector& q, const Eigen::Vector3d& n_W,
                                         const Eigen::VectorXd& dry_friction);

// Notes where widths change faster than the force may.
void note_spread_forces(const PathSettings& path, Plan* plan);

// Names what ends the surface at the finding: it ends at creases, and at steps that the cameras do
// not resolve (normals.h).
void name_step(const Belief& belief, double roughest, Finding* finding);

}  // namespace impedraw
