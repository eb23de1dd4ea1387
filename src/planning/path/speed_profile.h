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
  double length = 0;        // > 0 [m], or any unit of path
  double speed = 0;         // > 0 [unit/s]
  double acceleration = 0;  // > 0 [unit/s²]
};

struct SpeedState {
  double x = 0;  // along the path
  double speed = 0;
  double acceleration = 0;
};

// A part of the profile of step 1, of constant acceleration.
struct SpeedPiece {
  double start;  // [s]
  double x, speed, acceleration;
  double area;  // ∫ x dt up to here
};
struct SpeedTotals {
  double end = 0;     // [s]
  double length = 0;  // of all pieces
  double area = 0;    // ∫ x dt over all of them
};

class SpeedProfile {
 public:
  SpeedProfile() = default;                                           // zero length and duration
  SpeedProfile(std::vector<SpeedSpan> spans, double smoothing_time);  // T ≥ 0 [s]

  double duration() const { return pieces_.empty() ? 0 : totals_.end + smoothing_; }  // [s]
  double length() const { return totals_.length; }
  SpeedState at(double t) const noexcept;  // t is clamped to [0, duration]

 private:
  std::vector<SpeedPiece> pieces_;
  SpeedTotals totals_;
  double smoothing_ = 0;
};

// The profile of one span, of which nothing but the span is kept: a drawing of 100,000 strokes has
// a million of them. The values are those of SpeedProfile({span}, smoothing_time).
double rest_to_rest_duration(const SpeedSpan& span, double smoothing_time) noexcept;  // [s]
SpeedState rest_to_rest(const SpeedSpan& span, double smoothing_time, double t) noexcept;

}  // namespace impedraw
