// A ball of radius r drawn over surfaces whose normals are known in closed form, with Coulomb
// friction, noise and compression.
#include "impedraw/sensing/touch_surface.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "allocations.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0, kDt = 1e-3;

// A surface by its signed distance; the normal is its gradient.
struct Surface {
  std::function<double(const Vector3d&)> distance;
  std::function<Vector3d(const Vector3d&)> normal;

  // The place of the ball's centre above (x, y), at distance r from the surface.
  Vector3d centre(double x, double y, double r) const {
    Vector3d c(x, y, 0.0);
    for (int i = 0; i < 60; ++i) c.z() -= (distance(c) - r) / normal(c).z();
    return c;
  }
};

Surface plane(const Vector3d& n) {
  return {[n](const Vector3d& p) { return n.dot(p); }, [n](const Vector3d&) { return n; }};
}
// Drawn on from inside.
Surface bowl(double R) {
  return {[R](const Vector3d& p) { return R - (p - Vector3d(0, 0, R)).norm(); },
          [R](const Vector3d& p) { return Vector3d((Vector3d(0, 0, R) - p).normalized()); }};
}
// Its axis along the level direction `a`; drawn on from outside.
Surface cylinder(double R, const Vector3d& a) {
  const auto across = [a, R](const Vector3d& p) {
    const Vector3d from = p + Vector3d(0, 0, R);
    return Vector3d(from - a * a.dot(from));
  };
  return {[=](const Vector3d& p) { return across(p).norm() - R; },
          [=](const Vector3d& p) { return across(p).normalized(); }};
}

struct Pen {
  double friction = 0.3, force = 5.0, speed = 0.05;
  double position_noise = 0.0, force_noise = 0.0;  // [m], [N]
  unsigned seed = 1;
};

// Draws along the polyline (x, y), at constant speed, and calls `each` after every step with the
// true normal and the length drawn so far. The pen's axis lies apart from the normal.
void draw(TouchSurface* touch, const TouchModel& model, const Surface& surface,
          const std::vector<Vector2d>& line, const Pen& pen,
          const std::function<void(const Vector3d&, double)>& each) {
  std::mt19937 random(pen.seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double s) -> Vector3d {
    return s * Vector3d(normal(random), normal(random), normal(random));
  };
  double along = 0.0;
  Vector3d last = surface.centre(line[0].x(), line[0].y(), model.tip_radius);
  for (std::size_t k = 1; k < line.size(); ++k) {
    const Vector2d a = line[k - 1], way = line[k] - a;
    const int steps = static_cast<int>(std::ceil(way.norm() / (pen.speed * kDt)));
    for (int i = 1; i <= steps; ++i) {
      const Vector2d xy = a + way * i / steps;
      Vector3d c = surface.centre(xy.x(), xy.y(), model.tip_radius);
      const Vector3d n = surface.normal(c), v = (c - last) / kDt;
      last = c;
      along += v.norm() * kDt;
      const Vector3d f = pen.force * (n - pen.friction * v.normalized());
      if (model.tip_stiffness > 0.0) c -= n * (pen.force / model.tip_stiffness);
      Pose X_WE;
      X_WE.R = (Eigen::AngleAxisd(0.2, Vector3d(1, 1, 0).normalized()) *
                Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()))
                   .toRotationMatrix();
      X_WE.p = c + model.tip_radius * X_WE.R.col(2) + noise(pen.position_noise);
      Vector6 V = Vector6::Zero();
      V.head<3>() = v;
      touch->update(X_WE, V, f + noise(pen.force_noise), true);
      each(n, along);
    }
  }
}

double degrees(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) / kDegree;
}

// What is learned, not what the pen can follow.
Vector3d learned(const TouchSurface& touch) {
  return touch.axes() * Vector3d(-touch.slope().x(), -touch.slope().y(), 1.0).normalized();
}

// The largest error from the length `from` on.
double worst_error(const Surface& surface, const std::vector<Vector2d>& line, const Pen& pen,
                   double from, const TouchModel& model = {}) {
  TouchSurface touch({}, model);
  double worst = 0.0;
  draw(&touch, model, surface, line, pen, [&](const Vector3d& n, double along) {
    if (along > from) worst = std::max(worst, degrees(learned(touch), n));
  });
  return worst;
}

const std::vector<Vector2d> kLine = {{-0.06, 0.03}, {0.06, 0.03}};
const std::vector<Vector2d> kCorner = {{-0.04, 0.03}, {0.04, 0.03}, {0.0, -0.04}};

Vector3d leaning(double degrees_x, double degrees_y) {
  return (Eigen::AngleAxisd(degrees_x * kDegree, Vector3d::UnitX()) *
          Eigen::AngleAxisd(degrees_y * kDegree, Vector3d::UnitY())) *
         Vector3d::UnitZ();
}

// The path gives the slope along the line, the force across, whatever the friction is.
TEST(TouchSurface, LearnsALeaningPlaneWithinMillimetres) {
  for (const double friction : {0.0, 0.3, 0.8})
    for (const auto& n : {leaning(30, 0), leaning(0, 30), leaning(-20, 25)}) {
      Pen pen;
      pen.friction = friction;
      const Surface leans = plane(n);
      EXPECT_LT(worst_error(leans, kLine, pen, 1e-3), 6.0) << friction << " " << n.transpose();
      EXPECT_LT(worst_error(leans, kLine, pen, 5e-3), 2.0) << friction << " " << n.transpose();
      EXPECT_LT(worst_error(leans, kLine, pen, 3e-2), 0.05) << friction << " " << n.transpose();
    }
}

// Nearly constant curvature: no lag. The bound is a tenth of what a filter with a memory of 3 mm
// would lag behind: 3 mm / 0.3 m = 0.6°.
TEST(TouchSurface, FollowsASphereAndACylinderWithoutLag) {
  EXPECT_LT(worst_error(bowl(0.3), kLine, {}, 0.02), 0.06);
  EXPECT_LT(worst_error(cylinder(0.2, Vector3d::UnitX()), kLine, {}, 0.02), 0.06);
  EXPECT_LT(worst_error(cylinder(0.2, Vector3d::UnitY()), kLine, {}, 0.02), 0.06);
  EXPECT_LT(worst_error(cylinder(0.2, Vector3d(0.6, 0.8, 0.0)), kLine, {}, 0.02), 0.06);
}

// What was along the line is across it after the corner, and known.
TEST(TouchSurface, KeepsTheNormalAtACorner) {
  TouchSurface touch({}, {});
  double worst = 0.0;
  draw(&touch, {}, bowl(0.3), kCorner, {}, [&](const Vector3d& n, double along) {
    if (along > 0.02) worst = std::max(worst, degrees(learned(touch), n));
  });
  EXPECT_LT(worst, 0.2);
}

// Of an arm with encoders of 1e-5 rad and a sensor with 0.1 N of noise at 1 kHz.
TEST(TouchSurface, AveragesNoise) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Pen pen;
    pen.position_noise = 10e-6;
    pen.force_noise = 0.1;
    pen.seed = seed;
    EXPECT_LT(worst_error(bowl(0.3), kCorner, pen, 0.01), 1.5) << seed;
    pen.position_noise = pen.force_noise = 0.0;
    EXPECT_LT(worst_error(bowl(0.3), kCorner, pen, 0.01), 0.3);
  }
}

// The axis of the drawing plane is another: a wall.
TEST(TouchSurface, WorksAlongAnyDrawingAxis) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(-1.2, Vector3d::UnitY()).toRotationMatrix();
  TouchModel model, level;
  model.drawing_axis_W = turn.col(2);
  TouchSurface touch({}, model);
  const Vector3d n = leaning(15, -10);
  const Surface surface = plane(n);
  double error = 0.0;
  Vector3d last = surface.centre(0, 0, level.tip_radius);
  for (int i = 0; i <= 400; ++i) {
    const Vector3d c = surface.centre(5e-5 * i, 2e-5 * i, level.tip_radius);
    const Vector3d v = (c - last) / kDt;
    last = c;
    Pose X_WE;
    X_WE.R = turn * Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()).toRotationMatrix();
    X_WE.p = turn * Vector3d(c - n * 5.0 / level.tip_stiffness) + level.tip_radius * X_WE.R.col(2);
    Vector6 V = Vector6::Zero();
    V.head<3>() = turn * v;
    touch.update(X_WE, V, turn * Vector3d(5.0 * (n - 0.3 * v.stableNormalized())), true);
    error = degrees(learned(touch), turn * n);
  }
  EXPECT_LT(error, 0.1);
}

// At rest friction may hide a slope: the guess lies between.
TEST(TouchSurface, GuessesTheNormalOfAStandingPen) {
  const double mu = 0.3;
  for (const Vector3d& n : {leaning(0, 30), leaning(30, 0), leaning(-30, 0)}) {
    const Vector3d uphill = (Vector3d::UnitZ() - n * n.z()).normalized();
    TouchSurface touch({}, {});
    Pose X_WE;
    X_WE.R = Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()).toRotationMatrix();
    const Vector3d f = 5.0 * (n + mu * uphill);
    for (int i = 0; i < 200; ++i) touch.update(X_WE, Vector6::Zero(), f, true);
    const double error = degrees(learned(touch), n);
    EXPECT_GT(error, 5.0);
    EXPECT_LT(error, std::atan(mu) / kDegree + 3.0);
  }
}

// Before a touch: the level plane where the pen was first wanted down. After it: where it touched.
TEST(TouchSurface, IsSearchedForBeneathTheFirstApproach) {
  const TouchModel model;
  TouchSurface touch({}, model);
  Pose X_WE;
  X_WE.R = Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()).toRotationMatrix();
  X_WE.p.z() = 0.2;
  const auto step = [&](double f, bool down) {
    return touch.update(X_WE, Vector6::Zero(), {0, 0, f}, down);
  };
  EXPECT_NEAR(step(0.0, true).distance, 0.0, 1e-12);
  X_WE.p.z() = 0.1;
  EXPECT_NEAR(step(0.0, true).distance, -0.1, 1e-12);
  EXPECT_EQ(touch.estimate().status, SurfaceStatus::ok);
  EXPECT_FALSE(touch.touched());
  step(1.0, true);
  EXPECT_TRUE(touch.touched());
  X_WE.p.z() = 0.102;
  EXPECT_NEAR(step(0.0, true).distance, 0.002, 1e-4);
  X_WE.p.z() = 0.09;
  EXPECT_EQ(step(0.0, true).status, SurfaceStatus::off_edge) << "the surface has ended";
  step(0.0, false);
  EXPECT_NEAR(step(0.0, true).distance, 0.0, 1e-12) << "the next stroke";
}

// The reported normal turns no faster than asked, takes up speed and slows down, and arrives.
TEST(TouchSurface, TurnsSlowly) {
  TouchSettings settings;
  TouchSurface touch(settings, {});
  Vector3d last = Vector3d::UnitZ();
  double fastest = 0.0, jerkiest = 0.0, speed = 0.0;
  draw(&touch, {}, plane(leaning(30, 0)), kLine, {}, [&](const Vector3d&, double along) {
    const double next = degrees(touch.estimate().n_W, last) * kDegree / kDt;
    if (along > 1e-4) jerkiest = std::max(jerkiest, std::abs(next - speed) / kDt);
    speed = next;
    fastest = std::max(fastest, speed);
    last = touch.estimate().n_W;
  });
  EXPECT_LE(fastest, settings.turn_rate * (1 + 1e-6));
  EXPECT_GT(fastest, settings.turn_rate * 0.9);
  EXPECT_LT(jerkiest, 2.0 * settings.turn_rate / 0.1);
  EXPECT_LT(degrees(last, leaning(30, 0)), 0.1);
}

// Next to the tip, along the line, the normal is that of the learned curvature.
TEST(TouchSurface, TellsTheNormalNextToTheTip) {
  const Surface surface = bowl(0.3);
  TouchSurface touch({}, {});
  const double r = TouchModel().tip_radius;
  draw(&touch, {}, surface, kCorner, {}, [](const Vector3d&, double) {});
  const Vector2d end = kCorner.back();
  const Vector2d beside = end + 4e-3 * (end - kCorner[1]).normalized();
  const Vector3d c = surface.centre(end.x(), end.y(), r),
                 d = surface.centre(beside.x(), beside.y(), r);
  Pose X_WE;
  X_WE.R = (Eigen::AngleAxisd(0.2, Vector3d(1, 1, 0).normalized()) *
            Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()))
               .toRotationMatrix();
  const double turned =
      degrees(touch.estimate_at(c + r * X_WE.R.col(2) + (d - c)).n_W, touch.estimate().n_W);
  EXPECT_NEAR(turned, degrees(surface.normal(c), surface.normal(d)), 0.1);
  EXPECT_LT(degrees(touch.estimate_at(c + r * X_WE.R.col(2) + (d - c)).n_W, surface.normal(d)),
            0.3);
}

TEST(TouchSurface, AllocatesNothing) {
  const TouchModel model;
  TouchSurface touch({}, model);
  Pose X_WE;
  Vector6 V = Vector6::Constant(0.01);
  const auto drawn = [&] {
    for (int i = 0; i < 1000; ++i) {
      X_WE.p.x() += 5e-5;
      touch.update(X_WE, V, {0.1, 0.2, 5.0}, i > 3);
    }
  };
  EXPECT_EQ(allocations_in(drawn), 0);
}

TEST(TouchSurface, RefusesSettingsOutOfRange) {
  TouchSettings settings;
  settings.curvature_length = 0.0;
  EXPECT_THROW(TouchSurface(settings, {}), InputError);
  TouchModel model;
  model.drawing_axis_W = {0, 0, 2};
  EXPECT_THROW(TouchSurface({}, model), InputError);
}

}  // namespace
}  // namespace impedraw
