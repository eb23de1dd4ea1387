// By how much frames' time stamps are later than their exposures, as a pen on a canvas that moves
// tells it.
//
// A frame stamped t shows the canvas as it was at t − δ. A tip that touches the canvas is on it at
// t; over the surface as the frame shows it, it seems to be at
//
//   h = h_0 + δ n·v      v: of the tip, whose part along n is the canvas's
//
// δ by least squares over all frames, with h_0 for what the surface's estimate and the tip's give
// are off by. It counts once its standard deviation is below kSurely and a third of δ, and anew
// where it has changed by more than that. A canvas that stands tells nothing.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace impedraw {

class StampLag {
 public:
  static constexpr double kSurely = 1e-3, kMost = 0.05;  // [s]
  static constexpr double kApart = 0.04;  // between frames that tell as much as one each [s]
  static constexpr double kFewest = 20.0;
  static constexpr double kUneven = 3e-5;  // of h_0 along a line, as n·v may vary, too [m]

  // Takes n·v [m/s] and h [m] of a frame whose stamp was taken to be lag() late, and the time since
  // the frame before [s].
  void add(double speed, double height, double since) noexcept {
    if (!std::isfinite(height)) return;
    const double w = std::clamp(since / kApart, 0.0, 1.0), h = height + speed * lag_;
    count_ += w;
    v_ += w * speed;
    h_ += w * h;
    vv_ += w * speed * speed;
    vh_ += w * speed * h;
    hh_ += w * h * h;
    const double vv = vv_ - v_ * v_ / count_, vh = vh_ - v_ * h_ / count_,
                 hh = hh_ - h_ * h_ / count_;
    if (count_ < kFewest || !(vv > 0.0)) return;
    const double delta = vh / vv;
    const double noise = std::max(0.0, hh - delta * vh) / (count_ - 2.0);
    deviation_ = std::sqrt((noise + count_ * kUneven * kUneven) / vv);
    const bool known = deviation_ < kSurely && 3.0 * deviation_ < std::abs(delta);
    if (known && std::abs(delta) < kMost && std::abs(delta - lag_) > deviation_) lag_ = delta;
  }
  double lag() const noexcept { return lag_; }              // δ; 0: not known [s]
  double deviation() const noexcept { return deviation_; }  // standard, of δ [s]

 private:
  double count_ = 0.0, v_ = 0.0, h_ = 0.0, vv_ = 0.0, vh_ = 0.0, hh_ = 0.0;
  double lag_ = 0.0, deviation_ = std::numeric_limits<double>::infinity();
};

}  // namespace impedraw
