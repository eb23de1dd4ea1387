// The pen tip's motion in time, for the whole drawing.
//
// The plan alone sets the timing; there is no feedback. The phases of each stroke are
//   travel    straight up from a low start, straight across at the safe height, straight down along
//             the normal; each move from rest to rest
//   approach  from the hover point to the stroke's first point at approach_speed, then held there
//             for settle_time
//   draw      along the stroke on the surface; full stop at corners
//   lift      after end_hold at the last point, along the surface's normal to the safe height
// and `done` after the last lift. The normal n_WD is the surface normal along the stroke. During
// travel it turns about one axis.
//
// While the pen is down, its force is that of the stroke where it is (force_profile.h), or none of
// its own; force_rate is the exact derivative.
//
// A tool's heading may be led (tool_heading.h). p then is E's, and not that of what follows the
// stroke; dψ/du is differenced for the yaw's acceleration, and a is exact but for trail ω × (ω ×
// x).
//
// v and a are the exact derivatives of p, as w and alpha are of n. v, w and a are continuous,
// corners and stops included. Speeds and accelerations always stay within their limits. Along a
// stroke, both are measured on the surface, in 3D.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/control/tip_reference.h"
#include "impedraw/planning/path/force_profile.h"
#include "impedraw/planning/path/path_spline.h"
#include "impedraw/planning/path/speed_profile.h"
#include "impedraw/planning/path/tool_heading.h"

namespace impedraw {

enum class Phase : std::uint8_t { travel, approach, draw, lift, done };

struct PathSample {
  TipReference reference;
  // PlacedStroke::number, ≥ 0, from the instant the desired point leaves the stroke's first point
  // until it reaches its last. For a dot: while it is held.
  int stroke = -1;
  double along = std::numeric_limits<double>::quiet_NaN();  // position on it (stroke_part.h) [m]
  Phase phase = Phase::done;
};

struct StrokeTimes {
  int number = 0;       // PlacedStroke::number
  double approach = 0;  // start of the approach [s]
  double start = 0;     // the desired point leaves the first point [s]
  double end = 0;       // the desired point reaches the last point [s]
  double length = 0;    // pen-down length on the surface [m]
};

// One segment of the path in time, with a single law of motion: along a spline, or straight from a
// point. Large drawings have a million, which share points and normals; the rest is found anew.
struct PathLeg {
  double start = 0;  // [s]
  double along = 0;  // without a spline: position on its stroke [m]
  int place = 0;     // of PathParts: the spline, or the point at the start
  int normal = 0;    // n at the start, of PathParts
  int stroke = -1;   // in the order of the path, while the pen is down
  Phase phase = Phase::travel;
  bool counts : 1 = false;  // PathSample::stroke is that stroke
  bool splined : 1 = false;
  bool moves : 1 = false;   // to the next of the points
  bool turns : 1 = false;   // n turns to the next of the normals
  bool evenly : 1 = false;  // it moves in proportion to the turn, which would take longer
};
// From rest to rest along or about a unit vector [m, rad].
struct PathMove {
  Eigen::Vector3d direction;
  SpeedSpan progress;
};
// `limits`: its speed and acceleration count.
PathMove move_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to, SpeedSpan limits);
PathMove turn_between(const Eigen::Vector3d& n, const Eigen::Vector3d& to, SpeedSpan limits);
// The part of a led heading that the splines lack: x at the leg's start, which n carries along, and
// its turn about n, the other way round if `back`.
struct PathSpin {
  Eigen::Vector3d x;
  SpeedSpan progress{};  // [rad]
  bool back = false;
};
// A smooth line on the surface, and how the pen moves along it.
struct TimedSpline {
  PathSpline line;
  SpeedProfile progress;  // of u [m]
};
struct PathParts {
  std::vector<PathLeg> legs;
  std::vector<Eigen::Vector3d> points, normals;  // where p and n have come to off the splines
  std::vector<TimedSpline> splines;
  Eigen::Vector3d below = Eigen::Vector3d::Zero();  // that moves the splines [m]
  bool fixed_normals = false;                       // those of the splines do not count
  std::vector<PathSpin> spins;                      // of every leg, or none
  std::optional<ToolHeading> heading;
  std::vector<double> pauses;            // as in TipPath [s]
  SpeedSpan approaches, travels, turns;  // limits of moves, of other moves, and of turns
  double smoothing_time = 0;             // of moves, turns and spins [s]
  double highest = 0;                    // place of the surface that the ways pass over, in P [m]
  double duration = 0;                   // of all legs [s]

  PathMove move(const PathLeg& leg) const {
    return move_between(points[leg.place], points[leg.place + 1],
                        leg.phase == Phase::approach ? approaches : travels);
  }
  PathMove turn(const PathLeg& leg) const {
    return turn_between(normals[leg.normal], normals[leg.normal + 1], turns);
  }
};

class TipPath {
 public:
  TipPath() = default;
  // `numbers`: the strokes' numbers, in path order. The parts are in the drawing frame P; samples
  // are in W. `forces`: of each stroke, or none.
  TipPath(PathParts parts, const std::vector<int>& numbers, const Pose& X_WP,
          std::vector<ForceProfile> forces);

  double duration() const noexcept { return parts_.duration; }  // [s]
  // Allocates nothing. t is clamped to [0, duration].
  PathSample at(double t) const noexcept;

  // PathSettings::highest_z, as it was planned with [m].
  double highest_z() const noexcept { return parts_.highest; }
  // When the run waits until it is told to go on: the pen is up and at rest then [s].
  const std::vector<double>& pauses() const noexcept { return parts_.pauses; }
  const std::vector<StrokeTimes>& strokes() const noexcept { return strokes_; }
  double mean_speed() const noexcept;  // along the strokes; infinite if they take no time [m/s]
  double pen_down_length() const noexcept;  // total over all strokes, on the surface [m]

 private:
  void lead(const PathLeg& leg, double since, TipReference* reference) const noexcept;

  PathParts parts_;
  std::vector<StrokeTimes> strokes_;
  std::vector<ForceProfile> forces_;
  Pose X_WP_;
};

}  // namespace impedraw
