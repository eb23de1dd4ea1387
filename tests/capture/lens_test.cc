#include "impedraw/capture/lens.h"

#include <random>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

Lens colour_camera() {
  Lens lens;
  lens.width = 640, lens.height = 480;
  lens.fx = 604.1, lens.fy = 603.8, lens.cx = 321.7, lens.cy = 238.2;
  lens.k = {0.12, -0.25, 1e-3, -8e-4, 0.09};
  return lens;
}

// OpenCV's documented projection, written out: (x, y, 1) to a pixel.
Eigen::Vector2d opencv_pixel(const Lens& lens, double x, double y) {
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double radial = 1 + lens.k[0] * r2 + lens.k[1] * r4 + lens.k[4] * r6;
  const double p1 = lens.k[2], p2 = lens.k[3];
  const double u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return {lens.fx * u + lens.cx, lens.fy * v + lens.cy};
}

TEST(Lens, WithoutDistortionIsAPinhole) {
  Lens lens = colour_camera();
  lens.k = {};
  const auto d = lens.direction_C(lens.cx + lens.fx, lens.cy - 0.5 * lens.fy);
  ASSERT_TRUE(d);
  EXPECT_LT((*d - Eigen::Vector3d(1, -0.5, 1)).norm(), 1e-15);
}

TEST(Lens, BrownConradyInvertsTheProjectionOfOpenCv) {
  Lens lens = colour_camera();
  lens.model = Lens::Model::brown_conrady;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> across(-0.5, 0.5), down(-0.38, 0.38);
  for (int i = 0; i < 1000; ++i) {
    const double x = across(random), y = down(random);
    const Eigen::Vector2d pixel = opencv_pixel(lens, x, y);
    const auto d = lens.direction_C(pixel.x(), pixel.y());
    ASSERT_TRUE(d) << "seed 7, point " << i;
    ASSERT_LT((*d - Eigen::Vector3d(x, y, 1)).norm(), 1e-10) << "seed 7, point " << i;
  }
}

TEST(Lens, InverseBrownConradyAppliesThePolynomialToThePixel) {
  Lens lens = colour_camera();
  lens.model = Lens::Model::inverse_brown_conrady;
  const double x = 0.31, y = -0.22;
  const auto d = lens.direction_C(lens.cx + lens.fx * x, lens.cy + lens.fy * y);
  const Eigen::Vector2d ideal = opencv_pixel(lens, x, y);
  ASSERT_TRUE(d);
  EXPECT_NEAR(d->x(), (ideal.x() - lens.cx) / lens.fx, 1e-12);
  EXPECT_NEAR(d->y(), (ideal.y() - lens.cy) / lens.fy, 1e-12);
}

TEST(Lens, TellsWhereThePolynomialFolds) {
  Lens lens = colour_camera();
  lens.model = Lens::Model::brown_conrady;
  lens.k = {-0.9, 0, 0, 0, 0};  // r (1 − 0.9 r²) has its greatest value, 0.41, at r = 0.61
  EXPECT_TRUE(lens.direction_C(lens.cx + 0.38 * lens.fx, lens.cy));
  EXPECT_FALSE(lens.direction_C(lens.cx + 0.45 * lens.fx, lens.cy));
}

}  // namespace
}  // namespace impedraw
