// Registration to surfaces whose open directions are known, and from depth images.
#include "impedraw/perception/registration.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "impedraw/common/errors.h"
#include "impedraw/common/seeded_normals.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

Pose small_motion(double shift, double turn, SeededNormals& random) {
  const auto direction = [&] {
    return Vector3d(random.next(), random.next(), random.next()).normalized();
  };
  Pose X;
  X.R = Eigen::AngleAxisd(turn, direction()).toRotationMatrix();
  const Vector3d c(0.6, 0.0, 0.1);
  X.p = c - X.R * c + shift * direction();
  return X;
}

// A point and its normal for u, v in [-1, 1].
using Surface = std::function<SeenPoint(double u, double v)>;

SeenPoint flat(double u, double v) {
  return {{0.6 + 0.15 * u, 0.15 * v, 0.1}, Vector3d::UnitZ(), 1e-4};
}
SeenPoint bowl(double u, double v) {  // a part of a sphere, seen from inside
  const Vector3d centre(0.6, 0.0, 0.4);
  const Vector3d way = Vector3d(0.5 * u, 0.5 * v, -1.0).normalized();
  return {centre + 0.3 * way, -way, 1e-4};
}
SeenPoint half_pipe(double u, double v) {  // along x
  const Vector3d way(0.0, std::sin(v), -std::cos(v));
  return {Vector3d(0.6 + 0.15 * u, 0.0, 0.4) + 0.3 * way, -way, 1e-4};
}
SeenPoint waves(double u, double v) {
  const double x = 0.15 * u, y = 0.15 * v, a = 0.02, k = 30.0, m = 20.0;
  const Vector3d n(-a * k * std::cos(k * x) * std::cos(m * y),
                   a * m * std::sin(k * x) * std::sin(m * y), 1.0);
  return {{0.6 + x, y, 0.1 + a * std::sin(k * x) * std::cos(m * y)}, n.normalized(), 1e-4};
}

SurfaceModel model_of(const Surface& surface) {
  SurfaceModel model(0.004);
  std::vector<SeenPoint> samples;
  for (int i = -150; i <= 150; ++i)
    for (int j = -150; j <= 150; ++j) samples.push_back(surface(i / 150.0, j / 150.0));
  model.add(samples, {});
  return model;
}

// Seen with the body at X_WK, noise along the normals and in them.
std::vector<SeenPoint> seen(const Surface& surface, const Pose& X_WK, double noise,
                            SeededNormals& random) {
  std::vector<SeenPoint> samples;
  for (int i = -20; i <= 20; ++i)
    for (int j = -20; j <= 20; ++j) {
      SeenPoint s = surface(0.9 * i / 20.0 + 0.003, 0.9 * j / 20.0 - 0.002);
      s.p = X_WK * (s.p + noise * random.next() * s.n);
      s.n = X_WK.R * s.n;
      s.deviation = std::max(noise, 1e-5);
      samples.push_back(s);
    }
  return samples;
}

TEST(Registration, WavesFixAllDirections) {
  const SurfaceModel model = model_of(waves);
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    SeededNormals random(seed);
    const Pose X_WK = small_motion(3e-3, 0.02, random);
    const ShapeRegistration r = register_samples(model, seen(waves, X_WK, 1e-4, random), {});
    ASSERT_TRUE(r.found);
    EXPECT_EQ(r.open, 0);
    EXPECT_LT((r.X_WK * r.c_W - X_WK * r.c_W).norm(), 5e-5);
    EXPECT_LT(Eigen::AngleAxisd(r.X_WK.R * X_WK.R.transpose()).angle(), 1e-3);
  }
}

// n·(p − q) of the true pose cannot be told from that of another one.
TEST(Registration, PlaneSlidesAndTurns) {
  const SurfaceModel model = model_of(flat);
  SeededNormals random(3);
  Pose X_WK;
  X_WK.p = Vector3d(1e-3, -2e-3, 4e-3);
  const ShapeRegistration r = register_samples(model, seen(flat, X_WK, 1e-4, random), {});
  ASSERT_TRUE(r.found);
  ASSERT_EQ(r.open, 3);
  EXPECT_NEAR(r.X_WK.p.z(), 4e-3, 2e-5);
  // The prediction stays in the open directions.
  EXPECT_NEAR(r.X_WK.p.x(), 0.0, 1e-4);
  EXPECT_NEAR(r.X_WK.p.y(), 0.0, 1e-4);
  int slides = 0, turns = 0;
  for (int k = 0; k < 3; ++k) {
    const OpenDirection& open = r.open_directions[static_cast<std::size_t>(k)];
    if (open.kind == OpenDirection::Kind::slide) {
      ++slides;
      EXPECT_NEAR(open.axis_W.z(), 0.0, 0.02) << open.text();
    } else {
      ++turns;
      EXPECT_NEAR(std::abs(open.axis_W.z()), 1.0, 0.01) << open.text();
    }
  }
  // Turns about other points of the plane are a turn and a slide.
  EXPECT_EQ(slides + turns, 3);
  EXPECT_GE(turns, 1);
}

TEST(Registration, BowlTurnsAboutItsCentre) {
  const SurfaceModel model = model_of(bowl);
  SeededNormals random(4);
  Pose X_WK;
  X_WK.p = Vector3d(2e-3, -1e-3, 3e-3);
  const ShapeRegistration r = register_samples(model, seen(bowl, X_WK, 1e-4, random), {});
  ASSERT_TRUE(r.found);
  ASSERT_EQ(r.open, 3);
  const Vector3d centre(0.6, 0.0, 0.4);
  EXPECT_LT((r.X_WK * centre - X_WK * centre).norm(), 5e-5);
  for (int k = 0; k < 3; ++k) {
    const OpenDirection& open = r.open_directions[static_cast<std::size_t>(k)];
    ASSERT_EQ(open.kind, OpenDirection::Kind::turn) << open.text();
    const Vector3d off = centre + X_WK.p - open.point_W;
    EXPECT_LT(off.cross(open.axis_W).norm(), 0.01) << open.text();
  }
}

TEST(Registration, HalfPipeSlidesAndTurnsAlongItsAxis) {
  const SurfaceModel model = model_of(half_pipe);
  SeededNormals random(5);
  const ShapeRegistration r = register_samples(model, seen(half_pipe, {}, 1e-4, random), {});
  ASSERT_TRUE(r.found);
  ASSERT_EQ(r.open, 2);
  for (int k = 0; k < 2; ++k) {
    const OpenDirection& open = r.open_directions[static_cast<std::size_t>(k)];
    EXPECT_NEAR(std::abs(open.axis_W.x()), 1.0, 1e-2) << open.text();
  }
}

// A third of the samples belong to an arm that passes in front.
TEST(Registration, WhatIsNotTheBodyPullsLittle) {
  const SurfaceModel model = model_of(waves);
  SeededNormals random(6);
  const Pose X_WK = small_motion(2e-3, 0.01, random);
  std::vector<SeenPoint> samples = seen(waves, X_WK, 1e-4, random);
  for (std::size_t i = 0; i < samples.size(); i += 3) samples[i].p.z() += 0.008;
  const ShapeRegistration r = register_samples(model, samples, {});
  ASSERT_TRUE(r.found);
  EXPECT_LT((r.X_WK * r.c_W - X_WK * r.c_W).norm(), 2e-4);
}

// The covariance is that of many tries.
TEST(Registration, ErrorsAreAsTheCovarianceSays) {
  const SurfaceModel model = model_of(waves);
  double square = 0.0;
  constexpr int kTries = 60;
  for (unsigned seed = 1; seed <= kTries; ++seed) {
    SeededNormals random(100 + seed);
    const Pose X_WK = small_motion(1e-3, 5e-3, random);
    const ShapeRegistration r = register_samples(model, seen(waves, X_WK, 5e-4, random), X_WK);
    ASSERT_TRUE(r.found);
    const Pose off = r.X_WK * X_WK.inverse();
    const Eigen::AngleAxisd turn(off.R);
    Vector6 xi;
    xi << off * r.c_W - r.c_W, turn.angle() * turn.axis();
    square += xi.dot(r.information * xi);
  }
  // χ² of 6 degrees of freedom; Huber's weights lose a little, the model's cubes add a little.
  EXPECT_NEAR(square / kTries, 6.0, 2.0);
}

TEST(Registration, NothingThereIsNotFound) {
  const SurfaceModel model = model_of(flat);
  SeededNormals random(7);
  Pose away;
  away.p.z() = 0.2;
  EXPECT_FALSE(register_samples(model, seen(flat, away, 1e-4, random), {}).found);
  EXPECT_FALSE(register_samples(model, {}, {}).found);
  EXPECT_FALSE(register_samples(SurfaceModel(), seen(flat, {}, 1e-4, random), {}).found);
}

TEST(SurfaceModel, FramesAverageNoiseAway) {
  SurfaceModel model(0.006);
  SeededNormals random(8);
  const auto error = [&] {
    double square = 0.0, weights = 0.0;
    for (const SurfaceModel::Point& p : model.points()) {
      square += p.samples * std::pow(p.p.z() - 0.1, 2);
      weights += p.samples;
    }
    return std::sqrt(square / weights);
  };
  Pose X_WK = small_motion(0.0, 0.0, random);
  model.add(seen(flat, X_WK, 1e-3, random), X_WK);
  const double first = error();
  for (int frame = 1; frame < 100; ++frame) {
    X_WK = small_motion(0.05, 0.3, random);  // it moves meanwhile
    model.add(seen(flat, X_WK, 1e-3, random), X_WK);
  }
  EXPECT_NEAR(error() / first, 0.1, 0.02);
}

TEST(SurfaceModel, BothSidesOfAThinBodyStayApart) {
  SurfaceModel model(0.006);
  SeededNormals random(9);
  model.add(seen(flat, {}, 1e-5, random), {});
  const std::size_t before = model.points().size();
  std::vector<SeenPoint> below = seen(flat, {}, 1e-5, random);
  for (SeenPoint& s : below) s.n = -s.n;
  model.add(below, {});
  EXPECT_EQ(model.points().size(), before);
  for (const SurfaceModel::Point& p : model.points()) EXPECT_GT(p.n.z(), 0.9);
  EXPECT_EQ(model.nearest({0.6, 0.0, 0.1}, -Vector3d::UnitZ()), nullptr);
}

TEST(SurfaceModel, RoomIsBounded) {
  SurfaceModel model(0.002, 10);
  SeededNormals random(10);
  model.add(seen(flat, {}, 1e-5, random), {});
  EXPECT_EQ(model.points().size(), 10U);
  EXPECT_TRUE(model.full());
  EXPECT_THROW(SurfaceModel(0.0), InputError);
}

}  // namespace
}  // namespace impedraw
