// Orders of strokes with windows, and what is begun now, against every order and every start.
#include "impedraw/run/stroke_schedule.h"

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

// Three pieces of a stroke that take 2 s each, 1 s of it down to the canvas, and 1 s up again.
TEST(StrokeSchedule, PiecesThatAdjoinAreDrawnWithoutALift) {
  const auto drawn_now = [](bool continues) {
    std::vector<StrokeJob> jobs(3, {2.0, {{0.0, 7.0}}, 1.0, continues});
    jobs[0].continues = false;
    const StrokeChoice choice = choose_strokes(jobs, 1.0, 1.0, 20.0, true);
    EXPECT_EQ(choice.now.front(), choice.order.lost.empty() ? std::vector<std::size_t>({0, 1, 2})
                                                            : std::vector<std::size_t>({0, 1}));
    return choice.order.end;
  };
  EXPECT_DOUBLE_EQ(drawn_now(true), 5.0) << "down, and 1 s for each";
  EXPECT_DOUBLE_EQ(drawn_now(false), 6.0) << "two of them";
}

// Windows on a grid, so that trying every start is exact.
std::vector<StrokeJob> jobs_on_grid(std::mt19937* random) {
  const auto whole = [&](unsigned from, unsigned to) { return from + (*random)() % (to - from); };
  std::vector<StrokeJob> jobs(whole(1, 5));
  for (StrokeJob& job : jobs) {
    job.duration = whole(1, 4);
    for (double t = whole(0, 12); t < 20.0 && whole(0, 4) > 0; t += whole(1, 8)) {
      job.windows.push_back({t, t + job.duration + whole(0, 6)});
      t = job.windows.back().until;
    }
  }
  return jobs;
}

bool fits(const StrokeJob& job, double start) {
  return std::ranges::any_of(job.windows, [&](const ReachWindow& w) {
    return start >= w.from && start + job.duration <= w.until;
  });
}

// A piece that is in reach too shortly for its own way down is drawn behind another, or never.
TEST(StrokeSchedule, APieceWithoutAWindowIsDrawnBehindAnother) {
  std::vector<StrokeJob> jobs{{2.0, {{1.0, 3.5}}, 1.0}, {2.0, {}, 1.0, true, {{2.5, 4.5}}}};
  StrokeChoice choice = choose_strokes(jobs, 1.0, 1.0, 40.0, true);
  ASSERT_EQ(choice.order.slots.size(), 2u);
  EXPECT_EQ(choice.order.slots[1].start, 2.0);
  EXPECT_EQ(choice.now.front(), (std::vector<std::size_t>{0, 1}));
  jobs[1].behind = {{3.5, 4.5}};
  choice = choose_strokes(jobs, 1.0, 1.0, 40.0, true);
  EXPECT_EQ(choice.order.slots.size(), 1u);
  EXPECT_TRUE(choice.lost.empty()) << "while the piece before it is open";
  choice = choose_strokes({{2.0, {}, 1.0}}, 1.0, 1.0, 40.0, true);
  EXPECT_EQ(choice.lost.size(), 1u);
}

// What is begun now, what is waited for and what is lost, against every start.
TEST(StrokeSchedule, ChoicesAreThoseOfEveryStart) {
  constexpr double kBetween = 1.0, kHorizon = 24.0;
  for (unsigned seed = 0; seed < seeds(300, 5000); ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const std::vector<StrokeJob> jobs = jobs_on_grid(&random);
    const double now = random() % 8;
    const StrokeChoice choice = choose_strokes(jobs, now, kBetween, kHorizon, true);
    const auto can_begin = [&](std::size_t job, double from, double to) {
      for (double t = from; t <= to; t += 1.0)
        if (fits(jobs[job], t)) return true;
      return false;
    };
    // Lost for good: in no slot, and in reach neither at the horizon nor twice.
    std::vector<bool> drawn(jobs.size());
    for (const StrokeSlot& slot : choice.order.slots) drawn[slot.job] = true;
    for (std::size_t job = 0; job < jobs.size(); ++job) {
      int openings = 0;
      for (double t = 0.0; t <= 40.0; t += 1.0)
        openings += fits(jobs[job], t) && !fits(jobs[job], t - 1.0);
      const bool again = openings > 1 || can_begin(job, kHorizon - jobs[job].duration, 40.0);
      EXPECT_EQ(std::ranges::count(choice.lost, job), !drawn[job] && !again) << job;
      if (jobs.size() == 1) {
        EXPECT_EQ(drawn[job], can_begin(job, now, 40.0));
      }
    }
    EXPECT_TRUE(choose_strokes(jobs, now, kBetween, kHorizon, false).lost.empty());
    // Begun now: the first of the order, if it can be, and others that can be now.
    if (choice.order.slots.empty()) {
      EXPECT_TRUE(choice.now.empty());
      continue;
    }
    const StrokeSlot& first = choice.order.slots.front();
    double earliest = now;
    while (!fits(jobs[first.job], earliest)) earliest += 1.0;
    EXPECT_EQ(first.start, earliest);
    ASSERT_EQ(choice.now.empty(), earliest > now);
    if (choice.now.empty()) continue;
    double time = now;
    for (const std::size_t job : choice.now.front()) {
      EXPECT_TRUE(fits(jobs[job], time)) << job << ": without a wait";
      time += jobs[job].duration + kBetween;
    }
    std::vector<std::size_t> alone, expected;
    for (std::size_t k = 1; k < choice.now.size(); ++k) {
      ASSERT_EQ(choice.now[k].size(), 1u);
      alone.push_back(choice.now[k].front());
    }
    for (std::size_t k = 1; k < choice.order.slots.size(); ++k)
      if (const std::size_t job = choice.order.slots[k].job; fits(jobs[job], now))
        expected.push_back(job);
    EXPECT_EQ(alone, expected);
  }
}

}  // namespace
}  // namespace impedraw
