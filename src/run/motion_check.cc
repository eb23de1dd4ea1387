#include "impedraw/run/motion_check.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Cholesky>

namespace impedraw {

namespace {

constexpr double kFastest = 3.0, kJump = 0.01;                            // of v_max; [rad]
constexpr double kApart = 0.02, kLag = 0.03, kUsual = 5e-3, kForget = 1;  // [rad], [s]
constexpr double kUnmoved = 0.15, kStill = 1e-4, kAsked = 0.1;            // [s], [rad], share
constexpr double kSmooth = 4e-3;                                          // [s]
constexpr double kConfirms = 1.5;  // of the speed that positions have: they are late, too

}  // namespace

MotionCheck::MotionCheck(const JointVector& speed_limit, const JointVector& torque_limit)
    : speed_limit_(speed_limit),
      torque_limit_(torque_limit),
      q_(JointVector::Zero(speed_limit.size())),
      v_(q_),
      moved_(q_),
      apart_(q_),
      by_positions_(q_),
      place_(q_) {}

bool MotionCheck::update(const JointVector& q, const JointVector* v, const JointVector& torque,
                         const JointVector& external, double dt) noexcept {
  if (!q.allFinite() || (v && !v->allFinite())) return false;
  if (!begun_) {
    begun_ = true;
    q_ = place_ = q;
    if (v) v_ = by_positions_ = *v;
    return false;
  }
  if (!(dt > 0.0)) return false;
  moved_ = q - q_;
  q_ = q;
  by_positions_ += dt / (kSmooth + dt) * (moved_ / dt - by_positions_);
  if (v) {
    apart_ = std::exp(-dt / kForget) * (apart_ + moved_ - 0.5 * dt * (*v + v_));
    v_ = *v;
  }
  if ((q - place_).cwiseAbs().maxCoeff() > kStill) {
    place_ = q;
    unmoved_ = 0.0;
  }
  const double share =
      ((torque.cwiseAbs() - external.cwiseAbs()).array() / torque_limit_.array()).maxCoeff();
  if (std::isfinite(share)) {
    share_ = share;
    unmoved_ = std::max(0.0, unmoved_ + (share - kAsked) * dt);
  }
  if (!cause_.empty()) return false;
  cause_ = contradiction(dt);
  return !cause_.empty();
}

std::string MotionCheck::contradiction(double dt) const {
  Eigen::Index j = 0;
  const auto limit = speed_limit_.array();
  if ((moved_.array().abs() / (kFastest * dt * limit + kJump)).maxCoeff(&j) > 1.0)
    return fmt::format(
        "the position of joint {} jumped by {:.3f} rad within {:.3f} ms, which no motion explains",
        j + 1, moved_[j], 1e3 * dt);
  (v_.array().abs() / limit).maxCoeff(&j);
  if (std::abs(v_[j]) > kFastest * limit[j] &&
      std::max(v_[j] * moved_[j] / dt, v_[j] * by_positions_[j]) < v_[j] * v_[j] / 3.0)
    return fmt::format("joint {} turns at {:.2f} rad/s, which its positions contradict", j + 1,
                       v_[j]);
  const double late = kLag + std::max(0.0, dt - kUsual);
  if ((apart_.array().abs() / (kApart + late * limit)).maxCoeff(&j) > 1.0)
    return fmt::format(
        "the positions of joint {} contradict its speed: they are {:.3f} rad away from where it "
        "led, and it is {:.2f} rad/s",
        j + 1, apart_[j], v_[j]);
  if (unmoved_ > kUnmoved)
    return fmt::format(
        "the arm does not move, although {:.0f} % of a joint's largest torque ask it to: brakes, a "
        "wall, or positions that stand still",
        1e2 * share_);
  return {};
}

JointVector MotionCheck::confirmed(const JointVector& v) const noexcept {
  JointVector slow = v;
  for (Eigen::Index j = 0; j < slow.size(); ++j) {
    const double most = kConfirms * by_positions_[j];
    slow[j] =
        v[j] * most > 0.0 ? std::copysign(std::min(std::abs(v[j]), std::abs(most)), v[j]) : 0.0;
  }
  return slow;
}

JointVector joint_damping(const JointMatrix& M, double T) {
  const JointMatrix inverse = M.ldlt().solve(JointMatrix::Identity(M.rows(), M.cols()));
  return (T * inverse.diagonal().array()).inverse().matrix();
}

}  // namespace impedraw
