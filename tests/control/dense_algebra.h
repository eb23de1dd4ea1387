// Decompositions of small dense matrices, compiled once: in each test they would take most of its
// compile time.
#pragma once

#include <Eigen/Core>

namespace impedraw::testing_arm {

Eigen::MatrixXd inverse(const Eigen::MatrixXd& A);
// M⁻¹ b; M symmetric positive definite.
Eigen::VectorXd solve(const Eigen::MatrixXd& M, const Eigen::VectorXd& b);
// The textbook's (J M⁻¹ Jᵀ)⁻¹, with full inverses.
Eigen::MatrixXd operational_inertia(const Eigen::MatrixXd& J, const Eigen::MatrixXd& M);
Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& A);

// K q = ω² M q with Qᵀ M Q = 1; K and M symmetric, M positive definite.
struct Modes {
  Eigen::MatrixXd Q;
  Eigen::VectorXd omega_squared;
};
Modes modes(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M);

}  // namespace impedraw::testing_arm
