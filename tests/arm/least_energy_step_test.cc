// The motion of least energy against its own definition: the tip goes where it is told, no other
// motion of the joints that moves it there costs less, and the redundant joints run down a
// potential.
#include "impedraw/arm/least_energy_step.h"

#include <random>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

constexpr double kEpsilon = 1e-9;

JointVector random_posture(std::mt19937& rng, const ArmLimits& limits) {
  std::uniform_real_distribution<double> unit(-0.8, 0.8);
  JointVector q = 0.5 * (limits.lower + limits.upper);
  for (int i = 0; i < q.size(); ++i) q[i] += 0.5 * unit(rng) * (limits.upper[i] - limits.lower[i]);
  return q;
}

class LeastEnergy : public testing::Test {
 protected:
  ArmModel arm_{"models/iiwa14_pen.urdf"};
  ArmTerms terms_{7};
  std::mt19937 rng_{20261123};

  void compute(const JointVector& q) { arm_.compute(q, JointVector::Zero(7), &terms_); }
};

TEST_F(LeastEnergy, MovesTheTipByTheCheapestWay) {
  std::normal_distribution<double> normal(0.0, 0.01);
  for (int i = 0; i < 100; ++i) {
    compute(random_posture(rng_, arm_.limits()));
    Vector6 dx;
    for (int k = 0; k < 6; ++k) dx[k] = normal(rng_);
    const JointVector task = least_energy_step(terms_, dx, JointVector::Zero(7), kEpsilon).task;
    EXPECT_LT((terms_.J * task - dx).norm(), 1e-5) << "posture " << i;
    // Every other way differs by a motion that leaves the tip at rest: it is orthogonal in M.
    const Eigen::FullPivLU<Eigen::MatrixXd> lu(terms_.J);
    const JointVector still = lu.kernel().col(0);
    EXPECT_LT(std::abs(still.dot(terms_.M * task)), 1e-5 * still.norm()) << "posture " << i;
  }
}

TEST_F(LeastEnergy, LetsTheRedundantJointsRunDownAPotential) {
  for (int i = 0; i < 20; ++i) {
    const JointVector rest = random_posture(rng_, arm_.limits());
    compute(rest);
    const JointVector weight = relaxation_weight(terms_);
    JointVector q = random_posture(rng_, arm_.limits());
    double before = (rest - q).dot(weight.cwiseProduct(rest - q));
    for (int step = 0; step < 400; ++step) {
      compute(q);
      const JointVector pull = weight.cwiseProduct(rest - q);
      const JointVector redundant =
          least_energy_step(terms_, Vector6::Zero(), 0.01 * pull, kEpsilon).redundant;
      EXPECT_LT((terms_.J * redundant).norm(), 1e-6);
      q += redundant;
      const double after = (rest - q).dot(weight.cwiseProduct(rest - q));
      ASSERT_LE(after, before + 1e-9) << "posture " << i << ", step " << step;
      before = after;
    }
  }
}

}  // namespace
}  // namespace impedraw
