// Selects the steps that become rows of a reduced log: every 16th step (62.5 Hz at 1 kHz), the
// steps with the smallest and largest normal force among each 128, each step at which the stroke or
// the contact state changes, and the last step.
#pragma once

#include <vector>

#include "impedraw/log/log.h"

namespace impedraw {

class RowSelection {
 public:
  static constexpr int kStride = 16;
  static constexpr int kWindow = 8 * kStride;  // steps buffered before their extremes are known

  explicit RowSelection(int joints);

  // Adds the next step, whose normal force is `force`. Calls `keep` with each row selected by then,
  // in order of time. Allocates nothing.
  template <typename Keep>
  void add(const LogRow& row, double force, Keep&& keep) {
    rows_[count_] = row;
    if (count_ == 0 || force < least_force_) least_ = count_, least_force_ = force;
    if (count_ == 0 || force > largest_force_) largest_ = count_, largest_force_ = force;
    changed_[count_] = row.mode != mode_ || row.stroke != stroke_;
    mode_ = row.mode;
    stroke_ = row.stroke;
    if (++count_ == kWindow) give(keep);
  }

  // Call after the last step, which is always kept.
  template <typename Keep>
  void finish(Keep&& keep) {
    if (count_ == 0) return;
    changed_[count_ - 1] = true;
    give(keep);
  }

 private:
  template <typename Keep>
  void give(Keep&& keep) {
    for (int i = 0; i < count_; ++i)
      if (i % kStride == 0 || i == least_ || i == largest_ || changed_[i]) keep(rows_[i]);
    count_ = 0;
  }

  std::vector<LogRow> rows_;
  std::vector<char> changed_;
  int count_ = 0, least_ = 0, largest_ = 0, mode_ = -1, stroke_ = -1;
  double least_force_ = 0.0, largest_force_ = 0.0;
};

inline RowSelection::RowSelection(int joints) : rows_(kWindow, LogRow(joints)), changed_(kWindow) {}

}  // namespace impedraw
