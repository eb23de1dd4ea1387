// A lifted pen on a canvas whose estimate is corrected, against the closed form of the decay.
#include "impedraw/run/soft_corrections.h"

#include <cmath>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kStep = 1e-3;

TipReference at(double p, double v, double a = 0.0) {
  TipReference reference;
  reference.p_WD = {0.6, 0.0, p};
  reference.v_WD = {0.0, 0.0, v};
  reference.a_WD = {0.0, 0.0, a};
  return reference;
}

TEST(SoftCorrections, FollowAForeseenMotionWithoutALag) {
  SoftCorrections soft;
  for (int i = 0; i < 4000; ++i) {
    const double t = kStep * i, w = 2.0 * M_PI * 0.5;
    const double p = 0.05 * std::sin(w * t), v = 0.05 * w * std::cos(w * t);
    EXPECT_NEAR(soft.of(at(p, v, -w * w * p), true, kStep).p_WD.z(), p, 2e-6);
  }
}

// e(t) = −Δ (1 + ω t) e^(−ω t) of a jump of Δ, critically damped.
TEST(SoftCorrections, GoToACorrectedPlaceCriticallyDamped) {
  SoftCorrections soft;
  soft.of(at(0.0, 0.0), true, kStep);
  double fastest = 0.0;
  for (int i = 0; i < 500; ++i) {
    const double x = SoftCorrections::kRate * kStep * (i + 1);
    const TipReference now = soft.of(at(-0.012, 0.0), true, kStep);
    EXPECT_NEAR(now.p_WD.z(), -0.012 * (1.0 - (1.0 + x) * std::exp(-x)), 4e-4) << i;
    fastest = std::max(fastest, std::abs(now.v_WD.z()));
  }
  EXPECT_NEAR(fastest, 0.012 * SoftCorrections::kRate / M_E, 4e-3);
}

// A pen that comes down is where the estimate says, and what is left of an older correction fades.
TEST(SoftCorrections, TakeNoneOfAPenThatIsDown) {
  SoftCorrections soft;
  soft.of(at(0.0, 0.0), false, kStep);
  EXPECT_EQ(soft.of(at(0.01, 0.2), false, kStep).p_WD.z(), 0.01);
  soft.of(at(0.02, 0.2), true, kStep);
  double off = 1.0;
  for (int i = 0; i < 400; ++i) off = soft.of(at(0.02, 0.0), false, kStep).p_WD.z() - 0.02;
  EXPECT_NEAR(off, 0.0, 1e-4);
}

// e(t) = −Δv t e^(−ω t) of a jump Δv, with its derivatives.
TEST(SoftCorrections, TakeUpACorrectedSpeedCriticallyDamped) {
  SoftCorrections soft;
  TipReference before = soft.of(at(0.0, 0.0), true, kStep);
  for (int i = 0; i < 300; ++i) {
    const double t = kStep * (i + 1), p = 0.1 * kStep * i;
    const TipReference now = soft.of(at(p, 0.1), true, kStep);
    EXPECT_NEAR(now.p_WD.z(), p - 0.1 * t * std::exp(-SoftCorrections::kRate * t), 2e-4) << i;
    if (i > 0) {
      EXPECT_NEAR(now.v_WD.z(), (now.p_WD - before.p_WD).z() / kStep, 1e-9);
      EXPECT_NEAR(now.a_WD.z(), (now.v_WD - before.v_WD).z() / kStep, 1e-9);
    }
    before = now;
  }
}

}  // namespace
}  // namespace impedraw
