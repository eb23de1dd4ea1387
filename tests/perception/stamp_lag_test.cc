// The time stamps' error from a made-up pen on a canvas that heaves, against the one put in.
#include "impedraw/perception/stamp_lag.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

struct Found {
  double lag = 0.0, deviation = 0.0;
};

// Frames at 30 Hz with noise, of a canvas that moves by `amplitude` along n; their stamps are taken
// to be as late as was found before. bias: of the surface's height [m].
Found found(double late, double amplitude, double bias, double duration) {
  constexpr double kRate = 2.0 * M_PI * 0.5, kFrame = 1.0 / 30.0;
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.2e-3);
  const auto at = [&](double t) { return amplitude * std::sin(kRate * t); };
  StampLag stamps;
  for (double exposed = 0.0; exposed < duration; exposed += kFrame) {
    const double stamp = exposed + late - stamps.lag();
    const double shown = at(exposed) + bias + noise(random);
    stamps.add(amplitude * kRate * std::cos(kRate * stamp), at(stamp) - shown, kFrame);
  }
  return {stamps.lag(), stamps.deviation()};
}

TEST(StampLag, IsFoundWhereTheCanvasMovesAlongTheNormal) {
  for (const double late : {5e-3, -8e-3, 20e-3})
    for (const double bias : {0.0, 0.5e-3}) {
      const Found f = found(late, 20e-3, bias, 10.0);
      EXPECT_NEAR(f.lag, late, 1e-3) << late;
      EXPECT_LT(f.deviation, 1e-3);
    }
}

TEST(StampLag, StampsThatAreRightStayAsTheyAre) {
  EXPECT_LT(std::abs(found(0.0, 20e-3, 0.5e-3, 20.0).lag), 0.5e-3);
}

TEST(StampLag, ACanvasThatStandsTellsNothing) {
  EXPECT_EQ(found(5e-3, 0.0, 0.5e-3, 20.0).lag, 0.0);
  EXPECT_EQ(found(5e-3, 20e-3, 0.0, 0.7).lag, 0.0) << "too few frames";
}

}  // namespace
}  // namespace impedraw
