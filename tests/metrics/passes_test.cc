// Metrics of runs that draw a stroke in more than one pass, as a run that goes on or mends gaps
// does; answers known by hand.
#include <gtest/gtest.h>

#include "made_up_rows.h"

namespace impedraw {
namespace {

using namespace testing;

// Stroke 0 is drawn to its half, then another stroke, then the first's second half with 5 mm of the
// first half once more. Passes of 500, 1000 and 600 rows; each touches 100 rows before it begins,
// and hits the canvas with a force of its own.
MadeUp three_passes() {
  MadeUp run = empty_run(6000);
  const auto pass = [&run](int stroke, std::size_t begin, std::size_t rows, double from_mm,
                           double y_mm, double hit, double f) {
    for (std::size_t i = begin - 100; i < begin + rows; ++i) {
      touch(run, i,
            from_mm + 0.05 * std::max(0.0, static_cast<double>(i) - static_cast<double>(begin)),
            y_mm, f);
      if (i >= begin) run.stroke[i] = stroke;
    }
    for (std::size_t i = begin - 100; i < begin; ++i) touch(run, i, from_mm, y_mm, hit);
  };
  pass(0, 500, 500, 0.0, 0.0, 7.0, 4.0);
  pass(1, 2000, 1000, 0.0, 10.0, 8.0, 5.0);
  pass(0, 4500, 600, 20.0, 0.3, 9.0, 6.0);
  add_target(run, 0, 0.0, 50.0);
  add_target(run, 1, 0.0, 50.0, 10.0);
  return run;
}

TEST(Passes, AStrokeMayComeBackInALaterPass) {
  MadeUp run = three_passes();
  EXPECT_EQ(value(run, "contact_fraction"), 1.0);
  EXPECT_EQ(value(run, "strokes_missed"), 0);
  // Ink of stroke 0 ends at 24.95 mm and begins again at 20, 0.3 beside it, to 49.95: no gap.
  EXPECT_NEAR(value(run, "coverage"), 1.0, 1e-12);
  EXPECT_EQ(value(run, "gaps"), 0);
  EXPECT_NEAR(value(run, "ink_error_rms"), std::sqrt(600 * 0.09 / 2100), 1e-12);
  EXPECT_EQ(value(run, "ink_up"), 0.0);
  EXPECT_NEAR(value(run, "draw_time"), 2.1, 1e-9);
  EXPECT_NEAR(value(run, "speed_mean"), 50.0, 1e-9);
  // Each pass settles by itself: rows 101 … of each, 399 + 899 + 499. With the first pass's touch
  // alone the third would count in full.
  EXPECT_NEAR(value(run, "force_mean"), (399 * 4.0 + 899 * 5.0 + 499 * 6.0) / 1797, 1e-12);
  EXPECT_EQ(value(run, "force_peak"), 6.0);
  EXPECT_EQ(value(run, "touchdown_peak"), 9.0);
}

TEST(Passes, APassWithoutInkIsMadeUpByAnother) {
  MadeUp run = three_passes();
  for (std::size_t i = 300; i < 1000; ++i) lift(run, i);  // the first pass: 500 rows without ink
  EXPECT_NEAR(value(run, "contact_fraction"), 1600.0 / 2100.0, 1e-12);
  EXPECT_EQ(value(run, "strokes_missed"), 0);
  // Of stroke 0 the ink begins at 20 mm, 0.3 beside the line: covered from 19.6 mm on.
  EXPECT_NEAR(value(run, "coverage"), 1.0 - 19.6 / 100.0, 1e-9);
  EXPECT_EQ(value(run, "gaps"), 1);
  EXPECT_NEAR(value(run, "longest_gap"), 19.6, 1e-9);
  EXPECT_NEAR(value(run, "force_mean"), (899 * 5.0 + 499 * 6.0) / 1398, 1e-12);
  for (std::size_t i = 4000; i < 6000; ++i) lift(run, i);  // and the third
  EXPECT_EQ(value(run, "strokes_missed"), 1);
  EXPECT_EQ(value(run, "touchdown_peak"), 8.0);
}

// Between two passes of one stroke the pen is up as between any others; ink there is a fault but
// within 0.5 s of their ends.
TEST(Passes, InkBetweenPassesOfOneStroke) {
  MadeUp run = three_passes();
  std::fill(run.stroke.begin() + 2000, run.stroke.begin() + 3000,
            0);  // 500 … 999, 2000 … 2999, 4500 … 5099: all stroke 0
  for (std::size_t i = 3000; i < 4400; ++i) touch(run, i, 0.1 * static_cast<double>(i));
  // Free: up to row 3500 and from 4000 on; left: 3501 … 3999, so 498 pieces of 0.1 mm.
  EXPECT_NEAR(value(run, "ink_up"), 49.8, 1e-9);
}

}  // namespace
}  // namespace impedraw
