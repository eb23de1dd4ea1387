// A led heading: along the tangent, derivatives by differences, turns that stay within the arm's.
#include <numbers>

#include <gtest/gtest.h>

#include "impedraw/planning/path/tip_planner.h"
#include "planning/surfaces.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;
using surfaces::line;

PathSettings led(double yaw = 0.0, double trail = 0.0, bool lifted = false) {
  PathSettings s;
  s.turn_speed = 2.0;
  s.turn_acceleration = 8.0;
  s.heading.emplace();
  s.heading->yaw = yaw;
  s.heading->trail = trail;
  s.heading->lifted = lifted;
  return s;
}

PlacedStroke sine() {
  std::vector<Vector2d> p;
  for (int i = 0; i <= 400; ++i) p.emplace_back(0.55 + 2.5e-4 * i, 0.02 * std::sin(0.06 * i));
  return line(p);
}

PlacedStroke star() {
  std::vector<Vector2d> p;
  for (int i = 0; i <= 10; ++i) {
    const double r = i % 2 ? 0.02 : 0.05, a = i * pi / 5.0;
    p.emplace_back(0.6 + r * std::cos(a), r * std::sin(a));
  }
  return line(p);
}

TEST(Heading, IsTheTangentTurned) {
  for (const double yaw : {0.0, 0.8, -pi / 2.0}) {
    const TipPath path = plan_tip_path({sine()}, surfaces::bowl, led(yaw));
    int looked = 0;
    for (double t = 0.0; t < path.duration(); t += 0.02) {
      const PathSample sample = path.at(t);
      const TipReference& r = sample.reference;
      EXPECT_NEAR(r.x_WD.norm(), 1.0, 1e-9);
      EXPECT_NEAR(r.x_WD.dot(r.n_WD), 0.0, 1e-9);
      if (sample.stroke < 0 || r.v_WD.norm() < 1e-3) continue;
      const Vector3d t_W = (r.v_WD - r.n_WD * r.n_WD.dot(r.v_WD)).normalized();
      EXPECT_NEAR(std::atan2(r.n_WD.dot(t_W.cross(r.x_WD)), t_W.dot(r.x_WD)), yaw, 1e-6);
      ++looked;
    }
    EXPECT_GT(looked, 50);
  }
}

// Angular velocity and E's velocity by central differences, with a trail, along all of a star.
TEST(Heading, RatesAreItsDerivatives) {
  for (const bool lifted : {false, true}) {
    const TipPath path = plan_tip_path({star(), sine()}, surfaces::bowl, led(0.0, 2e-3, lifted));
    constexpr double h = 1e-5;
    double fastest = 0.0;
    for (double t = 0.003; t < path.duration(); t += 0.0171) {
      const TipReference a = path.at(t - h).reference, r = path.at(t).reference,
                         b = path.at(t + h).reference;
      const Vector3d w = r.w_WD + r.yaw_rate * r.n_WD;
      ASSERT_LT(((b.x_WD - a.x_WD) / (2.0 * h) - w.cross(r.x_WD)).norm(), 2e-3) << t;
      ASSERT_LT(((b.p_WD - a.p_WD) / (2.0 * h) - r.v_WD).norm(), 2e-4) << t;
      ASSERT_LE(std::abs(r.yaw_rate), 2.0 * 1.02) << t;
      fastest = std::max(fastest, std::abs(r.yaw_rate));
    }
    EXPECT_GT(fastest, 1.0);
  }
}

// Bends turn the tool by what its turn may accelerate, and no more.
TEST(Heading, TurnsNoFasterThanItMayAccelerate) {
  PathSettings s = led();
  s.turn_acceleration = 3.0;
  s.normal_acceleration = 100.0;
  const TipPath path = plan_tip_path({sine()}, surfaces::bowl, s);
  constexpr double dt = 2e-3;
  double most = 0.0;
  for (double t = dt; t < path.duration() - dt; t += dt)
    most = std::max(
        most, std::abs(path.at(t + dt).reference.yaw_rate - path.at(t - dt).reference.yaw_rate) /
                  (2.0 * dt));
  EXPECT_LT(most, 1.02 * s.turn_acceleration);
  EXPECT_GT(most, 0.5 * s.turn_acceleration);
}

// The reference lies below the surface all along, from one part of a stroke to the next as well.
TEST(Heading, GoesOnWhereItWasBelowTheSurface) {
  for (const bool lifted : {false, true}) {
    PathSettings s = led(0.0, 0.0, lifted);
    s.sink = 0.01;
    const TipPath path = plan_tip_path({star()}, surfaces::bowl, s);
    constexpr double dt = 1e-3;
    for (double t = 0.0; t < path.duration() - dt; t += dt) {
      const TipReference a = path.at(t).reference, b = path.at(t + dt).reference;
      ASSERT_LT((b.p_WD - a.p_WD).norm(), 1.1 * dt * std::max(s.travel_speed, s.draw_speed)) << t;
    }
  }
}

TEST(Heading, ItsEdgeStaysAtTheCornerWhileItTurns) {
  const TipPath path = plan_tip_path({star()}, surfaces::bowl, led(0.0, 3e-3));
  int turns = 0;
  for (double t = 0.0; t < path.duration(); t += 0.01) {
    const PathSample s = path.at(t);
    const TipReference& r = s.reference;
    if (s.stroke < 0 || std::abs(r.yaw_rate) < 0.5) continue;
    const Vector3d edge = r.p_WD - 3e-3 * r.x_WD;
    double nearest = 1.0;
    for (const Vector2d& corner : star().p_P)
      nearest = std::min(nearest, (edge.head<2>() - corner).norm());
    if (r.v_WD.norm() > 3e-3 * std::abs(r.yaw_rate) * 1.01) continue;  // not on the spot
    EXPECT_LT(nearest, 2e-5) << t;
    ++turns;
  }
  EXPECT_GT(turns, 100);
}

// The sum of all turns stays within what the arm can do: it turns back, the long way round.
TEST(Heading, TurnsBackRatherThanBeyondTheArm) {
  for (const double half : {6.0, 3.3}) {
    PathSettings s = led();
    s.heading->least = -half;
    s.heading->most = half;
    const TipPath path = plan_tip_path({star(), star()}, surfaces::bowl, s);
    double turned = 0.0, most = 0.0;
    constexpr double dt = 1e-3;
    for (double t = 0.0; t < path.duration(); t += dt) {
      turned += dt * path.at(t).reference.yaw_rate;
      most = std::max(most, std::abs(turned));
    }
    EXPECT_LT(most, half + 0.02);
    EXPECT_GT(most, 0.5 * half);
  }
}

TEST(Heading, IsFreeWithoutSettings) {
  const TipPath path = plan_tip_path({sine()}, surfaces::bowl);
  for (double t = 0.0; t < path.duration(); t += 0.1) EXPECT_FALSE(path.at(t).reference.led());
}

}  // namespace
}  // namespace impedraw
