// Tracks which parts of the strokes have ink, from contact state and measured force. Uses no
// simulator truth. A hand that lifts the pen with the force of the push reads like the surface and
// counts as ink until the contact state changes.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "impedraw/planning/stroke_part.h"

namespace impedraw {

class InkWatch {
 public:
  // A pen writes if it is in contact and the force, if measured, is at least this [N].
  static double least_force(double push) { return std::max(0.3, 0.1 * push); }

  // Adds samples in drawing order. `stroke` < 0: the plan is between strokes.
  void add(int stroke, double along, bool writes) {
    if (stroke < 0 || !writes) {
      open_ = false;
    } else if (open_ && parts_.back().stroke == stroke) {
      parts_.back().from = std::min(parts_.back().from, along);
      parts_.back().to = std::max(parts_.back().to, along);
    } else {
      parts_.push_back({stroke, along, along});
      open_ = true;
    }
  }

  // The parts that have ink.
  const std::vector<StrokePart>& parts() const { return parts_; }

 private:
  std::vector<StrokePart> parts_;
  bool open_ = false;
};

}  // namespace impedraw
