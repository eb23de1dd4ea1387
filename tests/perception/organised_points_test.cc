// Points and normals of depth images, against surfaces that are known in closed form.
#include "impedraw/perception/organised_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kDegrees = 180.0 / std::numbers::pi;
const Eigen::AlignedBox3d kEverywhere(Vector3d::Constant(-10.0), Vector3d::Constant(10.0));

DepthCamera camera() { return {320, 240, 60.0, look_at({0.9, 0.3, 0.8}, {0.6, 0.0, 0.1})}; }

// n·p = d
CastRay plane(const Vector3d& n, double d) {
  return [=](const Vector3d& o, const Vector3d& u) {
    const double t = (d - n.dot(o)) / n.dot(u);
    return t > 0.0 ? t : std::numeric_limits<double>::infinity();
  };
}

// From inside.
CastRay sphere(const Vector3d& c, double radius) {
  return [=](const Vector3d& o, const Vector3d& u) {
    const Vector3d w = o - c;
    const double b = w.dot(u), q = b * b - w.squaredNorm() + radius * radius;
    return q > 0.0 ? -b + std::sqrt(q) : std::numeric_limits<double>::infinity();
  };
}

std::vector<SeenPoint> samples_of(const CastRay& cast, const DepthNoise& noise = {},
                                  unsigned seed = 1) {
  std::vector<SeenPoint> out;
  OrganisedPoints().find(render_depth(camera(), cast, noise, seed, 1), camera(), kEverywhere, {},
                         0.0, &out);
  return out;
}

TEST(OrganisedPoints, PlaneIsExactHoweverItLeans) {
  for (const Vector3d& towards :
       {Vector3d(0, 0, 1), Vector3d(0.6, 0.1, 1), Vector3d(-0.2, 0.8, 1)}) {
    const Vector3d n = towards.normalized();
    const double d = n.dot(Vector3d(0.6, 0.0, 0.1));
    const auto samples = samples_of(plane(n, d));
    ASSERT_GT(samples.size(), 2000U);
    for (const SeenPoint& s : samples) {
      EXPECT_NEAR(n.dot(s.p), d, 1e-12);
      EXPECT_NEAR((s.n - n).norm(), 0.0, 1e-9);
    }
  }
}

TEST(OrganisedPoints, CurvatureDoesNotBias) {
  const Vector3d c(0.6, 0.0, 0.35);
  int count = 0;
  for (const SeenPoint& s : samples_of(sphere(c, 0.3))) {
    // What is left are third derivatives. Seen flatter than 30°, a pixel is as wide as the
    // surface's shape.
    if (s.n.dot((camera().X_WC.p - s.p).normalized()) < 0.5) continue;
    ++count;
    EXPECT_NEAR((s.p - c).norm(), 0.3, 2e-5);
    EXPECT_LT(kDegrees * std::acos(std::min(1.0, -s.n.dot((s.p - c).normalized()))), 0.3);
  }
  EXPECT_GT(count, 1000);
}

TEST(OrganisedPoints, NoiseIsAsItIsToldToBe) {
  const Vector3d c(0.6, 0.0, 0.35);
  double square = 0.0, tilt = 0.0, deviation = 0.0, n = 0.0;
  const auto samples = samples_of(sphere(c, 0.3), realistic_depth_noise());
  for (const SeenPoint& s : samples) {
    if (s.n.dot((camera().X_WC.p - s.p).normalized()) < 0.5) continue;
    ++n;
    const double off = (s.p - c).norm() - 0.3;
    square += off * off / (s.deviation * s.deviation);
    deviation += s.deviation;
    tilt += kDegrees * std::acos(std::min(1.0, -s.n.dot((s.p - c).normalized())));
  }
  ASSERT_GT(n, 1000);
  EXPECT_NEAR(std::sqrt(square / n), 1.0, 0.1);
  EXPECT_LT(deviation / n, 2.5e-4);  // of a pixel: about 0.7 mm
  EXPECT_LT(tilt / n, 2.0);
}

// A block that stands 0.15 m before a plane.
TEST(OrganisedPoints, EdgesMixNothing) {
  const Vector3d z = Vector3d::UnitZ();
  const CastRay low = plane(z, 0.1), high = plane(z, 0.25);
  const auto both = [&](const Vector3d& o, const Vector3d& u) {
    const Vector3d p = o + high(o, u) * u;
    return p.x() > 0.6 ? high(o, u) : low(o, u);
  };
  int on_low = 0, on_high = 0;
  for (const SeenPoint& s : samples_of(both)) {
    const bool is_low = std::abs(s.p.z() - 0.1) < 1e-9, is_high = std::abs(s.p.z() - 0.25) < 1e-9;
    EXPECT_TRUE(is_low || is_high) << s.p.transpose();
    EXPECT_GT(s.n.z(), 1.0 - 1e-9);
    on_low += is_low;
    on_high += is_high;
  }
  EXPECT_GT(on_low, 500);
  EXPECT_GT(on_high, 500);
}

TEST(OrganisedPoints, ArmAndSurroundingsAreLeftOut) {
  const DepthImage image = render_depth(camera(), plane(Vector3d::UnitZ(), 0.1), {}, 1, 1);
  const Eigen::AlignedBox3d region(Vector3d(0.5, -0.1, 0), Vector3d(0.7, 0.1, 0.2));
  const std::vector<Capsule> arm = {{{0.6, 0.0, 0.1}, {0.6, 0.0, 0.5}, 0.02}};
  std::vector<SeenPoint> out;
  OrganisedPoints().find(image, camera(), region, arm, 0.01, &out);
  ASSERT_GT(out.size(), 50U);
  for (const SeenPoint& s : out) {
    EXPECT_TRUE(region.contains(s.p));
    EXPECT_GT(std::hypot(s.p.x() - 0.6, s.p.y()), 0.03);
  }
}

TEST(OrganisedPoints, PhasesGoThroughAllPixels) {
  const DepthImage image = render_depth(camera(), plane(Vector3d::UnitZ(), 0.1), {}, 1, 1);
  const OrganisedPoints points({.stride = 3});
  std::vector<SeenPoint> all, every;
  for (unsigned phase = 0; phase < 9; ++phase)
    points.find(image, camera(), kEverywhere, {}, 0.0, &all, phase);
  OrganisedPoints({.stride = 1}).find(image, camera(), kEverywhere, {}, 0.0, &every);
  const auto before = [](const SeenPoint& a, const SeenPoint& b) {
    return std::pair(a.p.x(), a.p.y()) < std::pair(b.p.x(), b.p.y());
  };
  std::sort(all.begin(), all.end(), before);
  std::sort(every.begin(), every.end(), before);
  ASSERT_EQ(all.size(), every.size());
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i].p, every[i].p);
}

TEST(OrganisedPoints, SettingsAreChecked) {
  EXPECT_THROW(OrganisedPoints({.stride = 0}), InputError);
  EXPECT_THROW(OrganisedPoints({.half_window = 0}), InputError);
  EXPECT_THROW(OrganisedPoints({.jump = -1.0}), InputError);
}

}  // namespace
}  // namespace impedraw
