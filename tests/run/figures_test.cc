// Promised and measured figures on the standard scenarios with fixed seeds. Fails if any is worse
// than bounds.json allows.
#include <algorithm>
#include <cmath>

#include "drawn_scenario.h"

namespace impedraw {
namespace {

TEST(Figures, SineWithTheTrueWrench) { draw_within_bounds("bowl-sine"); }
TEST(Figures, MWithTheTrueWrench) { draw_within_bounds("bowl-m"); }
TEST(Figures, SineWithoutAWrench) { draw_within_bounds("bowl-sine-natural"); }
TEST(Figures, MWithoutAWrench) { draw_within_bounds("bowl-m-natural"); }

// The paper's own estimate, a plane through k neighbours of equal weight, is worse but within the
// promised limits.
TEST(Figures, SineWithThePapersNormals) {
  const Figures f = draw_within_bounds("bowl-sine-plane");
  EXPECT_GT(f["normal_error_mean"], 0.02) << "or it is not the paper's";
}

TEST(Figures, BlindDrawsAndIsWorse) {
  for (const char* name : {"bowl-sine-blind", "bowl-m-blind"}) {
    const Figures f = draw_within_bounds(name);
    EXPECT_GT(f["tilt_mean"], 5.0) << name << ": the pen stands upright on slopes";
    EXPECT_TRUE(!f.metrics.normal_error_mean.value()) << name;
    EXPECT_GT(f["force_sd"], 0.1) << name;
  }
}

// The target stays the smooth sine.
TEST(Figures, TenSetPointsAreNotASine) { draw_within_bounds("bowl-sine10"); }

// Each bound of the table holds for the measured value and fails just beyond the allowed one.
TEST(Figures, EveryBoundCanFail) {
  for (const auto& [run, entry] : bounds().at("runs").items()) {
    for (const auto& [metric, bound] : entry.at("bounds").items()) {
      SCOPED_TRACE(run + " " + metric);
      const double best = bounds().at("best").at(metric), measured = bound.at("measured");
      EXPECT_TRUE(missed_bounds(run, metric, measured).empty());
      const double side = measured < best ? -1.0 : 1.0;
      const double beyond = 1.001 * allowed_deviation(run, metric) + 1e-9;
      EXPECT_FALSE(missed_bounds(run, metric, best + side * beyond).empty());
      EXPECT_FALSE(missed_bounds(run, metric, std::nan("")).empty());
      const nlohmann::json &least = bound.at("promised")[0], &most = bound.at("promised")[1];
      EXPECT_TRUE(least.is_null() ||
                  !missed_bounds(run, metric, least.get<double>() - 1e-6).empty());
      EXPECT_TRUE(most.is_null() || !missed_bounds(run, metric, most.get<double>() + 1e-6).empty());
    }
  }
}

// A lateral push of 10 N: the pen yields by F / k_t and returns.
TEST(Figures, ThePenGivesWayAndComesBack) {
  const Figures pushed = draw_scenario("bowl-push"), left_alone = draw_scenario("bowl-sine");
  int first = -1, last = -1;
  const int rows = static_cast<int>(pushed.run.time.size());
  for (int i = 0; i < rows; ++i) {
    if (pushed.run.disturbance_force[i].norm() < 1.0) continue;
    if (first < 0) first = i;
    last = i;
  }
  ASSERT_GT(first, 0);
  EXPECT_NEAR(last - first + 1, 1000, 2);
  const auto yielded = [&](int i) {
    return (pushed.run.tip_position[i] - left_alone.run.tip_position[i])
        .dot(pushed.run.disturbance_force[std::clamp(i, first, last)].normalized());
  };
  // All in mm, as in bounds.json.
  double settled = 0.0, back = 0.0;
  for (int i = first + 300; i <= last; ++i) settled += 1e3 * yielded(i) / (last - first - 299);
  for (int i = last + 300; i < last + 1300; ++i)
    back =
        std::max(back, 1e3 * (pushed.run.tip_position[i] - left_alone.run.tip_position[i]).norm());
  expect_within_bounds("bowl-push", [&](const std::string& metric) {
    if (metric == "yield") return settled;
    if (metric == "yield_last") return 1e3 * yielded(last);
    return metric == "back" ? back : pushed[metric.c_str()];
  });
}

}  // namespace
}  // namespace impedraw
