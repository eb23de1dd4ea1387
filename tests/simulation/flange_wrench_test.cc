// The wrench at the flange of the iiwa: its pen is a rod of 50 g and 0.12 m, c.o.m. at 0.06 m,
// typed in here by hand.
#include <cmath>

#include <gtest/gtest.h>

#include "worlds.h"

namespace impedraw {
namespace {

using namespace testing_worlds;
using Eigen::Vector3d;

constexpr double kMass = 0.05, kGravity = 9.81, kCentre = 0.06, kLength = 0.12;
const Vector3d kInertia(
    6e-5, 6e-5, 6.25e-7);  // about the c.o.m., along x, y, z of the pen, which are those of S and E

WorldSettings sensing(double dt = 1e-3, const ModelErrors& errors = {}) {
  WorldSettings settings = with(errors, dt);
  settings.flange_sensor = true;
  return settings;
}

Vector6 in_flange(const Vector3d& f_W, const Vector3d& m_S_W, const Eigen::Matrix3d& R_WS) {
  Vector6 F;
  F << R_WS.transpose() * f_W, R_WS.transpose() * m_S_W;
  return F;
}

// Weight of the pen, and a wrench at E.
Vector6 static_wrench(const Pose& X_WE, const Vector6& F_W, double mass = kMass) {
  const Vector3d z = X_WE.R.col(2), weight(0.0, 0.0, -mass * kGravity);
  return in_flange(weight + F_W.head<3>(),
                   kCentre * z.cross(weight) + kLength * z.cross(F_W.head<3>()) + F_W.tail<3>(),
                   X_WE.R);
}

TEST(FlangeWrench, AtRestIsTheWeightOfThePen) {
  std::mt19937 rng(1);
  SCOPED_TRACE("seed 1");
  World world(kArm, nullptr, sensing());
  World heavy(kArm, nullptr, sensing(1e-3, {.mass_scale = 1.3}));
  EXPECT_TRUE(world.has_flange());
  for (int i = 0; i < 20; ++i) {
    const JointVector q = random_vector(rng, 7, 2.0);
    world.set_state(q, JointVector::Zero(7));
    EXPECT_LT((world.flange_wrench() - static_wrench(world.state().X_WE, Vector6::Zero())).norm(),
              1e-12);
    for (int k = 0; k < 10; ++k) world.step(world.terms().bias, Vector3d::Zero());
    EXPECT_LT((world.flange_wrench() - static_wrench(world.state().X_WE, Vector6::Zero())).norm(),
              1e-8);
    EXPECT_NEAR(world.flange_wrench().head<3>().norm(), 0.4905, 1e-8);
    heavy.set_state(q, JointVector::Zero(7));
    EXPECT_LT(
        (heavy.flange_wrench() - static_wrench(world.state().X_WE, Vector6::Zero(), 1.3 * kMass))
            .norm(),
        1e-8);
  }
}

TEST(FlangeWrench, HeldAgainstAPushAddsThePush) {
  World world(kArm, nullptr, sensing());
  world.set_state(working_posture(), JointVector::Zero(7));
  Vector6 push;
  push << 3.0, -4.0, 10.0, 0.2, 0.1, -0.3;
  for (int k = 0; k < 10; ++k) {
    const World::Terms terms = world.terms();
    world.step(terms.bias - terms.J.transpose() * push, push);
  }
  EXPECT_LT((world.flange_wrench() - static_wrench(world.state().X_WE, push)).norm(), 1e-7);
}

struct Rod {
  Vector3d c, P, L;
  explicit Rod(const WorldState& s) {
    const Vector3d w = s.V_WE.tail<3>(), to_c = -(kLength - kCentre) * s.X_WE.R.col(2);
    c = s.X_WE.p + to_c;
    P = kMass * (s.V_WE.head<3>() + w.cross(to_c));
    L = s.X_WE.R * kInertia.asDiagonal() * s.X_WE.R.transpose() * w;
  }
};

// From the states before and after a step: the forces on the rod minus its change of momentum.
Vector6 balance(const WorldState& before, const WorldState& after, const TipContact& contact,
                const Vector6& push, double dt) {
  const Rod a(before), b(after);
  const Vector3d p_WS = before.X_WE.p - kLength * before.X_WE.R.col(2);
  const Vector3d f =
      contact.f_W + push.head<3>() + Vector3d(0, 0, -kMass * kGravity) - (b.P - a.P) / dt;
  const Vector3d m_c = (contact.p_WC - a.c).cross(contact.f_W) +
                       (before.X_WE.p - a.c).cross(push.head<3>()) + push.tail<3>() -
                       (b.L - a.L) / dt;
  return in_flange(f, m_c + (a.c - p_WS).cross(f), before.X_WE.R);
}

TEST(FlangeWrench, InMotionAndContactBalancesTheRodsMomentum) {
  std::mt19937 rng(2);
  SCOPED_TRACE("seed 2");
  const WorldSettings settings = sensing();
  World probe(kArm, nullptr, settings);
  probe.set_state(working_posture(), JointVector::Zero(7));
  const Canvas canvas = plane_under(probe.state().X_WE.p, -2e-3);
  World world(kArm, &canvas, settings);
  int touched = 0;
  double inertial = 0.0;
  for (int run = 0; run < 20; ++run) {
    world.set_state(working_posture(), random_vector(rng, 7, 0.5));
    for (int i = 0; i < 50; ++i) {
      const WorldState before = world.state();
      Vector6 push;
      push << random_vector(rng, 3, 10.0), random_vector(rng, 3, 0.5);
      const TipContact contact = world.step(world.terms().bias + random_vector(rng, 7, 5.0), push);
      touched += contact.touching;
      const Vector6 expected = balance(before, world.state(), contact, push, settings.dt);
      EXPECT_LT((world.flange_wrench() - expected).norm(), 1e-8);
      Vector6 still = push;
      still.head<3>() += contact.f_W;
      still.tail<3>() += (contact.p_WC - before.X_WE.p).cross(contact.f_W);
      inertial = std::max(inertial, (expected - static_wrench(before.X_WE, still)).norm());
    }
  }
  EXPECT_GT(touched, 50);
  EXPECT_GT(inertial, 1.0);  // not negligible
}

// Without finite differences: the arm turns about the vertical at constant speed, so the pen pulls
// outward.
TEST(FlangeWrench, TurningSteadilyIsTheCentrifugalWrench) {
  const double w = 1.2, dt = 1e-5;
  World world(kArm, nullptr, sensing(dt));
  world.set_state(working_posture(), w * JointVector::Unit(7, 0));
  const Pose X_WE = world.state().X_WE;
  const Vector6 weight = world.flange_wrench();
  world.step(world.terms().bias, Vector3d::Zero());
  const Vector3d W = w * Vector3d::UnitZ(), z = X_WE.R.col(2), c = X_WE.p - (kLength - kCentre) * z;
  const Vector3d f = kMass * w * w * Vector3d(c.x(), c.y(), 0.0);
  const Eigen::Matrix3d I_W = X_WE.R * kInertia.asDiagonal() * X_WE.R.transpose();
  const Vector6 expected = in_flange(f, kCentre * z.cross(f) - W.cross(I_W * W), X_WE.R);
  const Vector6 measured = world.flange_wrench() - weight;
  EXPECT_LT((measured.head<3>() - expected.head<3>()).norm(), 2e-5 * expected.head<3>().norm());
  EXPECT_LT((measured.tail<3>() - expected.tail<3>()).norm(), 2e-5 * expected.tail<3>().norm());
  EXPECT_GT(expected.head<3>().norm(), 0.02);
}

// The last joint's axis is the pen's: started with a known angular acceleration, its rod resists
// with −I_zz α.
TEST(FlangeWrench, SpunUpAboutItsAxisResistsWithItsInertia) {
  World world(kArm, nullptr, sensing());
  world.set_state(working_posture(), JointVector::Zero(7));
  const World::Terms terms = world.terms();
  const double m_z = world.flange_wrench()[5];
  world.step(terms.bias + terms.M * (50.0 * JointVector::Unit(7, 6)), Vector3d::Zero());
  EXPECT_NEAR(world.flange_wrench()[5] - m_z, -6.25e-7 * 50.0, 1e-9);
}

TEST(FlangeWrench, PressedOnACanvasAtRestIsContactAndWeight) {
  WorldSettings settings = sensing(1e-3, {.viscous_friction = 5.0});
  World probe(kArm, nullptr, settings);
  probe.set_state(working_posture(), JointVector::Zero(7));
  const Canvas canvas = plane_under(probe.state().X_WE.p, 0.0);
  World world(kArm, &canvas, settings);
  world.set_state(working_posture(), JointVector::Zero(7));
  TipContact contact;
  Vector3d p_WE;
  for (int i = 0; i < 3000; ++i) {
    const World::Terms terms = world.terms();
    p_WE = world.state().X_WE.p;
    contact = world.step(terms.bias - 8.0 * terms.J.row(2).transpose(), Vector3d::Zero());
  }
  Vector6 at_tip;
  at_tip << contact.f_W, (contact.p_WC - p_WE).cross(contact.f_W);
  EXPECT_GT(contact.f_W.z(), 5.0);
  EXPECT_LT((world.flange_wrench() - static_wrench(world.state().X_WE, at_tip)).norm(), 1e-3);
}

TEST(FlangeWrench, IsZeroWithoutASensorOrAFlange) {
  World off(kArm, nullptr, {});
  off.set_state(working_posture(), JointVector::Zero(7));
  off.step(JointVector::Zero(7), Vector3d::Zero());
  EXPECT_TRUE(off.has_flange());
  EXPECT_EQ(off.flange_wrench(), Vector6(Vector6::Zero()));
  World slider(kSlider, nullptr, sensing());
  slider.step(JointVector::Ones(3), Vector3d::Ones());
  EXPECT_FALSE(slider.has_flange());
  EXPECT_EQ(slider.flange_wrench(), Vector6(Vector6::Zero()));
}

TEST(FlangeWrench, MeasuringChangesNoMotion) {
  World with_sensor(kArm, nullptr, sensing()), without(kArm, nullptr, {});
  for (World* world : {&with_sensor, &without}) {
    world->set_state(working_posture(), JointVector::Constant(7, 0.3));
    for (int i = 0; i < 100; ++i) world->step(JointVector::Ones(7), Vector3d::Ones());
  }
  EXPECT_EQ(with_sensor.state().q, without.state().q);
}

}  // namespace
}  // namespace impedraw
