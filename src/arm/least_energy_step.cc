#include "impedraw/arm/least_energy_step.h"

#include <Eigen/Cholesky>

#include "impedraw/control/heading.h"
#include "impedraw/control/normal_tracker.h"

namespace impedraw {

LeastEnergyStep least_energy_step(const ArmTerms& arm, const Vector6& dx, const JointVector& pull,
                                  double epsilon) {
  const TipJacobian& J = arm.J;
  const auto M = arm.M.llt();
  const Eigen::MatrixXd M_inv_Jt = M.solve(J.transpose());
  const JointVector drift = M.solve(pull);
  const Matrix6 A = J * M_inv_Jt + epsilon * Matrix6::Identity();
  const Eigen::LLT<Matrix6> factor = A.llt();
  return {M_inv_Jt * factor.solve(dx), drift - M_inv_Jt * factor.solve(J * drift)};
}

Vector6 tip_displacement(const Pose& X_WE, const Eigen::Vector3d& p_W, const Eigen::Vector3d& z_W,
                         const Eigen::Vector3d& x_W) {
  Vector6 dx;
  dx << p_W - X_WE.p, smallest_rotation(X_WE.R.col(2), z_W);
  if (!x_W.isZero()) dx.tail<3>() += yaw_between(X_WE.R.col(0), x_W, z_W) * z_W;
  return dx;
}

}  // namespace impedraw
