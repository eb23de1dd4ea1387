// Can all of a drawing be drawn? Asked before anything moves.
//
// Each stroke is walked twice. Over the surface, at each of its points and every surface_step
// between: is there a surface, is it whole, how steep is it (surface_walk.h). Then with the arm,
// every `step` along what that leaves: each posture follows from the last (posture_check.h) and is
// checked for
//   reach      the tip gets there, the pen along −n, n the surface's normal averaged over
//              normal_smoothing, or z_P with `vertical_pen`
//   joints     every joint joint_margin within its range, and no jump on from the last posture
//   singular   the tip's greatest effective mass stays under space.max_effective_mass: the loop's
//              own criterion
//   torque     |g_j − J_jᵀ n F| + μ F |J_jᵀ across n| ≤ torque_share × limit: at rest, push F and
//              friction μ F any way across it
//   collision  the arm's bodies and the pen's shaft against the canvas and the table (clearance.h)
// Where the answer changes, the place is bisected to edge_tolerance, on the good side.
//
// Parts that can be drawn and findings together cover each stroke from end to end: nothing is left
// out unsaid. Where a drawable part begins the arm comes anew, through the air: what leads there is
// check_transitions' to check, once the path is planned.
//
// Not seen: what lies between two samples and is narrower than they are apart; torque of motion;
// the arm against itself; other postures than those that inverse kinematics finds from the last,
// from rest_q and from start_q.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/common/range.h"
#include "impedraw/control/operational_space.h"
#include "impedraw/drawing/placement.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/planning/stroke_part.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

enum class Problem {
  off_canvas,  // no surface there: past its edge, or a hole
  fold,        // the surface jumps in height; both sides may be drawable
  too_steep,
  out_of_reach,
  joint_limit,
  near_singular,
  torque,
  arm_collision,
  pen_collision,
  joint_jump,  // no continuous posture leads on; both sides may be drawable
  too_short    // could be drawn, but what lies beside it cannot, and too little is left
};
const char* name_of(Problem problem) noexcept;

struct PreflightSettings {
  Pose X_WP;                  // drawing frame: strokes and surface are in P
  bool vertical_pen = false;  // pen along −z_P, else along −n
  std::optional<JointVector>
      rest_q;  // q_0, to which the controller's null space pulls; left out, start_q [rad]

  bool arm = true;  // else only the surface is looked at, and the arm is taken to reach all of it
  double step = 4e-3;            // between postures, along a stroke [m]
  double surface_step = 1e-3;    // between looks at the surface, at most [m]
  double edge_tolerance = 1e-4;  // of the ends of parts [m]
  // kept from where the surface ends or has a hole, along the stroke [m]
  double edge_margin = 1e-3;
  double shortest = 1e-3;  // of what is left of a stroke; no less is worth lifting the pen for [m]

  double max_slope_deg = 75;       // between the surface's normal and z_P
  double fold_height = 0.5e-3;     // lower steps the pen's tip rides over [m]
  double normal_smoothing = 5e-3;  // as PathSettings' [m]

  double joint_margin = 0.05;      // the loop keeps to a posture by some 0.03 rad [rad]
  double max_joint_step = 0.35;    // of any joint per `step` [rad]
  OperationalSpaceSettings space;  // the controller's
  double torque_share = 1.0;       // of the arm's limits that may be used
  double normal_force = 5.0;       // F [N]
  double friction = 0.3;           // μ

  // of arm and pen from canvas and table [m]; the pen's grows from none at the tip (clearance.h)
  double clearance = 5e-3;
  std::optional<double> table_z;  // height of a table that fills the plane [m], W; left out, none

  struct Limits {
    static constexpr Range step = {1e-4, 0.1};
    static constexpr Range surface_step = Range::positive();
    static constexpr Range edge_tolerance = {1e-6, 0.01};
    static constexpr Range edge_margin = {0.0, 0.1};
    static constexpr Range shortest = {0.0, 1.0};
    static constexpr Range max_slope = {1.0, 89.0};
    static constexpr Range fold_height = {1e-6, 0.1};
    static constexpr Range normal_smoothing = {0.0, 1.0};
    static constexpr Range joint_margin = {0.0, 1.0};
    static constexpr Range max_joint_step = {0.001, 3.0};
    static constexpr Range torque_share = Range::positive();
    static constexpr Range normal_force = {0.0, 1e4};
    static constexpr Range friction = {0.0, 10.0};
    static constexpr Range clearance = {0.0, 0.015};  // half of kFarEnough (clearance.h)
    static constexpr Range table_z = {-2.0, 2.0};
  };
};

// Throws InputError: the setting, its value and what is allowed.
void validate(const PreflightSettings& settings);

struct Finding {
  StrokePart part;
  Problem problem = Problem::off_canvas;
  std::string text;  // what and by how much, at the worst place: "23 mm too far"
  Eigen::Vector2d page_mm = Eigen::Vector2d::Zero();  // the worst place
  Eigen::Vector3d p_W = Eigen::Vector3d::
      Zero();  // [m]; off the canvas: at the height where the stroke left it, or of P's origin
};

// Worst over what can be drawn.
struct PreflightMargins {
  double joint = std::numeric_limits<double>::infinity();  // to the nearest limit [rad]
  double torque_share = 0;                                 // of the arm's limits
  double effective_mass = 0;                               // greatest of the tip [kg]
  double clearance = std::numeric_limits<
      double>::infinity();  // of the arm less its pen, at most kFarEnough (clearance.h) [m]
  double slope_deg = 0;
};

struct Preflight {
  std::vector<Finding> findings;     // in the strokes' order, along each
  std::vector<StrokePart> drawable;  // likewise
  PreflightMargins margins;
};

// `obstacle`: what the arm must not touch, in W; usually the canvas; null: nothing. `start_q`: the
// arm's posture before it moves. `progress`: told the share of the strokes that are checked.
// InputError: a setting out of range (name, value, limit).
Preflight check_strokes(const std::vector<PlacedStroke>& strokes, const SurfaceHeight& surface,
                        ArmModel& arm, const Canvas* obstacle, const JointVector& start_q,
                        const PreflightSettings& settings = {},
                        const std::function<void(double)>& progress = {});

// The ways between the strokes of a planned path: travel, approach and lift, asked every centimetre
// and every 0.1 rad of turn, each posture from the last, the strokes' own included. `strokes` are
// those the path was planned from. Each finding's part is the whole of the stroke that the way
// leads to (the way back from the last: that stroke's), or of the one before where the lift off
// that is barred, and then of that alone; page_mm is its first point; at most one a problem and
// way. Torque is not asked: in the air the arm only holds itself.
std::vector<Finding> check_transitions(const TipPath& path,
                                       const std::vector<PlacedStroke>& strokes, ArmModel& arm,
                                       const Canvas* obstacle, const JointVector& start_q,
                                       const PreflightSettings& settings = {});

}  // namespace impedraw
