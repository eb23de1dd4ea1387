// The second example's arm against differences of its own pose and energy: what people copy from
// must be right.
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "02_own_simulator/gantry.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

const Gantry kGantry;

ArmTerms at(const JointVector& q, const JointVector& v) {
  ArmTerms terms(6);
  kGantry.compute(q, v, &terms);
  return terms;
}

// By quaternions: the wrist's orientation without the axes that the gantry uses.
Pose pose(const JointVector& q) {
  const Eigen::Quaterniond turn = Eigen::AngleAxisd(q[3], Vector3d::UnitX()) *
                                  Eigen::AngleAxisd(q[4], Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(q[5], Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX());
  return {q.head<3>() + kGantry.tip * (turn * Vector3d::UnitZ()), turn.toRotationMatrix()};
}
Vector3d pen_centre(const JointVector& q) {
  return q.head<3>() + kGantry.pen_centre * pose(q).R.col(2);
}

Vector3d turn_rate(const Eigen::Matrix3d& before, const Eigen::Matrix3d& after, double time) {
  const Eigen::AngleAxisd turned(after * before.transpose());
  return turned.angle() / time * turned.axis();
}

// Of rails, pen and wrist, from differences of where they are.
double kinetic_energy(const JointVector& q, const JointVector& v) {
  const double h = 1e-5;
  const JointVector before = q - 0.5 * h * v, after = q + 0.5 * h * v;
  const Vector3d rails = v.head<3>(), pen = (pen_centre(after) - pen_centre(before)) / h;
  return 0.5 *
         (rails.dot(kGantry.rail_mass.cwiseProduct(rails)) + kGantry.pen_mass * pen.squaredNorm() +
          kGantry.wrist_inertia * turn_rate(pose(before).R, pose(after).R, h).squaredNorm());
}
double potential_energy(const JointVector& q) {
  return -kGantry.gravity_W.dot(kGantry.rail_mass.z() * Vector3d(0.0, 0.0, q[2]) +
                                kGantry.pen_mass * pen_centre(q));
}

TEST(Gantry, ItsTermsAreThoseOfItsEnergyAndPose) {
  const unsigned seed = 20250101;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const double h = 1e-5;
  for (int sample = 0; sample < 50; ++sample) {
    JointVector q(6), v(6);
    for (int j = 0; j < 6; ++j) {
      q[j] = unit(rng);
      v[j] = unit(rng);
    }
    const ArmTerms arm = at(q, v);
    const JointVector before = q - 0.5 * h * v, after = q + 0.5 * h * v;
    EXPECT_LT((arm.X_WE.p - pose(q).p).norm() + (arm.X_WE.R - pose(q).R).norm(), 1e-12);
    EXPECT_LT((arm.V_WE.head<3>() - (pose(after).p - pose(before).p) / h).norm(), 1e-8);
    EXPECT_LT((arm.V_WE.tail<3>() - turn_rate(pose(before).R, pose(after).R, h)).norm(), 1e-8);
    EXPECT_LT((arm.J * v - arm.V_WE).norm(), 1e-12);
    EXPECT_LT((arm.Jdot_v - (at(after, v).J - at(before, v).J) * v / h).norm(), 1e-8);
    EXPECT_NEAR(0.5 * v.dot(arm.M * v), kinetic_energy(q, v), 1e-7);
    // Lagrange: C v = Ṁ v − ∂T/∂q, g = ∂U/∂q
    JointVector Cv = (at(after, v).M - at(before, v).M) * v / h, g(6);
    for (int j = 0; j < 6; ++j) {
      const JointVector step = 0.5 * h * JointVector::Unit(6, j);
      Cv[j] -= 0.5 * v.dot((at(q + step, v).M - at(q - step, v).M) * v) / h;
      g[j] = (potential_energy(q + step) - potential_energy(q - step)) / h;
    }
    EXPECT_LT((arm.Cv - Cv).norm(), 1e-8);
    EXPECT_LT((arm.g - g).norm(), 1e-7);
  }
}

}  // namespace
}  // namespace impedraw
