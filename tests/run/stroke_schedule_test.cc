// Orders of strokes with windows, against trying every order.
#include "impedraw/run/carried_plan.h"

#include <algorithm>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "seeds.h"

namespace impedraw {
namespace {

TEST(StrokeSchedule, KeepsThePlannedOrderWhereItHolds) {
  const std::vector<StrokeJob> jobs(3, {2.0, {{0.0, 100.0}}});
  const StrokeSchedule s = schedule_strokes(jobs, 1.0, 0.5);
  ASSERT_EQ(s.slots.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(s.slots[i].job, i);
    EXPECT_DOUBLE_EQ(s.slots[i].start, 1.0 + 2.5 * static_cast<double>(i));
  }
}

TEST(StrokeSchedule, WhatLeavesFirstIsDrawnFirst) {
  const StrokeSchedule s = schedule_strokes({{4.0, {{0.0, 20.0}}}, {4.0, {{0.0, 6.0}}}}, 1.0, 1.0);
  ASSERT_EQ(s.slots.size(), 2u);
  EXPECT_EQ(s.slots[0].job, 1u);
  EXPECT_TRUE(s.lost.empty());
}

TEST(StrokeSchedule, WaitsForAWindowAndNamesWhatFitsNowhere) {
  const StrokeSchedule s =
      schedule_strokes({{2.0, {{5.0, 8.0}, {15.0, 18.0}}}, {4.0, {{0.0, 3.0}}}}, 6.5, 1.0);
  ASSERT_EQ(s.slots.size(), 1u);
  EXPECT_DOUBLE_EQ(s.slots[0].start, 15.0);
  EXPECT_EQ(s.lost, std::vector<std::size_t>{1});
}

// Never fewer strokes than the planned order draws; and seldom fewer than the best of all orders.
TEST(StrokeSchedule, RandomWindowsAgainstAllOrders) {
  const unsigned count = seeds(100, 2000);
  int worse = 0;
  for (unsigned seed = 0; seed < count; ++seed) {
    std::mt19937 random(seed);
    const auto uniform = [&](double a, double b) { return a + (b - a) * random() / 4294967295.0; };
    std::vector<StrokeJob> jobs(4);
    for (StrokeJob& job : jobs) {
      job.duration = uniform(1.0, 4.0);
      for (double t = uniform(0.0, 6.0); t < 20.0; t += uniform(2.0, 6.0)) {
        job.windows.push_back({t, t + job.duration + uniform(0.0, 6.0)});
        t = job.windows.back().until;
      }
    }
    const StrokeSchedule s = schedule_strokes(jobs, 1.0, 0.5);
    EXPECT_EQ(s.slots.size() + s.lost.size(), jobs.size());
    double free = 1.0;
    for (const StrokeSlot& slot : s.slots) {
      EXPECT_GE(slot.start, free);
      EXPECT_GE(slot.start, slot.window.from);
      EXPECT_LE(slot.start + jobs[slot.job].duration, slot.window.until + 1e-6);
      free = slot.start + jobs[slot.job].duration + 0.5;
    }
    std::vector<std::size_t> order(jobs.size());
    std::iota(order.begin(), order.end(), 0);
    std::size_t best = 0, planned = 0;
    bool first = true;
    do {
      double time = 1.0;
      std::size_t drawn = 0;
      for (const std::size_t job : order)
        for (const ReachWindow& w : jobs[job].windows)
          if (std::max(time, w.from) + jobs[job].duration <= w.until) {
            time = std::max(time, w.from) + jobs[job].duration + 0.5;
            ++drawn;
            break;
          }
      if (first) planned = drawn;
      first = false;
      best = std::max(best, drawn);
    } while (std::next_permutation(order.begin(), order.end()));
    EXPECT_GE(s.slots.size(), planned);
    worse += s.slots.size() < best;
  }
  EXPECT_LE(worse, static_cast<int>(count / 10));
}

}  // namespace
}  // namespace impedraw
