#include "impedraw/judge/crisp_law.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/QR>

namespace impedraw {

CrispLaw::CrispLaw(const JointVector& q_0, const CrispGains& gains)
    : gains_(gains), q_0_(q_0), tau_(JointVector::Zero(q_0.size())) {}

const JointVector& CrispLaw::step(const ArmTerms& arm, const TipReference& reference,
                                  double press) noexcept {
  if (!begun_) R_WD_ = arm.X_WE.R;
  R_WD_ = Eigen::Quaterniond::FromTwoVectors(R_WD_.col(2), -reference.n_WD) * R_WD_;
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(R_WD_ * arm.X_WE.R.transpose()));
  const auto clipped = [](const Eigen::Vector3d& x, double most) {
    return Eigen::Vector3d(x.cwiseMax(-most).cwiseMin(most));
  };
  Vector6 F;
  F << gains_.stiffness * clipped(reference.p_WD - arm.X_WE.p, gains_.clip) -
           gains_.damping * arm.V_WE.head<3>() - press * reference.n_WD,
      gains_.rotational_stiffness * clipped(turn.angle() * turn.axis(), gains_.rotational_clip) -
          gains_.rotational_damping * arm.V_WE.tail<3>();
  const JointVector wish =
      gains_.null_stiffness * (q_0_ - arm.q) - 2.0 * std::sqrt(gains_.null_stiffness) * arm.v;
  const Vector6 tip_wish = arm.J * wish;
  const Matrix6 JJt = arm.J * arm.J.transpose();
  const JointVector tau = arm.J.transpose() * F + wish -
                          arm.J.transpose() * JJt.ldlt().solve(tip_wish) + arm.Cv + arm.g;
  if (!begun_) tau_ = tau;
  begun_ = true;
  tau_ += (tau - tau_).cwiseMax(-gains_.max_delta_tau).cwiseMin(gains_.max_delta_tau);
  return tau_;
}

}  // namespace impedraw
