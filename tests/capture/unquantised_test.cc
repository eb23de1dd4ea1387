// Depth images of a ball and of a plane in closed form, rounded to millimetres.
#include "impedraw/capture/clean_view.h"

#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

constexpr int kWidth = 200, kHeight = 160;
constexpr double kFocal = 400.0, kQuantum = 1e-3;  // [px], [m]

using DepthAt = std::function<double(double x, double y)>;

// Of a plane at 0.7 m that leans, and of a ball of 0.3 m whose top is 0.5 m away.
double leaning_plane(double x, double y) { return 0.7 / (1.0 - 0.15 * x - 0.08 * y); }

double ball(double x, double y) {
  const double centre = 0.8, a = 1.0 + x * x + y * y;
  return (centre - std::sqrt(centre * centre - a * (centre * centre - 0.09))) / a;
}

struct Image {
  std::vector<double> truth;
  DepthImage image{kWidth, kHeight, {}};

  explicit Image(const DepthAt& depth) {
    for (int j = 0; j < kHeight; ++j)
      for (int i = 0; i < kWidth; ++i) {
        truth.push_back(depth((i - 99.5) / kFocal, (j - 79.5) / kFocal));
        image.depth.push_back(kQuantum * std::round(truth.back() / kQuantum));
      }
  }

  // Root-mean-square error, `border` pixels from the rim.
  double rms(int border) const {
    double sum = 0.0, n = 0.0;
    for (int j = border; j < kHeight - border; ++j)
      for (int i = border; i < kWidth - border; ++i, ++n) {
        const std::size_t at = static_cast<std::size_t>(j) * kWidth + i;
        sum += std::pow(image.depth[at] - truth[at], 2);
      }
    return std::sqrt(sum / n);
  }
};

TEST(SmoothQuanta, TerracesOfAPlaneAndABallGo) {
  for (const DepthAt& depth : {DepthAt(leaning_plane), DepthAt(ball)}) {
    Image seen(depth);
    const std::vector<double> measured = seen.image.depth;
    ASSERT_GT(seen.rms(20), 2.5e-4);  // q/√12
    smooth_quanta(kQuantum, &seen.image);
    EXPECT_LT(seen.rms(20), 8e-5);
    for (std::size_t k = 0; k < measured.size(); ++k)
      ASSERT_LT(std::abs(seen.image.depth[k] - measured[k]), 0.501 * kQuantum);
  }
}

TEST(SmoothQuanta, AStepSmearsByLessThanHalfAQuantum) {
  const auto step = [](double x, double y) { return leaning_plane(x, y) + (x > 0 ? 4e-3 : 0.0); };
  Image seen(step);
  smooth_quanta(kQuantum, &seen.image);
  double off = 0.0;
  for (int j = 20; j < kHeight - 20; ++j) {
    const std::size_t at = static_cast<std::size_t>(j) * kWidth + 99;
    off += seen.image.depth[at + 1] - seen.image.depth[at] - (seen.truth[at + 1] - seen.truth[at]);
  }
  EXPECT_LT(std::abs(off / (kHeight - 40)), 0.5 * kQuantum);
}

TEST(SmoothQuanta, WhatMeasuredNothingStaysEmpty) {
  Image seen(ball);
  for (std::size_t k = 0; k < seen.image.depth.size(); k += 7) seen.image.depth[k] = NAN;
  smooth_quanta(kQuantum, &seen.image);
  for (std::size_t k = 0; k < seen.image.depth.size(); ++k)
    ASSERT_EQ(std::isnan(seen.image.depth[k]), k % 7 == 0);
}

}  // namespace
}  // namespace impedraw
