// Notices that the tip sinks where the cameras saw a surface: into a gap that is narrower than they
// resolve. Held just beneath the surface it would go on, and catch under the gap's far side.
#pragma once

#include <algorithm>
#include <cmath>

namespace impedraw {

class SinkMonitor {
 public:
  static constexpr double kSunk = 1.5e-3;     // below the last touch, or the estimate [m]
  static constexpr double kDeepest = 3.0e-3;  // below the estimated surface, before any touch [m]
  // A surface that holds the tip falls by less, below the estimated one, per way along it. Along
  // the side of a gap the tip is touched, too, and goes down. Blows shorter than kHeld tell
  // nothing [s].
  static constexpr double kSteepest = 2.0, kHeld = 0.03;

  // deepest: below the estimated surface, before any touch [m].
  void reset(double deepest = kDeepest) noexcept {
    *this = {};
    at_touch_ = kSunk - deepest;
  }
  // The surface holds the tip for certain.
  bool held() const noexcept { return held_ >= kHeld; }

  // One cycle with the tip on the surface, or on its way down. distance: to the estimated surface
  // [m]; way: of the tip along it in this cycle [m]; touches: the surface holds the tip. True while
  // the tip is too deep.
  bool update(double distance, double way, bool touches, double dt) noexcept {
    held_ = touches ? held_ + dt : 0.0;
    way_ += way;
    if (touches && std::isfinite(distance)) {
      const double least = held_ < kHeld ? distance : at_touch_ - kSteepest * way_;
      at_touch_ = std::min(0.0, std::max(distance, least));
      way_ = 0.0;
    }
    return distance < at_touch_ - kSunk;
  }

 private:
  double at_touch_ = kSunk - kDeepest;  // [m]
  double way_ = 0.0;                    // since the last touch [m]
  double held_ = 0.0;                   // touched without a break [s]
};

}  // namespace impedraw
