// Steps of Matérn processes against integration, and forecasts of motions like a hand's.
#include "impedraw/perception/matern_motion.h"

#include <gtest/gtest.h>

namespace impedraw {
namespace {

// Runge and Kutta's method on the equations of the header.
AxisState integrated(AxisState s, int order, double rate, double dt) {
  constexpr int kSteps = 400;
  const double h = dt / kSteps;
  const auto slope = [&](const AxisState& y) -> AxisState {
    if (order == 2) return {y.v, -rate * y.v, 0.0};
    return {y.v, y.a, -rate * rate * y.v - 2.0 * rate * y.a};
  };
  const auto plus = [](const AxisState& y, double by, const AxisState& k) -> AxisState {
    return {y.x + by * k.x, y.v + by * k.v, y.a + by * k.a};
  };
  for (int i = 0; i < kSteps; ++i) {
    const AxisState k1 = slope(s), k2 = slope(plus(s, 0.5 * h, k1)),
                    k3 = slope(plus(s, 0.5 * h, k2)), k4 = slope(plus(s, h, k3));
    s = plus(plus(plus(plus(s, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3), h / 6.0, k4);
  }
  return s;
}

TEST(MaternStep, SolvesItsEquation) {
  for (const int order : {2, 3})
    for (const double rate : {0.0, 1e-3, 0.5, 3.0, 20.0})
      for (const double dt : {1e-3, 0.03, 0.3}) {
        SCOPED_TRACE(testing::Message() << order << " " << rate << " " << dt);
        const AxisState from{0.3, -0.7, order == 3 ? 2.0 : 0.0};
        const AxisState is = MaternStep(order, rate, dt).of(from),
                        to = integrated(from, order, rate, dt);
        EXPECT_NEAR(is.x, to.x, 1e-8);
        EXPECT_NEAR(is.v, to.v, 1e-8);
        EXPECT_NEAR(is.a, to.a, 1e-7);
      }
}

TEST(MaternStep, TwoStepsAreOne) {
  const AxisState from{0.3, -0.7, 2.0};
  const AxisState once = MaternStep(3, 8.0, 0.05).of(from),
                  twice = MaternStep(3, 8.0, 0.03).of(MaternStep(3, 8.0, 0.02).of(from));
  EXPECT_NEAR(once.x, twice.x, 1e-14);
  EXPECT_NEAR(once.v, twice.v, 1e-14);
  EXPECT_NEAR(once.a, twice.a, 1e-13);
}

}  // namespace
}  // namespace impedraw
