// Leans of a tool, off the drawing axis, on its way to a stroke and off it. Where a joint comes to
// the end of its range on a way, or a link near the canvas, another lean may be free: each is tried
// before the stroke is shortened.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>

#include "impedraw/drawing/placement.h"
#include "impedraw/planning/preflight/preflight.h"

namespace impedraw {

class WayLeans {
 public:
  // Takes the next lean for the way at this end. False: all have been tried, and the first one is
  // taken for what is left of the stroke.
  bool try_next(WayEnd end) {
    std::size_t& tried = end == WayEnd::first ? there_ : off_;
    tried = std::min(tried + 1, kLeans.size());
    return tried < kLeans.size();
  }

  void give(PlacedStroke* stroke) const {
    stroke->lean_there = lean(there_);
    stroke->lean_off = lean(off_);
  }

 private:
  static constexpr double kDegree = std::numbers::pi / 180.0;
  static constexpr std::array kLeans{PlacedStroke::kWayLean, 20.0 * kDegree, 50.0 * kDegree,
                                     5.0 * kDegree};
  static double lean(std::size_t tried) { return kLeans[tried < kLeans.size() ? tried : 0]; }

  std::size_t there_ = 0, off_ = 0;  // numbers of leans that were tried and failed
};

}  // namespace impedraw
