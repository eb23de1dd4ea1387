// The whole drawing as a motion of the pen tip in time.
//
// Timed by the plan alone, with no feedback: for each stroke
//   travel    straight up from a low start, straight across at the safe height, straight down along
//             the normal; rest to rest each
//   approach  from the hover point to the stroke's first point at approach_speed, then held there
//             for settle_time
//   draw      along the stroke on the surface; full stop at corners
//   lift      after end_hold at the last point, along the surface's normal to the safe height
// and `done` once the last lift has ended. The normal n_WD is the surface's along the stroke and
// turns about one axis during travel.
//
// p, v and a are each other's exact derivatives, as are n, w and alpha. v and w are continuous, and
// so is a (no step in acceleration), corners and stops included. Speeds and accelerations stay
// within their limits everywhere; along a stroke both count on the surface, in 3D.
#pragma once

#include <limits>
#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/control/tip_reference.h"
#include "impedraw/planning/path/path_spline.h"
#include "impedraw/planning/path/speed_profile.h"

namespace impedraw {

enum class Phase { travel, approach, draw, lift, done };
const char* name_of(Phase phase) noexcept;

struct PathSample {
  TipReference reference;
  // PlacedStroke::number, ≥ 0, from the instant the desired point leaves the stroke's first point
  // until it reaches its last; a dot: while it is held.
  int stroke = -1;
  double along = std::numeric_limits<double>::quiet_NaN();  // and where on it (stroke_part.h) [m]
  Phase phase = Phase::done;
};

struct StrokeTimes {
  int number = 0;       // PlacedStroke::number
  double approach = 0;  // start of the approach [s]
  double start = 0;     // the desired point leaves the first point
  double end = 0;       // and has reached the last
  double length = 0;    // pen-down, on the surface [m]
};

// One stretch of the path between two instants, during which one rule holds.
struct PathLeg {
  double duration = 0;  // [s]
  Phase phase = Phase::travel;
  int stroke = -1;   // in the order of the path
  double along = 0;  // of a dot, on its stroke [m]
  bool pen_down = false;
  int spline = -1;  // ≥ 0: along that spline, moved by `p`; else along the line p + x · direction
  Eigen::Vector3d p = Eigen::Vector3d::Zero();          // [m]
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // unit, or zero
  SpeedProfile progress;                                // of u or x [m]
  bool fixed_normal = true;  // n throughout, turned by `turn`; else the spline's
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d turn_axis = Eigen::Vector3d::UnitX();  // unit, across n
  SpeedProfile turn;                                     // [rad]
};

class TipPath {
 public:
  TipPath() = default;
  // `numbers`: of the strokes, in the order of the path. Legs and splines are in the drawing frame
  // P; samples are in W.
  TipPath(std::vector<PathLeg> legs, std::vector<PathSpline> splines,
          const std::vector<int>& numbers, const Pose& X_WP = {});

  double duration() const noexcept {
    return starts_.empty() ? 0 : starts_.back() + legs_.back().duration;
  }  // [s]
  PathSample at(
      double t) const noexcept;  // allocates nothing; held at its ends outside of [0, duration]

  const std::vector<StrokeTimes>& strokes() const noexcept { return strokes_; }
  double pen_down_length() const noexcept;  // of all strokes, on the surface [m]

 private:
  std::vector<PathLeg> legs_;
  std::vector<double> starts_;  // of the legs [s]
  std::vector<PathSpline> splines_;
  std::vector<StrokeTimes> strokes_;
  Pose X_WP_;
};

}  // namespace impedraw
