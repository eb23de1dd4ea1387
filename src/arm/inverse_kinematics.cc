#include "impedraw/arm/inverse_kinematics.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "impedraw/control/heading.h"

namespace impedraw {

IkResult find_posture(ArmModel& arm, const PenPlacement& desired, const JointVector& seed,
                      const IkSettings& settings) {
  const int n = arm.joints();
  const JointVector lower = arm.limits().lower, upper = arm.limits().upper;
  ArmTerms terms(n);
  IkResult result;
  result.q = seed.cwiseMax(lower).cwiseMin(upper);
  JointVector q = result.q;
  double best = std::numeric_limits<double>::infinity();

  for (int step = 0; step < settings.max_steps; ++step) {
    arm.place(q, &terms);
    const Eigen::Vector3d z = terms.X_WE.R.col(2);
    const Eigen::Vector3d cross = z.cross(desired.z_WE);
    double angle = std::atan2(cross.norm(), z.dot(desired.z_WE));
    // For exactly opposite axes, any normal of z can be the rotation axis.
    const Eigen::Vector3d axis =
        cross.norm() > 1e-12 ? Eigen::Vector3d(cross.normalized()) : terms.X_WE.R.col(0);
    Vector6 e;
    e << desired.p_WE - terms.X_WE.p, angle * axis;
    if (desired.led()) {
      e.tail<3>() += yaw_between(terms.X_WE.R.col(0), desired.x_WE, z) * z;
      angle = e.tail<3>().norm();
    }
    const double position_error = e.head<3>().norm();
    if (position_error + angle < best) {
      best = position_error + angle;
      result.q = q;
      result.position_error = position_error;
      result.axis_error = angle;
    }
    if (position_error < settings.position_tolerance && angle < settings.axis_tolerance) {
      result.reached = true;
      break;
    }
    TipJacobian J = terms.J;
    const bool free_spin = settings.free_spin && !desired.led();
    if (free_spin) J.bottomRows<3>() -= z * (z.transpose() * terms.J.bottomRows<3>());
    const double damping = 1e-12 + 1e-2 * std::min(1.0, best * best);
    Matrix6 A = J * J.transpose() + damping * Matrix6::Identity();
    // A is singular along z, where e is zero.
    if (free_spin) A.bottomRightCorner<3, 3>() += z * z.transpose();
    const Eigen::LLT<Matrix6> factor(A);
    const JointVector home = settings.posture_gain * (seed - q);
    JointVector dq = J.transpose() * factor.solve(e - J * home) + home;
    dq *= std::min(
        1.0, 0.3 / std::max(dq.cwiseAbs().maxCoeff(), 1e-12));  // at most 0.3 rad for any joint
    q = (q + dq).cwiseMax(lower).cwiseMin(upper);
  }
  return result;
}

}  // namespace impedraw
