// Checks, before anything moves, that every stroke can be drawn.
//
// Each stroke is checked in two passes. The first samples the surface at points of the stroke, all
// where it bends, and at least every surface_step. It checks that the surface exists, is unbroken
// and is not too steep (surface_walk.h). The second places the arm every `step` along the parts
// that pass.
// Each posture follows from the previous one (posture_check.h) and is checked for
//   reach      the tip reaches the point with the pen along −n; n is the surface normal averaged
//              over normal_smoothing, or z_P with `vertical_pen`
//   joints     every joint is at least joint_margin inside its range and does not jump
//   singular   the tip's greatest effective mass stays below space.max_effective_mass, the
//              controller's criterion
//   torque     |g_j − J_jᵀ n F| + μ F |J_jᵀ across n| ≤ torque_share × limit: at rest, with push F
//              and friction μ F in any direction across it
//   collision  the arm's bodies and the pen's shaft against the canvas and the table (clearance.h)
// Bisection locates each change of the verdict to edge_tolerance, on the good side.
//
// Drawable parts and findings together cover each stroke from end to end. At the start of a
// drawable part the arm arrives through the air. check_transitions checks these motions once the
// path is planned.
//
// Not checked: features narrower than the sample spacing; torque of motion; self-collision;
// postures other than those that inverse kinematics finds from the previous one, from rest_q and
// from start_q.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/control/operational_space.h"
#include "impedraw/drawing/placement.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/planning/stroke_part.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

enum class Problem {
  off_canvas,  // no surface: beyond its edge, or a hole
  fold,        // the surface jumps in height; both sides may be drawable
  crease,      // two sides of the surface meet like an open book; both may be drawable
  too_rough,   // rougher than the cameras resolve: ink would lie off its place
  too_steep,
  out_of_reach,
  joint_limit,
  near_singular,
  torque,
  arm_collision,
  pen_collision,
  joint_jump,  // no continuous posture across this point; both sides may be drawable
  crawls,      // would be drawn slower than least_speed (crawl.h)
  too_short    // drawable, but too short between parts that are not
};
const char* name_of(Problem problem) noexcept;

struct PreflightSettings {
  Pose X_WP;                  // drawing frame: strokes and surface are in P
  bool vertical_pen = false;  // pen along −z_P, else along −n
  // q_0, to which the controller's null space pulls [rad]; default: start_q
  std::optional<JointVector> rest_q;
  double speed = 0.25;  // of the tip along the strokes [m/s]

  bool arm = true;     // false: only the surface is checked; the arm is assumed to reach all of it
  double step = 4e-3;  // between postures, along a stroke [m]
  double surface_step = 1e-3;    // largest distance between surface samples [m]
  double edge_tolerance = 1e-4;  // accuracy of the ends of parts [m]
  // distance kept from the surface's edges and holes, along the stroke [m]
  double edge_margin = 1e-3;
  double shortest = 5e-3;  // shortest part worth lowering the pen for [m]
  // Mean speed of the drawing, at most half of the drawing speed. Where the surface or the arm's
  // joints slow a stretch down to less than two thirds of it, it is left out, and more until the
  // mean is kept; 0: all is drawn, however slowly [m/s]. Not by check_strokes: by the planned path.
  double least_speed = 15e-3;

  // RMS misfit of a patch of at most 8 mm beyond which a place is too rough (Roughness of
  // perception/normals.h) [m]. A ball of radius r touches at r sin α off the line, α between true
  // and estimated normal. 0.2 mm in waves of 4 mm are slopes of 18° RMS: for r = 1 mm, 0.6 mm at
  // two standard deviations, and ink counts within 0.5 mm. Not by check_strokes: by the surface
  // that it is given.
  double roughest = 2e-4;

  double max_slope_deg = 75;       // between the surface's normal and z_P
  double fold_height = 0.5e-3;     // the pen's tip rides over lower steps [m]
  double normal_smoothing = 5e-3;  // as in PathSettings [m]
  double lean_deg = 0;             // as in PathSettings

  double joint_margin = 0.05;      // the controller holds a posture to about 0.03 rad [rad]
  double max_joint_step = 0.35;    // of any joint per `step` [rad]
  OperationalSpaceSettings space;  // the controller's
  double torque_share = 1.0;       // usable share of the arm's limits
  double normal_force = 5.0;       // F [N]
  double friction = 0.3;           // μ

  // of arm and pen from canvas and table [m]; the pen's grows from 0 at the tip (clearance.h)
  double clearance = 5e-3;
  double tip_length = 5e-3;  // of the pen above its tip, which may be near the canvas [m]
  // By how much the surface may be higher than known at a point of W [m]; default: nowhere. The pen
  // keeps that much further off.
  std::function<double(const Eigen::Vector3d&)> height_error;
  std::optional<double> table_z;  // height of an infinite table [m], W; default: none
};

// Throws InputError naming the setting, its value and the allowed range.
void validate(const PreflightSettings& settings);

// The end of a stroke at which the way to it or off it fails.
enum class WayEnd { none, first, last };

struct Finding {
  StrokePart part{};
  Problem problem = Problem::off_canvas;
  std::string text;  // the problem and its size at the worst point: "23 mm too far"
  Eigen::Vector2d page_mm = Eigen::Vector2d::Zero();  // the worst point
  // the worst point [m]; off the canvas: at the height where the stroke left it, or of P's origin
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  WayEnd way = WayEnd::none;
};

// Worst values over the drawable parts.
struct PreflightMargins {
  double joint = std::numeric_limits<double>::infinity();  // to the nearest limit [rad]
  double torque_share = 0;                                 // of the arm's limits
  double effective_mass = 0;                               // the tip's greatest [kg]
  // of the arm without its pen, at most kFarEnough (clearance.h) [m]
  double clearance = std::numeric_limits<double>::infinity();
  double slope_deg = 0;
};

struct Preflight {
  std::vector<Finding> findings;     // ordered by stroke, then along it
  std::vector<StrokePart> drawable;  // in the same order
  PreflightMargins margins;
};

// `obstacle`: the object that the arm must not touch, in W, usually the canvas; null: none.
// `start_q`: the arm's posture before it moves. `progress`: called with the share of strokes
// checked so far. Throws InputError for a setting out of range (name, value, limit).
Preflight check_strokes(const std::vector<PlacedStroke>& strokes, const SurfaceHeight& surface,
                        const ArmModel& arm, const Canvas* obstacle, const JointVector& start_q,
                        const PreflightSettings& settings = {},
                        const std::function<void(double)>& progress = {});

// Checks the motions between the strokes of a planned path (travel, approach and lift) every
// centimetre and every 0.1 rad of turn. Each posture follows from the previous one, through the
// strokes too: where one of these fails, though check_strokes found a posture, a finding without
// WayEnd names the part. `strokes` are those the path was planned from.
//
// A finding's part is the whole stroke that the motion leads to; for the way back, the last stroke.
// If the lift is blocked, only the stroke that it leaves is reported. page_mm is the stroke's first
// point. There is at most one finding per problem and motion. Torque is not checked: in the air the
// arm carries only its own weight. `progress`: called now and then with the share of the path's
// time checked so far.
std::vector<Finding> check_transitions(const TipPath& path,
                                       const std::vector<PlacedStroke>& strokes,
                                       const ArmModel& arm, const Canvas* obstacle,
                                       const JointVector& start_q,
                                       const PreflightSettings& settings = {},
                                       const std::function<void(double)>& progress = {});

}  // namespace impedraw
