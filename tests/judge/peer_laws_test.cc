// The peers' laws against their formulas, written out with dense matrices.
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "impedraw/arm/arm_model.h"
#include "impedraw/judge/force_trial.h"

namespace impedraw {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct Situation {
  ArmTerms terms{7};
  TipReference reference;
  JointVector q_0 = JointVector::Zero(7);
};

Situation situation(ArmModel& arm, std::mt19937& bits) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto vector = [&] { return Vector3d(unit(bits), unit(bits), unit(bits)); };
  Situation s;
  JointVector q(7), v(7);
  q << 0.1, 0.6, -0.1, -1.4, 0.2, 1.1, 0.3;
  for (int j = 0; j < 7; ++j) {
    q[j] += 0.3 * unit(bits);
    v[j] = 0.2 * unit(bits);
    s.q_0[j] = q[j] + 0.2 * unit(bits);
  }
  arm.compute(q, v, &s.terms);
  s.reference.p_WD = s.terms.X_WE.p + 0.15 * vector();
  s.reference.v_WD = 0.1 * vector();
  s.reference.a_WD = vector();
  s.reference.n_WD = (-s.terms.X_WE.R.col(2) + 0.3 * vector()).normalized();
  s.reference.w_WD = s.reference.n_WD.cross(vector());
  return s;
}

TEST(PeerLaws, CrispAsItsPaperSays) {
  ArmModel arm("models/iiwa14_pen.urdf");
  std::mt19937 bits(43);
  for (int i = 0; i < 20; ++i) {
    const Situation s = situation(arm, bits);
    const MatrixXd J = s.terms.J;
    // The target's turn about the pen is the tip's: the rotation between both axes alone.
    const Vector3d z = s.terms.X_WE.R.col(2), n = -s.reference.n_WD;
    const Vector3d phi = z.cross(n).normalized() * std::acos(std::min(1.0, z.dot(n)));
    VectorXd e(6), V = J * s.terms.v, F(6);
    e << (s.reference.p_WD - s.terms.X_WE.p).cwiseMax(-0.1).cwiseMin(0.1),
        phi.cwiseMax(-0.5).cwiseMin(0.5);
    for (int k = 0; k < 6; ++k) F[k] = (k < 3 ? 600.0 : 30.0) * e[k] - (k < 3 ? 60.0 : 10.0) * V[k];
    F.head<3>() -= 4.0 * s.reference.n_WD;
    const MatrixXd pinv = J.completeOrthogonalDecomposition().pseudoInverse();
    const VectorXd null = 5.0 * (s.q_0 - s.terms.q) - 2.0 * std::sqrt(5.0) * s.terms.v;
    const VectorXd tau =
        J.transpose() * F + (MatrixXd::Identity(7, 7) - pinv * J) * null + s.terms.Cv + s.terms.g;
    CrispLaw law(s.q_0);
    EXPECT_LT((law.step(s.terms, s.reference, 4.0) - tau).norm(), 1e-8 * tau.norm());
    // No joint's torque changes by more than 0.5 Nm a step.
    const VectorXd next = law.step(s.terms, s.reference, 40.0);
    EXPECT_NEAR((next - tau).cwiseAbs().maxCoeff(), 0.5, 1e-9);
  }
}

// B by its definition: with K Q = Λ Q diag(k), Qᵀ Λ Q = I, B = Λ Q diag(2 ζ √k) Qᵀ Λ.
TEST(PeerLaws, ImpedanceWithFeedForwardAsHoganSays) {
  ArmModel arm("models/iiwa14_pen.urdf");
  std::mt19937 bits(44);
  for (int i = 0; i < 20; ++i) {
    const Situation s = situation(arm, bits);
    const MatrixXd J = s.terms.J, M = s.terms.M, M_inverse = M.inverse();
    const MatrixXd Lambda = (J * M_inverse * J.transpose()).inverse();
    const MatrixXd J_bar = M_inverse * J.transpose() * Lambda;
    VectorXd k(6), e(6), V_d(6), a_d(6);
    k << 2000, 2000, 2000, 200, 200, 200;
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(MatrixXd(k.asDiagonal()),
                                                                   Lambda);
    const MatrixXd Q = modes.eigenvectors();
    const MatrixXd B =
        Lambda * Q * (1.4 * modes.eigenvalues().cwiseSqrt()).asDiagonal() * Q.transpose() * Lambda;
    const Vector3d z = s.terms.X_WE.R.col(2), n = -s.reference.n_WD;
    e << s.reference.p_WD - s.terms.X_WE.p, z.cross(n).normalized() * std::acos(z.dot(n));
    V_d << s.reference.v_WD, s.reference.w_WD;
    a_d << s.reference.a_WD, s.reference.alpha_WD;
    VectorXd F = Lambda * (a_d - VectorXd(s.terms.Jdot_v)) + J_bar.transpose() * s.terms.Cv +
                 B * (V_d - J * s.terms.v) + k.cwiseProduct(e);
    F.head<3>() -= 4.0 * s.reference.n_WD;
    const VectorXd null = 10.0 * (s.q_0 - s.terms.q) -
                          1.4 * (10.0 * M.diagonal()).cwiseSqrt().cwiseProduct(s.terms.v);
    const VectorXd tau = J.transpose() * F +
                         (MatrixXd::Identity(7, 7) - J.transpose() * J_bar.transpose()) * null +
                         s.terms.g;
    FeedforwardLaw law(s.q_0);
    EXPECT_LT((law.step(s.terms, s.reference, 4.0) - tau).norm(), 2e-3 * tau.norm());
  }
}

}  // namespace
}  // namespace impedraw
