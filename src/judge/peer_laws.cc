#include "impedraw/judge/peer_laws.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/QR>

#include "impedraw/control/normal_tracker.h"

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

FeedforwardLaw::FeedforwardLaw(const JointVector& q_0, const FeedforwardGains& gains)
    : gains_(gains), q_0_(q_0), tau_(JointVector::Zero(q_0.size())) {}

const JointVector& FeedforwardLaw::step(const ArmTerms& arm, const TipReference& reference,
                                        double press) noexcept {
  space_.update(arm);
  const Eigen::Matrix3d K_linear = gains_.stiffness * Eigen::Matrix3d::Identity(),
                        K_angular = gains_.rotational_stiffness * Eigen::Matrix3d::Identity();
  damping_.design(space_.inverse_inertia_factor(), K_linear, K_angular, gains_.damping_ratio);
  Vector6 V_d, Vdot_d, Ke;
  V_d << reference.v_WD, reference.w_WD;
  Vdot_d << reference.a_WD, reference.alpha_WD;
  Ke << gains_.stiffness * (reference.p_WD - arm.X_WE.p),
      gains_.rotational_stiffness *
          smallest_rotation(arm.X_WE.R.col(2), Eigen::Vector3d(-reference.n_WD));
  Vector6 F = space_.inertia() * (Vdot_d - arm.Jdot_v) + space_.project_to_tip(arm.Cv) +
              damping_.apply(space_.inertia_factor(), V_d - arm.V_WE) + Ke;
  F.head<3>() -= press * reference.n_WD;
  const JointVector D_null =
      1.4 * (gains_.null_stiffness * arm.M.diagonal()).cwiseSqrt();  // ζ = 0.7
  const JointVector wish = gains_.null_stiffness * (q_0_ - arm.q) - D_null.cwiseProduct(arm.v);
  tau_ = arm.J.transpose() * (F - space_.project_to_tip(wish)) + wish + arm.g;
  return tau_;
}

}  // namespace impedraw
