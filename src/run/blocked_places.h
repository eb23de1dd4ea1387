// Places of strokes that the pen keeps off, because something barred its way there.
//
// A path that goes on beyond a blocked place begins kBeyond after it. If the pen is blocked within
// kSame of there again, the distance doubles, time after time, until the obstacle is passed.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "impedraw/planning/stroke_part.h"

namespace impedraw {

class BlockedPlaces {
 public:
  static constexpr double kBefore = 1e-3;     // distance kept before a blocked place [m]
  static constexpr double kBeyond = 2e-3;     // first distance kept behind it [m]
  static constexpr double kSame = 1e-2;       // blocked places as near as this are one place [m]
  static constexpr double kUnreached = 5e-3;  // kept around what the arm cannot follow [m]
  static constexpr std::size_t kMost = 200;   // after so many, a drawing gives up

  // The pen was blocked at this place.
  void add(const StrokePart& at) {
    const bool again = !parts_.empty() && parts_.back().stroke == at.stroke &&
                       std::abs(parts_.back().to - at.to) < kSame;
    beyond_ = again ? 2.0 * beyond_ : kBeyond;
    parts_.push_back({at.stroke, at.from - kBefore, at.to + beyond_});
  }
  // No way leads to this stroke.
  void add_stroke(const StrokePart& stroke) { parts_.push_back(stroke); }
  // The arm cannot follow this part.
  void add_unreached(const StrokePart& part) {
    parts_.push_back({part.stroke, part.from - kUnreached, part.to + kUnreached});
  }

  const std::vector<StrokePart>& parts() const { return parts_; }
  bool full() const { return parts_.size() >= kMost; }

 private:
  std::vector<StrokePart> parts_;  // in the order in which they were found
  double beyond_ = kBeyond;        // the last distance kept [m]
};

}  // namespace impedraw
