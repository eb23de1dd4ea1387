#include "dense_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace impedraw::testing_arm {

Eigen::MatrixXd inverse(const Eigen::MatrixXd& A) { return A.inverse(); }

Eigen::VectorXd solve(const Eigen::MatrixXd& M, const Eigen::VectorXd& b) {
  return M.llt().solve(b);
}

Eigen::MatrixXd operational_inertia(const Eigen::MatrixXd& J, const Eigen::MatrixXd& M) {
  return inverse(J * inverse(M) * J.transpose());
}

Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& A) { return A.eigenvalues(); }

Modes modes(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(K, M);
  return {solver.eigenvectors(), solver.eigenvalues()};
}

}  // namespace impedraw::testing_arm
