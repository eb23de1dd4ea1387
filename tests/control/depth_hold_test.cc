#include "impedraw/control/depth_hold.h"

#include <cmath>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kCut = 12e3, kCycle = 1e-3, kFeed = 0.02,  // [N/m], [s], [m/s]
    kScore = 7.5e-5;                                        // [m]

// A wavy surface that nobody knows, in material `hardness` times as hard as believed.
struct Cut {
  double hardness;
  DepthHold hold{{kCut, kScore, 3e-4}, kCycle};
  static double height(double x) { return 2e-3 * std::sin(40.0 * x); }
  static Vector3d normal(double x) {
    return Vector3d(-0.08 * std::cos(40.0 * x), 0.0, 1.0).normalized();
  }
  // Along `way`; the depth's RMS error, from a settling way of 20 mm on.
  double pass(double force, double depth, double way) {
    TipReference reference;
    reference.force = force;
    reference.depth = depth;
    reference.v_WD.x() = kFeed;
    double F = force, sum = 0.0;
    int n = 0;
    for (double x = 0.0; x < way; x += kFeed * kCycle) {
      const double d = F / (hardness * kCut);
      const Vector3d p_E = Vector3d(x, 0.0, height(x)) - d * normal(x);
      F = hold.force(reference, p_E, normal(x), F, true);
      if (x < 0.02) continue;
      sum += (d - depth) * (d - depth);
      ++n;
    }
    return std::sqrt(sum / n);
  }
};

TEST(DepthHold, FindsTheDepthInHarderAndSofterMaterial) {
  for (const double hardness : {0.5, 0.8, 1.0, 1.3, 2.0}) {
    Cut cut{hardness};
    cut.pass(kCut * kScore, 0.0, 0.1);
    const bool near = hardness >= 0.8 && hardness <= 1.3;
    EXPECT_LT(cut.pass(kCut * 3e-4, 3e-4, 0.1), near ? 4e-6 : 2e-5) << hardness;
  }
}

TEST(DepthHold, KeepsTheForceWhereNothingWasTouched) {
  Cut cut{1.3};
  TipReference reference;
  reference.force = 3.0;
  reference.depth = 3e-4;
  reference.v_WD.x() = kFeed;
  for (int i = 0; i < 1000; ++i)
    EXPECT_EQ(cut.hold.force(reference, Vector3d(0.3, 0, 0), Vector3d::UnitZ(), 3.0, true), 3.0);
}

// The depth beneath what was touched beside the tip, each place by its nearness across the normal.
TEST(DepthHold, NearerPlacesCountForMoreInADeepCut) {
  const Vector3d places[] = {{0.25e-3, 0.25e-3, 0.1e-3}, {0.6e-3, 0.25e-3, 0.25e-3}},
                 p_E(0.3e-3, 0.25e-3, -1.3e-3);
  DepthHold hold{{kCut, 0.0, 3e-4}, kCycle};
  double sum = 0.0, weights = 0.0;
  for (const Vector3d& p : places) {
    hold.touch(p, Vector3d::UnitZ(), 0.0);
    const double weight = 1.0 / (1e-8 + std::pow(p.x() - p_E.x(), 2));
    sum += weight * (p - p_E).z();
    weights += weight;
  }
  TipReference reference;
  reference.force = 3.0;
  reference.depth = 1.5e-3;
  reference.v_WD.x() = kFeed;
  const double F = hold.force(reference, p_E, Vector3d::UnitZ(), 3.0, true);
  EXPECT_NEAR(F - 3.0, DepthHold::kRate * kCut * kCycle * (1.5e-3 - sum / weights), 1e-9);
}

TEST(DepthHold, BeforeItTouchesTheForceIsThatForTheMaterialAsLearned) {
  for (const double hardness : {0.8, 1.3}) {
    Cut cut{hardness};
    TipReference reference;
    reference.force = 3.0;
    reference.depth = 3e-4;
    const auto in_the_air = [&] {
      return cut.hold.force(reference, Vector3d::Zero(), Vector3d::UnitZ(), 0.0, false);
    };
    EXPECT_EQ(in_the_air(), 3.0) << "nothing is learned yet";
    cut.pass(kCut * kScore, 0.0, 0.1);
    cut.pass(kCut * 3e-4, 3e-4, 0.1);
    EXPECT_NEAR(in_the_air(), 3.0 * hardness, 0.05 * 3.0);
    reference.depth = 0.0;
    EXPECT_EQ(in_the_air(), 3.0);
  }
}

}  // namespace
}  // namespace impedraw
