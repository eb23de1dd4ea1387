// Which parts of the strokes have ink, by what the arm itself knows: contact state and measured
// force. No simulator's truth in it. A hand that lifts the pen with the force of the push reads as
// the surface does: until the contact state has noticed, that is taken for ink.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "impedraw/planning/stroke_part.h"

namespace impedraw {

class InkWatch {
 public:
  // What counts as a pen that writes: in contact, and where the force is measured, this much of the
  // push [N].
  static double least_force(double push) { return std::max(0.3, 0.1 * push); }

  // In the order in which they are drawn. `stroke` < 0: the plan is drawing none.
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

  // That have ink.
  const std::vector<StrokePart>& parts() const { return parts_; }

 private:
  std::vector<StrokePart> parts_;
  bool open_ = false;
};

}  // namespace impedraw
