// What was put into made-up touches, and what is found.
#include "impedraw/sensing/touches.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// The model's tip poses when a pen that is `longer` touches c, tilted by up to `tilt` [rad].
std::vector<Pose> touches_of(double longer, const Vector3d& c, double tilt, double noise, int count,
                             unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> gauss(0.0, 1.0);
  std::uniform_real_distribution<double> angle(-3.1, 3.1);
  std::vector<Pose> touches;
  for (int i = 0; i < count; ++i) {
    const double about = angle(random);
    Pose X;
    X.R =
        (Eigen::AngleAxisd(tilt * (i % 3) / 2.0, Vector3d(std::cos(about), std::sin(about), 0.0)) *
         Eigen::AngleAxisd(3.14159265358979, Vector3d::UnitX()))
            .toRotationMatrix();
    X.p = c - longer * X.R.col(2) + noise * Vector3d(gauss(random), gauss(random), gauss(random));
    touches.push_back(X);
  }
  return touches;
}

TEST(PenLength, WhatWasPutInIsFound) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const double longer = 0.002 * seed - 0.02;
    const Vector3d c(0.5, -0.1, 0.12);
    const PenLength exact = identify_pen_length(touches_of(longer, c, 0.5, 0.0, 5, seed));
    EXPECT_NEAR(exact.longer, longer, 1e-12);
    EXPECT_LT((exact.p_W - c).norm(), 1e-12);
    const PenLength noisy = identify_pen_length(touches_of(longer, c, 0.5, 2e-4, 9, seed));
    EXPECT_NEAR(noisy.longer, longer, 5.0 * noisy.error);
    EXPECT_LT(noisy.error, 5e-4);
    EXPECT_GT(noisy.error, 2e-5);
  }
}

TEST(PenLength, WhatIsImplausibleIsRefused) {
  const Vector3d c(0.5, 0.0, 0.1);
  const auto refused = [](const std::vector<Pose>& touches, const char* why) {
    EXPECT_THAT([&] { identify_pen_length(touches); }, ThrowsMessage<InputError>(HasSubstr(why)));
  };
  refused(touches_of(0.0, c, 0.5, 0.0, 2, 1), "2 touches of the point; at least 3");
  refused(touches_of(0.0, c, 0.05, 0.0, 5, 1), "at least 10 are needed");
  refused(touches_of(0.0, c, 0.5, 5e-3, 9, 1), "off one point");
  refused(touches_of(0.08, c, 0.5, 0.0, 5, 1), "80.0 mm longer than modelled");
  std::vector<Pose> bad = touches_of(0.0, c, 0.5, 0.0, 5, 1);
  bad[1].p.x() = NAN;
  refused(bad, "not finite");
}

std::vector<Vector3d> moved(const Pose& X, std::vector<Vector3d> points) {
  for (Vector3d& p : points) p = X * p;
  return points;
}

TEST(Registration, WhatWasPutInIsFound) {
  const std::vector<Vector3d> marks = {{0, 0, 0}, {0.2, 0, 0}, {0.2, 0.15, 0}, {0, 0.15, 0}};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int i = 0; i < 50; ++i) {
    Pose X;
    X.R = Eigen::Quaterniond(
              Eigen::Vector4d(any(random), any(random), any(random), any(random)).normalized())
              .toRotationMatrix();
    X.p = Vector3d(any(random), any(random), any(random));
    for (const std::size_t n : {std::size_t{3}, std::size_t{4}}) {  // coplanar: no mirror image
      const std::vector<Vector3d> some(marks.begin(), marks.begin() + static_cast<long>(n));
      const Registration found = register_page(some, moved(X, some));
      EXPECT_LT((found.X_WP.R - X.R).norm(), 1e-9);
      EXPECT_NEAR(found.X_WP.R.determinant(), 1.0, 1e-9);
      EXPECT_LT((found.X_WP.p - X.p).norm(), 1e-9);
      EXPECT_LT(found.residual, 1e-9);
    }
  }
}

TEST(Registration, WhatIsImplausibleIsRefused) {
  const std::vector<Vector3d> marks = {{0, 0, 0}, {0.2, 0, 0}, {0.2, 0.15, 0}};
  const auto refused = [](const auto& p_P, const auto& p_W, const char* why) {
    EXPECT_THAT([&] { register_page(p_P, p_W); }, ThrowsMessage<InputError>(HasSubstr(why)));
  };
  const std::vector<Vector3d> two(marks.begin(), marks.begin() + 2);
  refused(two, two, "2 marks of the page; at least 3");
  refused(marks, two, "3 marks of the page, and 2 touches");
  const std::vector<Vector3d> line = {{0, 0, 0}, {0.1, 0, 0}, {0.2, 0.01, 0}};
  refused(line, line, "of one line");
  const std::vector<Vector3d> swapped = {marks[1], marks[0], marks[2]};
  refused(marks, swapped, "off the marks");
}

}  // namespace
}  // namespace impedraw
