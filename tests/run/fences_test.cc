// Fences against values known by hand, and runs that a fence, an emergency stop or a fault ends.
#include "impedraw/run/monitors/fence_monitor.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/experiment/prepare.h"
#include "impedraw/run/incident.h"
#include "impedraw/run/simulated_arm.h"
#include "log/run_columns.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double kDt = 1e-3;

FenceSettings all_fences() {
  FenceSettings settings;
  settings.low = {-0.1, -0.2, 0.0};
  settings.high = {0.1, 0.2, 0.5};
  settings.force = 20.0;
  settings.speed = 0.3;
  return settings;
}

TEST(FenceMonitor, ATipBeyondTheBoxCrossesItAtOnceAndOnlyOnce) {
  const Vector3d inside(0.05, -0.1, 0.2), none = Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool above : {false, true}) {
      const FenceSettings settings = all_fences();
      FenceMonitor fences(settings, true);
      EXPECT_FALSE(fences.update(inside, none, none, kDt));
      EXPECT_EQ(fences.crossed(), "");
      Vector3d p = inside;
      p[axis] = above ? settings.high[axis] + 1e-6 : settings.low[axis] - 1e-6;
      EXPECT_TRUE(fences.update(p, none, none, kDt));
      EXPECT_THAT(fences.crossed(), StartsWith(above ? "fence.high: the tip's " : "fence.low: "));
      EXPECT_THAT(fences.crossed(), HasSubstr(std::string("the tip's ") + "xyz"[axis]));
      EXPECT_FALSE(fences.update(p, none, none, kDt));
    }
  }
}

TEST(FenceMonitor, ForceAndSpeedMustStayBeyondForThreeCycles) {
  const Vector3d p(0.0, 0.0, 0.2), none = Vector3d::Zero();
  const Vector3d hard(12.0, 0.0, 16.1), soft(12.0, 0.0, 15.9), fast(0.0, 0.301, 0.0);
  FenceMonitor force(all_fences(), true);
  for (int i = 0; i < 100; ++i)  // two in a row, again and again
    EXPECT_FALSE(force.update(p, none, i % 3 == 0 ? soft : hard, kDt));
  EXPECT_FALSE(force.update(p, none, hard, kDt));
  EXPECT_FALSE(force.update(p, none, hard, kDt));
  EXPECT_TRUE(force.update(p, none, hard, kDt));
  EXPECT_EQ(force.crossed(), "fence.force: the force on the tip was 20.1 N, the fence is 20.0 N");
  FenceMonitor speed(all_fences(), true);
  EXPECT_FALSE(speed.update(p, fast, none, kDt));
  EXPECT_FALSE(speed.update(p, fast, none, kDt));
  EXPECT_TRUE(speed.update(p, fast, none, kDt));
  EXPECT_EQ(speed.crossed(), "fence.speed: the tip moved at 0.301 m/s, the fence is 0.300 m/s");
}

TEST(FenceMonitor, AMeasuredWrenchHasFencesByDefault) {
  const Vector3d p(0.0, 0.0, 0.2), none = Vector3d::Zero();
  const auto crossed = [&](bool measured, const Vector3d& f, const Vector3d& m, double lag) {
    FenceMonitor fences(FenceSettings(), measured);
    int cycles = 1;
    while (cycles < 200 && !fences.update(p, none, f, kDt, m, lag)) ++cycles;
    return std::pair(fences.crossed(), cycles);
  };
  EXPECT_EQ(crossed(true, {0.0, -149.0, 0.0}, {0.0, 29.0, 0.0}, 0.19).first, "");
  EXPECT_EQ(crossed(true, {0.0, -200.0, 0.0}, none, 0.0),
            std::pair(std::string("fence.force: the force on the tip was 200.0 N, the fence is "
                                  "150.0 N"),
                      3));
  EXPECT_EQ(crossed(true, none, {0.0, -1e6, 0.0}, 0.0),
            std::pair(std::string("fence.moment: the moment at the tip was 1000000.0 Nm, the fence "
                                  "is 30.0 Nm"),
                      3));
  EXPECT_EQ(crossed(false, {0.0, -200.0, 0.0}, {0.0, -1e6, 0.0}, 0.0).first, "");
  EXPECT_EQ(crossed(false, none, none, 0.21),
            std::pair(std::string("fence.lag: the tip's distance from the point that it was driven "
                                  "to was 0.210 m, the fence is 0.200 m"),
                      100));
}

TEST(FenceMonitor, AMessageNeverSaysTheSameNumberTwice) {
  const Vector3d p(0.0, 0.0, 0.2), none = Vector3d::Zero(), just(0.0, 0.0, 20.004);
  FenceMonitor force(all_fences(), true);
  while (!force.update(p, none, just, kDt)) continue;
  EXPECT_EQ(force.crossed(),
            "fence.force: the force on the tip was 20.004 N, the fence is 20.000 N");
}

TEST(FenceMonitor, WhatIsNotFiniteIsNoCrossing) {
  const Vector3d bad = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  FenceMonitor fences(all_fences(), true);
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(fences.update(bad, bad, bad, kDt));
}

TEST(FenceMonitor, BadSettingsAreRefusedByName) {
  FenceSettings empty = all_fences();
  empty.low.y() = 0.2;
  EXPECT_THAT([&] { FenceMonitor fences(empty, true); },
              testing::ThrowsMessage<InputError>(HasSubstr("fence.low: 0.2 m along y")));
  EXPECT_THAT([&] { FenceMonitor fences(all_fences(), false); },
              testing::ThrowsMessage<InputError>(HasSubstr("fence.force: nothing measures")));
}

class IncidentTest : public ScratchFolder {
 protected:
  static Prepared prepared(const std::vector<std::string>& assignments) {
    DrawOptions options;
    options.scenario = "scenarios/bowl-sine.yaml";
    options.assignments = assignments;
    return prepare(resolve(options));
  }
  std::string page(const Experiment& e, const RunOutcome& outcome) const {
    write_incident(folder_, e.scenario, outcome);
    std::ostringstream all;
    all << std::ifstream(folder_ / "incident.html").rdbuf();
    return all.str();
  }
};

// Of the tip over the step before row i, from its positions [m/s].
double tip_speed(const RunRows& rows, std::size_t i) {
  return (rows.tip_position[i] - rows.tip_position[i - 1]).norm() / kDt;
}

// Damped within half a second, without a lift, and never faster than before.
void expect_damped(const RunRows& rows, double from) {
  double before = 0.0, height = 0.0;
  std::size_t first = 0;
  while (first < rows.time.size() && rows.time[first] <= from) ++first;
  ASSERT_LT(first, rows.time.size());
  for (std::size_t i = first - std::min<std::size_t>(first, 50); i < first; ++i)
    before = std::max(before, tip_speed(rows, i));
  ASSERT_GT(before, 0.03);  // it was drawing
  height = rows.tip_position[first].z();
  for (std::size_t i = first; i < rows.time.size(); ++i) {
    ASSERT_LE(tip_speed(rows, i), 1.1 * before + 1e-3) << i;
    ASSERT_LT(rows.tip_position[i].z() - height, 2e-3) << i;
  }
  EXPECT_LE(rows.time.back() - from, 0.51);
  EXPECT_LT(tip_speed(rows, rows.time.size() - 1), 0.2 * before + 1e-3);
}

TEST_F(IncidentTest, AnEmergencyStopDampsAndEndsWhereThePenIs) {
  Prepared e = prepared({});
  RunHooks hooks;
  double now = 0.0;
  hooks.row = [&](const LogRow& row) { now = row.time; };
  hooks.emergency = [&] { return now >= 6.0; };
  const auto log = folder_ / "run.h5";
  const RunOutcome outcome = run(e, log, 0.0, hooks);
  EXPECT_EQ(outcome.end, RunEnd::stopped);
  EXPECT_THAT(outcome.cause, StartsWith("emergency stop at t = 6.00"));
  expect_damped(read_rows(log), 6.001);

  ASSERT_EQ(outcome.last.size(), 2000u);
  EXPECT_NEAR(outcome.last.back().time - outcome.last.front().time, 1.999, 1e-9);
  // The rows are the log's.
  const RunRows rows = read_rows(log);
  for (std::size_t i = 0; i < 2000; i += 37) {
    const std::size_t at = rows.time.size() - 2000 + i;
    ASSERT_EQ(outcome.last[i].time, rows.time[at]);
    EXPECT_NEAR(outcome.last[i].force, rows.contact_force[at].norm(), 1e-4);
    EXPECT_NEAR(outcome.last[i].speed, tip_speed(rows, at), 5e-3);
  }
  const std::string text = page(e, outcome);
  for (const std::string& part :
       {outcome.cause, std::string("Force on the tip [N]"), std::string("Speed of the tip [mm/s]"),
        std::string("Largest joint torque [% of its limit]"),
        std::string("Lag: age of the joint state [ms]")})
    EXPECT_NE(text.find(part), std::string::npos) << part;  // not the page in the message
  EXPECT_EQ(text.find("nan"), std::string::npos);
}

TEST_F(IncidentTest, AFenceThatIsCrossedEndsTheRunByName) {
  const auto log = folder_ / "run.h5";
  Prepared force = prepared({"fence.force=4.0"});
  EXPECT_THAT(run(force, log, 0.0).cause, StartsWith("fence.force: the force on the tip was 4."));
  Prepared speed = prepared({"fence.speed=0.02"});
  EXPECT_THAT(run(speed, log, 0.0).cause, StartsWith("fence.speed: the tip moved at 0.02"));
  Prepared box = prepared({"fence.low=[-2,-2,0.3]"});
  const RunOutcome stopped = run(box, log, 0.0);
  EXPECT_EQ(stopped.end, RunEnd::stopped);
  EXPECT_THAT(stopped.cause, StartsWith("fence.low: the tip's z was 0.299"));
  const RunRows rows = read_rows(log);
  for (const Vector3d& p : rows.tip_position) EXPECT_GT(p.z(), 0.28);
}

TEST_F(IncidentTest, FencesThatAreNotCrossedChangeNothing) {
  const auto log = folder_ / "run.h5";
  Prepared plain = prepared({}),
           fenced = prepared({"fence.force=30", "fence.speed=1.5", "fence.low=[0.2,-0.5,0]",
                              "fence.high=[1,0.5,1]"});
  const RunOutcome free_run = run(plain, log, 0.0);
  EXPECT_EQ(free_run.end, RunEnd::finished);
  EXPECT_TRUE(free_run.last.empty());
  const RunRows without = read_rows(log);
  EXPECT_EQ(run(fenced, log, 0.0).end, RunEnd::finished);
  EXPECT_EQ(read_rows(log).joint_torque, without.joint_torque);
}

}  // namespace
}  // namespace impedraw
