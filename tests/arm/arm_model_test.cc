// Every term of the law against a second implementation (MuJoCo's, from the same URDF) and against
// finite differences.
#include "impedraw/arm/arm_model.h"

#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "iiwa_variants.h"
#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/common/errors.h"
#include "impedraw/simulation/world.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

const char* const kArm = "models/iiwa14_pen.urdf";
constexpr int kStates = 200;

struct RandomState {
  JointVector q, v;
};

RandomState random_state(std::mt19937& rng, const ArmLimits& limits) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const int n = static_cast<int>(limits.lower.size());
  RandomState s{JointVector(n), JointVector(n)};
  for (int i = 0; i < n; ++i) {
    s.q[i] = 0.5 * (limits.lower[i] + limits.upper[i]) +
             0.5 * unit(rng) * (limits.upper[i] - limits.lower[i]);
    s.v[i] = unit(rng) * limits.speed[i];
  }
  return s;
}

TEST(ArmModel, AgreesWithMujocoOnEveryTerm) {
  ArmModel arm(kArm);
  World world(kArm, nullptr, {});
  WorldSettings no_gravity;
  no_gravity.gravity = 0.0;
  World weightless(kArm, nullptr, no_gravity);
  ArmTerms terms(7);
  const unsigned seed = 20261121;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  for (int i = 0; i < kStates; ++i) {
    const RandomState s = random_state(rng, arm.limits());
    arm.compute(s.q, s.v, &terms);
    world.set_state(s.q, s.v);
    weightless.set_state(s.q, s.v);
    const World::Terms other = world.terms();
    EXPECT_LT((terms.M - other.M).norm(), 1e-9 * other.M.norm());
    EXPECT_EQ((terms.M - terms.M.transpose()).norm(), 0.0);
    EXPECT_LT((terms.Cv + terms.g - other.bias).norm(), 1e-8 * (1.0 + other.bias.norm()));
    EXPECT_LT((terms.Cv - weightless.terms().bias).norm(), 1e-8 * (1.0 + terms.Cv.norm()));
    EXPECT_LT((terms.J - other.J).norm(), 1e-9 * other.J.norm());
    EXPECT_LT((terms.X_WE.p - world.state().X_WE.p).norm(), 1e-10);
    EXPECT_LT((terms.X_WE.R - world.state().X_WE.R).norm(), 1e-9);
    EXPECT_LT((terms.V_WE - world.state().V_WE).norm(), 1e-9 * (1.0 + terms.V_WE.norm()));
    EXPECT_LT((terms.V_WE - terms.J * s.v).norm(), 1e-12 * (1.0 + terms.V_WE.norm()));
  }
}

// Bit by bit: what is planned does not depend on which of the two was asked.
TEST(ArmModel, PlacesTheTipAsWithAllTerms) {
  ArmModel arm(kArm);
  ArmTerms all(7), placed(7);
  std::mt19937 rng(11);
  for (int i = 0; i < kStates; ++i) {
    const RandomState s = random_state(rng, arm.limits());
    arm.compute(s.q, s.v, &all);
    arm.place(s.q, &placed);
    EXPECT_EQ(placed.q, all.q);
    EXPECT_EQ(placed.X_WE.p, all.X_WE.p);
    EXPECT_EQ(placed.X_WE.R, all.X_WE.R);
    EXPECT_EQ(placed.J, all.J);
  }
}

TEST(ArmModel, DriftIsTheDerivativeOfTheJacobian) {
  ArmModel arm(kArm);
  ArmTerms now(7), before(7), after(7);
  const unsigned seed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  const double h = 1e-6;
  for (int i = 0; i < kStates; ++i) {
    const RandomState s = random_state(rng, arm.limits());
    arm.compute(s.q, s.v, &now);
    arm.compute(s.q - h * s.v, s.v, &before);
    arm.compute(s.q + h * s.v, s.v, &after);
    const Vector6 expected = (after.J - before.J) / (2.0 * h) * s.v;
    EXPECT_LT((now.Jdot_v - expected).norm(), 1e-6 * (1.0 + expected.norm()));
  }
}

TEST(ArmModel, GravityIsTheGradientOfPotentialEnergy) {
  // By virtual work on the tip's own mass it would not show; so by holding still in the simulator:
  // τ = g does not move.
  ArmModel arm(kArm);
  World world(kArm, nullptr, {});
  ArmTerms terms(7);
  std::mt19937 rng(3);
  for (int i = 0; i < 20; ++i) {
    const RandomState s = random_state(rng, arm.limits());
    const JointVector rest = JointVector::Zero(7);
    world.set_state(s.q, rest);
    arm.compute(s.q, rest, &terms);
    for (int k = 0; k < 100; ++k) world.step(terms.g, Eigen::Vector3d::Zero());
    EXPECT_LT((world.state().q - s.q).norm(), 1e-9);
  }
}

TEST(ArmModel, BodiesCoverTheLinks) {
  ArmModel arm(kArm);
  const auto capsules = arm.body_capsules(JointVector::Zero(7));
  EXPECT_EQ(capsules.size(), 17u);
  // At q = 0 the arm stands upright: every capsule lies on the z axis, the pen ends at 1.306 + 0.12
  // m less the cylinder's 0.01 m.
  double top = 0.0;
  for (const auto& c : capsules) {
    EXPECT_LT(c.a_W.head<2>().norm(), 1e-9) << c.link;
    EXPECT_LT(c.b_W.head<2>().norm(), 1e-9) << c.link;
    top = std::max({top, c.a_W.z(), c.b_W.z()});
  }
  EXPECT_NEAR(top, 0.36 + 0.42 + 0.40 + 0.126 + 0.11, 1e-9);
}

TEST(InverseKinematics, ReachesWhatForwardKinematicsMade) {
  ArmModel arm(kArm);
  JointVector seed_posture(7);
  seed_posture << 0.0, 0.6, 0.0, -1.4, 0.0, 1.1, 0.0;
  const unsigned seed = 11;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d p(0.6 + 0.1 * unit(rng), 0.1 * unit(rng), 0.15 + 0.05 * unit(rng));
    const Eigen::Vector3d z = Eigen::Vector3d(0.3 * unit(rng), 0.3 * unit(rng), -1.0).normalized();
    const IkResult result = find_posture(arm, {p, z}, seed_posture);
    ASSERT_TRUE(result.reached) << "at " << p.transpose() << ": off by " << result.position_error
                                << " m, " << result.axis_error << " rad";
    const Pose X_WE = arm.tip_pose(result.q);
    EXPECT_LT((X_WE.p - p).norm(), 1e-6);
    EXPECT_LT((X_WE.R.col(2) - z).norm(), 1e-6);
    EXPECT_TRUE(((result.q.array() >= arm.limits().lower.array()) &&
                 (result.q.array() <= arm.limits().upper.array()))
                    .all());
  }
  EXPECT_FALSE(
      find_posture(arm, {Eigen::Vector3d(2.0, 0.0, 0.2), -Eigen::Vector3d::UnitZ()}, seed_posture)
          .reached);
}

// An axis that goes round a cone of half-angle a, and is carried without spin, comes back with its
// frame turned by the solid angle 2π (1 − cos a), by the theorem of Gauss and Bonnet.
TEST(InverseKinematics, CarriesThePenWithoutSpin) {
  ArmModel arm(kArm);
  IkSettings ik;
  const Eigen::Vector3d p(0.6, 0.0, 0.2);
  constexpr int kSteps = 200;
  for (const double a : {0.2, 0.5}) {
    for (const bool free_spin : {false, true}) {
      ik.free_spin = true;
      const auto axis = [&](int i) {
        const double b = 2.0 * std::numbers::pi * i / kSteps;
        return Eigen::Vector3d(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), -std::cos(a));
      };
      JointVector q(7);
      q << 0.0, 0.6, 0.0, -1.4, 0.0, 1.1, 0.0;
      q = find_posture(arm, {p, axis(0)}, q, ik).q;
      const Eigen::Matrix3d before = arm.tip_pose(q).R;
      ik.free_spin = free_spin;
      for (int i = 1; i <= kSteps; ++i) {
        const IkResult found = find_posture(arm, {p, axis(i)}, q, ik);
        ASSERT_TRUE(found.reached) << a << " rad, step " << i;
        q = found.q;
      }
      const Eigen::AngleAxisd turned(before.transpose() * arm.tip_pose(q).R);
      const double solid = 2.0 * std::numbers::pi * (1.0 - std::cos(a));
      if (free_spin)
        EXPECT_GT(std::abs(turned.angle() - solid), 0.05) << "the least motion of the joints spins";
      else
        EXPECT_NEAR(turned.angle(), solid, 0.01);
    }
  }
}

TEST(ArmModel, RefusesWhatItCannotRead) {
  EXPECT_THROW(ArmModel("models/none.urdf"), InputError);
  EXPECT_THROW(ArmModel("README.md"), InputError);
  EXPECT_THROW(ArmModel(kArm, "no_such_frame"), InputError);
}

// <dynamics> of a description: b v in Cv alone.
class ArmDamping : public ScratchFolder {};

TEST_F(ArmDamping, StandsInCvWhereItIsExpected) {
  const auto file = write("friction.urdf", changed(iiwa_urdf(), "<joint name=\"joint_2\"", "<axis",
                                                   "<dynamics damping=\"10\" friction=\"1.5\"/>"
                                                   "<axis"));
  ArmModel bare(kArm), unaware(file), arm(file);
  arm.expect_damping();
  ArmTerms without(7), still(7), with(7);
  JointVector q = JointVector::Constant(7, 0.3), v = JointVector::Constant(7, 0.1);
  for (const double speed : {-1.0, -0.3, 0.0, 0.3, 1.0}) {
    v[1] = speed;
    bare.compute(q, v, &without);
    unaware.compute(q, v, &still);
    arm.compute(q, v, &with);
    EXPECT_LT((still.Cv - without.Cv).norm(), 1e-12);
    JointVector added = with.Cv - without.Cv;
    EXPECT_NEAR(added[1], 10.0 * speed, 1e-12);
    added[1] = 0.0;
    EXPECT_LT(added.norm(), 1e-12);
    EXPECT_EQ(with.g, without.g);
    EXPECT_EQ(with.M, without.M);
  }
}

// MuJoCo's M with the same rotors, the kinetic energy of links and rotors, and C v and g without.
TEST(ArmModel, RotorsStandOnTheDiagonalOfM) {
  const std::vector<double> rotors = {0.3, 0.25, 0.2, 0.15, 0.1, 0.05, 0.02};
  ArmModel bare(kArm), arm(kArm);
  arm.set_rotor_inertia(rotors);
  WorldSettings settings;
  settings.errors.rotor_inertia = rotors;
  World world(kArm, nullptr, settings);
  ArmTerms without(7), with(7);
  const unsigned seed = 42;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  for (int i = 0; i < kStates; ++i) {
    const RandomState s = random_state(rng, arm.limits());
    bare.compute(s.q, s.v, &without);
    arm.compute(s.q, s.v, &with);
    world.set_state(s.q, s.v);
    EXPECT_LT((with.M - world.terms().M).norm(), 1e-9 * with.M.norm());
    double energy = 0.5 * s.v.dot(without.M * s.v);
    for (int j = 0; j < 7; ++j)
      energy += 0.5 * rotors[static_cast<std::size_t>(j)] * s.v[j] * s.v[j];
    EXPECT_NEAR(0.5 * s.v.dot(with.M * s.v), energy, 1e-9 * energy);
    EXPECT_EQ((with.Cv - without.Cv).norm() + (with.g - without.g).norm(), 0.0);
    EXPECT_EQ((with.M - with.M.transpose()).norm(), 0.0);
  }
  arm.set_rotor_inertia({0.1});
  EXPECT_EQ(arm.rotor_inertia(), Eigen::VectorXd::Constant(7, 0.1));
  EXPECT_THROW(arm.set_rotor_inertia({0.1, 0.1}), InputError);
  EXPECT_THROW(arm.set_rotor_inertia({-0.1}), InputError);
}

}  // namespace
}  // namespace impedraw
