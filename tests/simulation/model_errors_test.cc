// The simulated arm with model errors: each error against a closed form, the momentum balance of a
// step, or a table typed in by hand.
#include "impedraw/simulation/world_settings.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "scratch_folder.h"
#include "worlds.h"

namespace impedraw {
namespace {

using namespace testing_worlds;
const Eigen::Vector3d kNoPush = Eigen::Vector3d::Zero();

World iiwa(const ModelErrors& errors, double dt = 1e-3) {
  return World(kArm, nullptr, with(errors, dt));
}
World slider(const ModelErrors& errors, double dt = 1e-3) {
  return World(kSlider, nullptr, with(errors, dt));
}

TEST(ModelErrors, MassScaleMultipliesInertiaAndBiasOfEveryLink) {
  World urdf = iiwa({}), heavy = iiwa({.mass_scale = 1.07});
  std::mt19937 rng(1);
  SCOPED_TRACE("seed 1");
  for (int i = 0; i < 20; ++i) {
    const JointVector q = random_vector(rng, 7, 2.0), v = random_vector(rng, 7, 1.0);
    urdf.set_state(q, v);
    heavy.set_state(q, v);
    const World::Terms a = urdf.terms(), b = heavy.terms();
    EXPECT_LT((b.M - 1.07 * a.M).norm(), 1e-12 * a.M.norm());
    EXPECT_LT((b.bias - 1.07 * a.bias).norm(), 1e-12 * a.bias.norm());
    EXPECT_LT((b.J - a.J).norm(), 1e-12);
  }
}

// Potential energy of the iiwa with its pen, from the table in its URDF, with every link's c.o.m.
// shifted by `shift` along (1,1,1)/√3.
double potential_energy(const JointVector& q, double shift, double mass_scale) {
  struct Link {
    Eigen::Vector3d origin;
    double roll, yaw;
    double mass;
    Eigen::Vector3d com;
  };
  const double right = std::numbers::pi / 2, half = std::numbers::pi;
  const std::vector<Link> links = {{{0, 0, 0.1575}, 0, 0, 5.76, {0, -0.03, 0.12}},
                                   {{0, 0, 0.2025}, right, half, 6.35, {0.0003, 0.059, 0.042}},
                                   {{0, 0.2045, 0}, right, half, 3.5, {0, 0.03, 0.13}},
                                   {{0, 0, 0.2155}, right, 0, 3.5, {0, 0.067, 0.034}},
                                   {{0, 0.1845, 0}, right, half, 3.5, {0.0001, 0.021, 0.076}},
                                   {{0, 0, 0.2155}, right, 0, 1.8, {0, 0.0006, 0.0004}},
                                   {{0, 0.081, 0}, right, half, 1.2, {0, 0, 0.02}}};
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  double energy = 0.0;
  for (int j = 0; j < 7; ++j) {
    const Link& link = links[static_cast<std::size_t>(j)];
    X = X * Eigen::Translation3d(link.origin) *
        Eigen::AngleAxisd(link.yaw, Eigen::Vector3d::UnitZ()) *
        Eigen::AngleAxisd(link.roll, Eigen::Vector3d::UnitX()) *
        Eigen::AngleAxisd(q[j], Eigen::Vector3d::UnitZ());
    energy += mass_scale * link.mass * 9.81 *
              (X * (link.com + Eigen::Vector3d::Constant(shift / std::sqrt(3.0)))).z();
  }
  return energy + mass_scale * 0.05 * 9.81 * (X * Eigen::Vector3d(0, 0, 0.045 + 0.06)).z();
}

TEST(ModelErrors, CentreShiftChangesTheHoldingTorqueAsPotentialEnergySays) {
  std::mt19937 rng(2);
  SCOPED_TRACE("seed 2");
  World urdf = iiwa({});
  double most = 0.0;
  for (const double shift : {0.0, 0.005, -0.02}) {
    World world = iiwa({.mass_scale = 1.05, .centre_shift = shift});
    for (int i = 0; i < 10; ++i) {
      const JointVector q = random_vector(rng, 7, 2.0);
      world.set_state(q, JointVector::Zero(7));
      urdf.set_state(q, JointVector::Zero(7));
      const Eigen::VectorXd g = world.terms().bias;
      most = std::max(most, (g - 1.05 * urdf.terms().bias).cwiseAbs().maxCoeff());
      for (int j = 0; j < 7; ++j) {
        JointVector a = q, b = q;
        a[j] += 1e-5;
        b[j] -= 1e-5;
        EXPECT_NEAR(g[j],
                    (potential_energy(a, shift, 1.05) - potential_energy(b, shift, 1.05)) / 2e-5,
                    1e-6)
            << "joint " << j;
      }
    }
  }
  EXPECT_GT(most, 1.0);  // not negligible
}

TEST(ModelErrors, RotorInertiaStandsOnTheDiagonalAndWeighsNothing) {
  World urdf = iiwa({}), geared = iiwa({.rotor_inertia = {0.4}});
  const JointVector q = working_posture(), v = JointVector::Constant(7, 0.5);
  urdf.set_state(q, v);
  geared.set_state(q, v);
  EXPECT_LT((geared.terms().M - urdf.terms().M - 0.4 * Eigen::MatrixXd::Identity(7, 7)).norm(),
            1e-12);
  EXPECT_LT((geared.terms().bias - urdf.terms().bias).norm(), 1e-12);

  // 2.5 kg along x, and 0.5 kg of rotor inertia on the joint
  World world = slider({.rotor_inertia = {0.5}});
  world.step(JointVector::Unit(3, 0), kNoPush);
  EXPECT_NEAR(world.state().v[0], 1e-3 / 3.0, 1e-15);
}

double coast(double b, double time, double dt) {
  World world = slider({.viscous_friction = b}, dt);
  world.set_state(JointVector::Zero(3), 0.5 * JointVector::Unit(3, 0));
  for (int i = 0; i < std::lround(time / dt); ++i) world.step(JointVector::Zero(3), kNoPush);
  return world.state().v[0];
}

TEST(ModelErrors, AJointCoastsDownExponentiallyUnderViscousFriction) {
  const double m = 2.5, b = 5.0, time = 1.0, exact = 0.5 * std::exp(-b * time / m);
  EXPECT_NEAR(coast(b, time, 1e-3), 0.5 * std::pow(1.0 + 1e-3 * b / m, -1000.0),
              1e-12);  // implicit Euler, by its own formula
  EXPECT_NEAR(coast(b, time, 1e-3), exact, 0.0025 * exact);
  EXPECT_NEAR((coast(b, time, 1e-3) - exact) / (coast(b, time, 0.5e-3) - exact), 2.0,
              0.01);  // first order
}

TEST(ModelErrors, ViscousFrictionIsNoInertia) {
  World urdf = iiwa({}), viscous = iiwa({.viscous_friction = 3.0});
  urdf.set_state(working_posture(), JointVector::Constant(7, 0.3));
  viscous.set_state(working_posture(), JointVector::Constant(7, 0.3));
  EXPECT_LT((urdf.terms().M - viscous.terms().M).norm(), 1e-12);
  EXPECT_LT((urdf.terms().bias - viscous.terms().bias).norm(), 1e-12);
}

TEST(ModelErrors, ViscousFrictionFarBeyondTheWristsInertiaIsStable) {
  for (const double b :
       {1.0, 10.0, 100.0}) {  // explicitly, 2 I/h ≈ 2 Nm s/rad on the last joint would blow up
    World world = iiwa({.viscous_friction = b});
    world.set_state(working_posture(), JointVector::Constant(7, 1.0));
    double energy = 1e9;
    for (int i = 0; i < 300; ++i) {
      const World::Terms terms = world.terms();
      const double now = 0.5 * world.state().v.dot(terms.M * world.state().v);
      EXPECT_LE(now, energy);
      energy = now;
      world.step(terms.bias, kNoPush);
    }
    EXPECT_FALSE(world.failure());
  }
}

// <dynamics> of a URDF, in every joint a different one.
class UrdfDynamics : public ScratchFolder {
 protected:
  World arm(const std::string& urdf, const JointVector& damping, const JointVector& friction,
            double dt = 1e-3) const {
    std::ifstream file(urdf);
    std::string text(std::istreambuf_iterator<char>(file), {});
    std::size_t at = 0;
    for (Eigen::Index j = 0; j < damping.size(); ++j) {
      at = text.find("<limit", at);
      const std::string dynamics =
          fmt::format("<dynamics damping=\"{}\" friction=\"{}\"/>", damping[j], friction[j]);
      text.insert(at, dynamics);
      at += dynamics.size() + 1;
    }
    return World(write("arm.urdf", text), nullptr, with({}, dt));
  }
};

TEST_F(UrdfDynamics, BrakeEachJointAsTheClosedFormSays) {
  const JointVector b = Eigen::Vector3d(4.0, 0.0, 7.0), dry = Eigen::Vector3d(1.5, 0.6, 0.0);
  const Eigen::Vector3d mass(2.5, 2.25, 2.0);
  const double h = 1e-3;
  World world = arm(kSlider, b, dry, h);
  JointVector v = Eigen::Vector3d(0.5, -0.4, 0.3);
  world.set_state(JointVector::Zero(3), v);
  JointVector hold = JointVector::Zero(3);
  hold[2] = world.terms().bias[2];
  EXPECT_LT((world.terms().M.diagonal() - mass).norm(), 1e-12) << "damping is no inertia";
  for (int i = 0; i < 2000; ++i) {
    for (int j = 0; j < 3; ++j) {  // m (v⁺ − v) = −h b v⁺ − p, |p| ≤ h F
      const double free = mass[j] * v[j];
      v[j] = (free - std::clamp(free, -h * dry[j], h * dry[j])) / (mass[j] + h * b[j]);
    }
    world.step(hold, kNoPush);
    ASSERT_LT((world.state().v - v).norm(), 1e-9) << i;
  }
  EXPECT_EQ(v[0], 0.0);
}

// Explicitly, more than 2 I/h ≈ 2 Nm s/rad would blow up the last joint.
TEST_F(UrdfDynamics, FarBeyondTheWristsInertiaAreStable) {
  const JointVector none = JointVector::Zero(7);
  for (const double b : {1.0, 10.0, 100.0}) {
    World world = arm(kArm, JointVector::Constant(7, b), none);
    World told = iiwa({.viscous_friction = b});
    for (World* each : {&world, &told}) {
      each->set_state(working_posture(), JointVector::Constant(7, 1.0));
      for (int i = 0; i < 300; ++i) each->step(each->terms().bias, kNoPush);
    }
    EXPECT_FALSE(world.failure());
    EXPECT_EQ(world.state().v, told.state().v);
  }
}

TEST(ModelErrors, DryAndViscousFrictionTogetherStopWhereTheClosedFormSays) {
  const double m = 2.5, b = 4.0, dry = 1.5, v0 = 0.5;
  WorldSettings settings = with({.viscous_friction = b}, 1e-4);
  settings.joint_friction = dry;
  World world(kSlider, nullptr, settings);
  world.set_state(JointVector::Zero(3), v0 * JointVector::Unit(3, 0));
  JointVector hold = JointVector::Zero(3);
  hold[2] = world.terms().bias[2];
  const double stop = m / b * std::log(1.0 + b * v0 / dry);  // m v̇ = −b v − F
  double stopped = 0.0;
  while (world.state().time < 2.0 * stop) {
    const double t = world.state().time;
    if (t < stop) {
      EXPECT_NEAR(world.state().v[0], (v0 + dry / b) * std::exp(-b * t / m) - dry / b, 1e-4);
    }
    if (world.state().v[0] > 1e-12) stopped = t;
    world.step(hold, kNoPush);
  }
  EXPECT_NEAR(stopped, stop, 3e-4);
  const double rest = (v0 + dry / b) * m / b * (1.0 - std::exp(-b * stop / m)) - dry / b * stop;
  EXPECT_NEAR(world.state().q[0], rest, 1e-4);

  hold[0] = 0.99 * dry;
  for (int i = 0; i < 1000; ++i) world.step(hold, kNoPush);
  EXPECT_NEAR(world.state().q[0], rest, 1e-4);
  hold[0] = dry + b * 0.1;  // and above it, the speed at which viscous friction takes up the rest
  for (int i = 0; i < 60000; ++i) world.step(hold, kNoPush);
  EXPECT_NEAR(world.state().v[0], 0.1, 1e-4);
}

// A whole step of the arm: the residual of the momentum balance must be dry friction that obeys its
// law.
TEST(ModelErrors, FrictionAndContactFitTheSameNewVelocity) {
  const double b = 0.5, dry = 0.4, h = 1e-3;
  std::mt19937 rng(3);
  SCOPED_TRACE("seed 3");
  WorldSettings settings = with(
      {.mass_scale = 1.05, .centre_shift = 0.003, .viscous_friction = b, .rotor_inertia = {0.1}});
  settings.joint_friction = dry;
  World probe(kArm, nullptr, settings);
  int stuck = 0, sliding = 0;
  for (int i = 0; i < 200; ++i) {
    const JointVector q = working_posture() + random_vector(rng, 7, 0.3),
                      v = random_vector(rng, 7, i % 2 ? 0.3 : 1e-3);
    probe.set_state(q, v);
    const Canvas canvas = plane_under(probe.state().X_WE.p, 0.3e-3);
    World world(kArm, &canvas, settings);
    world.set_state(q, v);
    const World::Terms terms = world.terms();
    const Eigen::Vector3d p_WE = world.state().X_WE.p;
    const JointVector tau = terms.bias + random_vector(rng, 7, 0.5);
    Vector6 push;
    push << random_vector(rng, 3, 5.0), random_vector(rng, 3, 0.2);
    const TipContact contact = world.step(tau, push);
    const JointVector& after = world.state().v;
    ASSERT_TRUE(contact.touching);

    Vector6 F = push;
    F.head<3>() += contact.f_W;
    F.tail<3>() += (contact.p_WC - p_WE).cross(contact.f_W);
    const JointVector friction =
        terms.M * (after - v) / h - (tau - terms.bias + terms.J.transpose() * F) + b * after;
    for (int j = 0; j < 7; ++j) {
      const bool moves = std::abs(after[j]) >
                         1e-5;  // [rad/s], residual speed of a sticking joint after 200 sweeps
      (moves ? sliding : stuck) += 1;
      EXPECT_LE(std::abs(friction[j]), dry + 1e-6);
      if (moves) {
        EXPECT_NEAR(friction[j], -std::copysign(dry, after[j]), 1e-6);
      }
    }
    const Vector6 V = terms.J * after;
    const Eigen::Vector3d v_C = V.head<3>() + V.tail<3>().cross(contact.p_WC - p_WE);
    const double depth =
        settings.tip.radius -
        (p_WE - settings.tip.radius * probe.state().X_WE.R.col(2) - contact.p_WC).norm();
    const double expected =
        settings.tip.stiffness * depth - settings.tip.damping * contact.n_W.dot(v_C);
    EXPECT_NEAR(contact.f_W.dot(contact.n_W), std::max(0.0, expected), 1e-5);
  }
  EXPECT_GT(stuck, 100);
  EXPECT_GT(sliding, 100);
}

TEST(ModelErrors, RippleHasThirtyPeriodsATurnAndItsOwnPhaseOnEachJoint) {
  const double amplitude = 0.25;
  World world = iiwa({.torque_ripple = amplitude});
  const JointVector tau = JointVector::LinSpaced(7, -3.0, 3.0);
  const auto ripple = [&](double angle) -> JointVector {
    world.set_state(JointVector::Constant(7, angle), JointVector::Zero(7));
    world.step(tau, kNoPush);
    return world.applied_torque() - tau;
  };
  const int samples = 3600;
  JointVector mean_square = JointVector::Zero(7), most = JointVector::Zero(7),
              last = ripple(0.0003 - std::numbers::pi);
  Eigen::VectorXi sign_changes = Eigen::VectorXi::Zero(7);
  for (int i = 1; i <= samples; ++i) {
    const JointVector r = ripple(0.0003 - std::numbers::pi + 2.0 * std::numbers::pi * i / samples);
    mean_square += r.cwiseAbs2() / samples;
    most = most.cwiseMax(r.cwiseAbs());
    for (int j = 0; j < 7; ++j) sign_changes[j] += r[j] * last[j] < 0.0;
    last = r;
  }
  for (int j = 0; j < 7; ++j) {
    EXPECT_NEAR(most[j], amplitude, 0.01 * amplitude);
    EXPECT_NEAR(mean_square[j], amplitude * amplitude / 2.0, 1e-6);  // that of a sinus
    EXPECT_NEAR(sign_changes[j], 60, 1);
    for (int k = 0; k < j; ++k)
      EXPECT_GT((ripple(0.1) - ripple(0.1)[k] * JointVector::Ones(7)).cwiseAbs()[j],
                0.01 * amplitude);
  }
  EXPECT_LT((ripple(0.3) - ripple(0.3 + 2.0 * std::numbers::pi / 30.0)).norm(), 1e-12);

  World light = slider({.torque_ripple = amplitude});
  light.set_state(JointVector::Constant(3, 0.01), JointVector::Zero(3));
  light.step(JointVector::Zero(3), kNoPush);
  EXPECT_NEAR(light.state().v[0], 1e-3 * amplitude * std::sin(0.3) / 2.5,
              1e-12);  // φ_0 = 0; and the arm feels it
}

TEST(ModelErrors, TorqueActsInMultiplesOfTheQuantum) {
  World world = iiwa({.torque_quantum = 0.05});
  std::mt19937 rng(4);
  SCOPED_TRACE("seed 4");
  world.set_state(working_posture(), JointVector::Zero(7));
  for (int i = 0; i < 100; ++i) {
    const JointVector tau = random_vector(rng, 7, 39.0);
    world.step(tau, kNoPush);
    for (int j = 0; j < 7; ++j) {
      const double applied = world.applied_torque()[j];
      EXPECT_NEAR(applied / 0.05, std::round(applied / 0.05), 1e-9);
      EXPECT_LE(std::abs(applied - tau[j]), 0.025 + 1e-12);
    }
  }
  World light = slider({.torque_quantum = 0.5});
  light.step(0.7 * JointVector::Unit(3, 0), kNoPush);
  EXPECT_NEAR(light.state().v[0], 1e-3 * 0.5 / 2.5, 1e-15);
}

TEST(ModelErrors, TorqueActsExactlySoManyStepsLater) {
  for (const int delay : {0, 1, 3, 15}) {
    for (const double dt : {1e-3, 0.5e-3}) {
      SCOPED_TRACE(testing::Message() << delay << " steps of " << dt << " s");
      World world = slider({.loop_delay = delay * dt}, dt);
      for (int run = 0; run < 2;
           ++run) {  // the second after other torques, which set_state() must clear
        world.set_state(JointVector::Zero(3), JointVector::Zero(3));
        EXPECT_EQ(world.applied_torque(), JointVector(JointVector::Zero(3)));
        double v = 0.0;
        for (int i = 0; i < 40; ++i) {
          const auto command = [&](int k) {
            return 1.0 + 0.1 * run + std::max(0, k);
          };  // the first acts from the start
          world.step(command(i) * JointVector::Unit(3, 0), kNoPush);
          EXPECT_EQ(world.applied_torque()[0], command(i - delay));
          v += dt * command(i - delay) / 2.5;
          EXPECT_NEAR(world.state().v[0], v, 1e-12);
        }
      }
    }
  }
}

TEST(ModelErrors, ALongerPenPutsTheTrueTipFurtherOutAlongIt) {
  const double longer = 0.004;
  World urdf = iiwa({}), world = iiwa({.pen_longer = longer});
  std::mt19937 rng(5);
  SCOPED_TRACE("seed 5");
  for (int i = 0; i < 20; ++i) {
    const JointVector q = random_vector(rng, 7, 2.0), v = random_vector(rng, 7, 1.0);
    urdf.set_state(q, v);
    world.set_state(q, v);
    const WorldState &a = urdf.state(), &b = world.state();
    const Eigen::Vector3d out = longer * a.X_WE.R.col(2);
    EXPECT_LT((b.X_WE.p - a.X_WE.p - out).norm(), 1e-12);
    EXPECT_LT((b.X_WE.R - a.X_WE.R).norm(), 1e-12);
    EXPECT_LT((b.V_WE.head<3>() - a.V_WE.head<3>() - a.V_WE.tail<3>().cross(out)).norm(), 1e-12);
    EXPECT_LT((urdf.terms().M - world.terms().M).norm(), 1e-12);
  }

  const Canvas canvas =
      plane_under(Eigen::Vector3d::Zero(),
                  0.0);  // the slider's tip points down: it touches while the URDF's is above
  World touching(kSlider, &canvas, with({.pen_longer = longer}));
  touching.set_state((longer - 1e-4) * JointVector::Unit(3, 2), JointVector::Zero(3));
  EXPECT_NEAR(touching.state().X_WE.p.z(), -1e-4, 1e-12);
  const JointVector hold = touching.terms().bias;
  EXPECT_NEAR(touching.step(hold, kNoPush).f_W.z(), 2.0, 0.1);  // 20 kN/m and the damper
}

TEST(ModelErrors, APushIsAForceOrAWholeWrench) {
  World a = iiwa({}), b = iiwa({});
  const JointVector q = working_posture(), v = JointVector::Constant(7, 0.2),
                    tau = JointVector::Constant(7, 1.0);
  Vector6 push;
  push << 3.0, -2.0, 1.0, 0.3, 0.2, -0.1;
  a.set_state(q, v);
  const World::Terms terms = a.terms();
  a.step(tau, push);
  const JointVector expected =
      v + 1e-3 * terms.M.ldlt().solve(tau - terms.bias + terms.J.transpose() * push);
  EXPECT_LT((a.state().v - expected).norm(), 1e-10);

  push.tail<3>().setZero();
  a.set_state(q, v);
  b.set_state(q, v);
  a.step(tau, push);
  b.step(tau, Eigen::Vector3d(push.head<3>()));
  EXPECT_EQ(a.state().v, b.state().v);
}

TEST(ModelErrors, AreRefusedByNameWhenOutOfRange) {
  const auto message = [](const ModelErrors& errors) -> std::string {
    try {
      slider(errors);
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  };
  const double nan = std::nan("");
  EXPECT_THAT(message({.mass_scale = 0.0}), testing::HasSubstr("mass_scale is 0,"));
  EXPECT_THAT(message({.centre_shift = nan}), testing::HasSubstr("centre_shift"));
  EXPECT_THAT(message({.viscous_friction = -1.0}),
              testing::HasSubstr("viscous_friction is -1 Nm s/rad,"));
  EXPECT_THAT(message({.rotor_inertia = {-0.1}}), testing::HasSubstr("rotor_inertia"));
  EXPECT_THAT(message({.torque_ripple = nan}), testing::HasSubstr("torque_ripple"));
  EXPECT_THAT(message({.torque_quantum = -0.1}), testing::HasSubstr("torque_quantum"));
  EXPECT_THAT(message({.loop_delay = 0.017}),
              testing::HasSubstr("loop_delay is 0.017 s, allowed is 0 to 0.015 s"));
  EXPECT_THAT(message({.loop_delay = -0.001}), testing::HasSubstr("loop_delay"));
  EXPECT_THAT(message({.pen_longer = nan}), testing::HasSubstr("pen_longer"));
  EXPECT_EQ(message({.loop_delay = 0.015}), "accepted");
}

}  // namespace
}  // namespace impedraw
