// Forecast of the canvas's motion in the next seconds, for planning.
//
// The tracker (canvas_tracker.h) predicts across the frames' lateness, some hundredths of a second.
// A stroke lasts seconds, and what a stroke needs is not the motion's detail but its course. The
// history keeps the estimated poses of the last seconds. A centre p of the canvas and the rotation
// vector φ, R_WK = exp(φ) R_0, are explained by the first of these that leaves no more than
// kUnexplained of them over its window, each of both by itself:
//
//   steady     φ = φ_0 + ω t,  p = p_0 + ∫ exp(ω s) ds v    a screw: conveyor, turntable
//              the same + u t                               a turntable on a conveyor
//   swinging   each coordinate a trend and up to two sinusoids (axis_motion.h), if those of before
//              would have foretold the last 1.5 s
//   steady     the same over the last seconds alone, for a motion that changed
//   either     over 5 s or more, of which jolts leave less than 0.3: a conveyor that shakes
//   unsteady   the mean, for a canvas that is jolted
//
// Windows are tried from long to short: the longer the window, the further the forecast holds.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/perception/axis_motion.h"

namespace impedraw {

class CanvasForecast {
 public:
  enum class Course { unsteady, steady, swinging };

  // X_WK; any time after the history's end [s].
  Pose at(double time) const noexcept;
  Course shift() const noexcept { return shift_; }  // of the centre
  Course turn() const noexcept { return turn_; }
  // RMS of the centre's positions that the forecast does not explain [m], over how long [s].
  double unexplained() const noexcept { return unexplained_; }
  double window() const noexcept { return window_; }
  // As if the canvas stood from now on: one that is moved by hand will stand where nobody knows.
  static CanvasForecast standing(const Pose& X_WK);
  // "moves at 0.060 m/s", "swings at 0.20 Hz" …
  std::string text() const;

 private:
  friend class CanvasHistory;
  Course shift_ = Course::unsteady, turn_ = Course::unsteady;
  double origin_ = 0.0;  // of t [s]
  Eigen::Vector3d centre_K_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_0_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_ = Eigen::Vector3d::Zero(), v_ = Eigen::Vector3d::Zero(),
                  u_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d phi_ = Eigen::Vector3d::Zero(), w_ = Eigen::Vector3d::Zero();
  std::array<AxisWave, 6> waves_{};  // p, then φ
  double unexplained_ = 0.0, window_ = 0.0;
};

class CanvasHistory {
 public:
  static constexpr double kSpan = 12.0, kEvery = 0.05;  // [s]
  static constexpr double kUnexplained = 8e-4;          // [m]

  // centre_K: p, about the middle of what is drawn [m].
  explicit CanvasHistory(const Eigen::Vector3d& centre_K);

  // Keeps one pose every kEvery. Allocates nothing. After a gap longer than kSpan it starts anew.
  void add(double time, const Pose& X_WK) noexcept;
  bool empty() const noexcept { return count_ == 0; }
  // Takes some milliseconds: not for a control step.
  CanvasForecast forecast() const;

 private:
  static constexpr std::size_t kMost = static_cast<std::size_t>(kSpan / kEvery) + 1;
  struct Sample {
    double time = 0.0;
    Pose X_WK;
  };

  Eigen::Vector3d centre_K_;
  std::vector<Sample> samples_;  // a ring
  std::size_t count_ = 0, next_ = 0;
};

}  // namespace impedraw
