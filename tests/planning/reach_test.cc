#include "planning/reach.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include "common/errors.h"
#include "planning/tip_planner.h"
#include "surfaces.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

TEST(Reach, AsksDenselyAndPassesWhatIsReached) {
  const TipPath path = plan_tip_path(surfaces::shape("M"), surfaces::bowl);
  Vector3d last = path.at(0).goal.p_WD;
  double widest = 0;
  int calls = 0;
  require_reach(path, 0.01, [&](const Vector3d& p, const Vector3d& n) {
    EXPECT_NEAR(n.norm(), 1, 1e-12);
    widest = std::max(widest, (p - last).norm());
    last = p;
    ++calls;
    return std::string();
  });
  EXPECT_LT(widest, 0.0125);
  EXPECT_GT(calls, 60);
}

TEST(Reach, NamesStrokePlaceAndAmount) {
  const auto first = surfaces::line({{0.60, 0}, {0.62, 0}}), second = surfaces::line({{0.60, 0.05}, {0.60, 0.10}});
  const TipPath path = plan_tip_path({first, second}, surfaces::table);
  const auto message = [&](const ReachProblem& problem) -> std::string {
    try {
      require_reach(path, 0.005, problem);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  const std::string drawn = message([](const Vector3d& p, const Vector3d&) {
    return p.z() < 0.101 && p.y() > 0.08 ? fmt::format("{:.0f} mm too far", 1e3 * (p.y() - 0.08)) : std::string();
  });
  EXPECT_EQ(drawn.find("stroke 1 leaves the arm's reach at (0.6000, 0.08"), 0u) << drawn;
  EXPECT_NE(drawn.find("mm too far"), std::string::npos);
  const std::string travelled =
      message([](const Vector3d& p, const Vector3d&) { return p.z() > 0.12 && p.y() > 0.01 ? "too high" : std::string(); });
  EXPECT_EQ(travelled.find("the way to stroke 1 leaves"), 0u) << travelled;
}

}  // namespace
}  // namespace impedraw
