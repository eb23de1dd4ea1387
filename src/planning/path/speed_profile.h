// Position along a path over time: from rest to rest, as fast as the limits permit, with continuous
// acceleration.
//
// The path is a sequence of spans, each with a length, a speed limit and an acceleration limit. Two
// steps:
//   1. forward and backward over the spans, v² ≤ v₀² + 2 a l: the fastest profile of constant
//   accelerations, x(t);
//   2. its running mean over the time T, x_s(t) = 1/T ∫ x(τ) dτ over [t − T, t], in closed form.
// A running mean of values within a limit stays within that limit. For this to hold where limits
// change, each span first takes the lowest limits that the profile of step 1 meets within T. The
// jerk is then at most twice the acceleration divided by T. The profile ends T later.
#pragma once

#include <vector>

namespace impedraw {

struct SpeedSpan {
  double length;        // > 0 [m], or any unit of path
  double speed;         // > 0 [unit/s]
  double acceleration;  // > 0 [unit/s²]
};

struct SpeedState {
  double x = 0;  // along the path
  double speed = 0;
  double acceleration = 0;
};

class SpeedProfile {
 public:
  SpeedProfile() = default;                                           // zero length and duration
  SpeedProfile(std::vector<SpeedSpan> spans, double smoothing_time);  // T ≥ 0 [s]

  double duration() const { return pieces_.empty() ? 0 : end_ + smoothing_; }  // [s]
  double length() const { return length_; }
  SpeedState at(double t) const noexcept;  // t is clamped to [0, duration]

 private:
  struct Piece {
    double start;  // [s]
    double x, speed, acceleration;
    double area;  // ∫ x dt up to here
  };
  struct Raw {
    double area, x, speed, acceleration;
  };
  Raw raw(double t) const noexcept;
  void add(double duration, double speed, double acceleration);

  std::vector<Piece> pieces_;
  double end_ = 0, length_ = 0, area_ = 0, smoothing_ = 0;
};

}  // namespace impedraw
