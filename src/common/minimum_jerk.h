// The motion of least jerk from rest to rest: σ(u) = u³ (10 − 15 u + 6 u²), u of 0 to 1.
//
// Source: T. Flash, N. Hogan, "The coordination of arm movements", J. Neuroscience 5(7), 1985.
#pragma once

namespace impedraw {

struct MinimumJerk {
  double share = 0.0;               // of the way, σ
  double rate = 0.0, change = 0.0;  // its derivatives by time [1/s], [1/s²]

  // u: share of the time, 0 to 1; duration: of the motion, more than 0 [s].
  static MinimumJerk at(double u, double duration) noexcept {
    return {u * u * u * (10.0 + u * (6.0 * u - 15.0)),
            30.0 * u * u * (1.0 - u) * (1.0 - u) / duration,
            60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (duration * duration)};
  }
};

}  // namespace impedraw
