// Runs that nobody simulated: a sine in the standard bowl with small errors (to look at), and rows
// of known content (to test the file).
#pragma once

#include <functional>

#include "impedraw/log/log.h"

namespace impedraw::testing {

struct MadeUpSine {
  bool perception = true;
  double force_noise = 0.02;  // [N]
  double wander = 0.03e-3;    // amplitude of the sideways error [m]
  double time_step = 1e-3;    // [s]
  int repeat = 1;             // how often the sine is drawn, each its own stroke
  unsigned seed = 1;
};

RunLogHeader sine_header(const MadeUpSine& settings);
// Calls take(row) for each row of the run.
void sine_rows(const MadeUpSine& settings, const std::function<void(const LogRow&)>& take);

// Two joints, two terms, no canvas: the smallest header.
RunLogHeader small_header();
// Row i of a run in which every value of every dataset differs from every other.
LogRow numbered_row(int i);

}  // namespace impedraw::testing
