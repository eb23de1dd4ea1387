// How far along a path to be at which time: from rest to rest, as fast as the limits let, without
// steps in acceleration.
//
// The path is a row of spans, each with a length, a highest speed and a highest acceleration along
// it. Two steps:
//   1. forward and backward over the spans, v² ≤ v₀² + 2 a l: the fastest profile of constant
//   accelerations, x(t);
//   2. its running mean over the time T, x_s(t) = 1/T ∫ x(τ) dτ over [t − T, t], in closed form.
// The mean of what stays within a limit stays within it. So that it also does where the limit
// changes, each span first takes the lowest limits within the length that can be covered in T. The
// jerk is then at most twice the acceleration over T, and the profile ends T later.
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
  SpeedProfile() = default;                                           // of no length and no time
  SpeedProfile(std::vector<SpeedSpan> spans, double smoothing_time);  // T ≥ 0 [s]

  double duration() const { return pieces_.empty() ? 0 : end_ + smoothing_; }  // [s]
  double length() const { return length_; }
  SpeedState at(double t) const noexcept;  // held at its ends outside of [0, duration]

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
