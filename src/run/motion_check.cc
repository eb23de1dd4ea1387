#include "impedraw/run/motion_check.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Cholesky>

namespace impedraw {

namespace {

constexpr double kFastest = 3.0, kJump = 0.01;  // of v_max; [rad]
constexpr double kSmooth = 4e-3;                // [s]
constexpr double kConfirms = 1.5;  // of the speed that positions have: they are late, too

std::string jumps(const MotionReading& now, const MotionLimits& limits) {
  Eigen::Index j = 0;
  const auto most = kFastest * now.dt * limits.speed.array() + kJump;
  if ((now.moved.array().abs() / most).maxCoeff(&j) <= 1.0) return {};
  return fmt::format(
      "the position of joint {} jumped by {:.3f} rad within {:.3f} ms, which no motion explains",
      j + 1, now.moved[j], 1e3 * now.dt);
}

std::string races(const MotionReading& now, const MotionLimits& limits,
                  const JointVector& by_positions) {
  if (!now.v) return {};
  Eigen::Index j = 0;
  (now.v->array().abs() / limits.speed.array()).maxCoeff(&j);
  const double v = (*now.v)[j];
  if (std::abs(v) <= kFastest * limits.speed[j] ||
      std::max(v * now.moved[j] / now.dt, v * by_positions[j]) >= v * v / 3.0)
    return {};
  return fmt::format("joint {} turns at {:.2f} rad/s, which its positions contradict", j + 1, v);
}

}  // namespace

MotionCheck::MotionCheck(const JointVector& speed_limit, const JointVector& torque_limit)
    : limits_{speed_limit, torque_limit},
      q_(JointVector::Zero(speed_limit.size())),
      v_(q_),
      by_positions_(q_),
      speeds_(static_cast<int>(q_.size())),
      stand_(static_cast<int>(q_.size())),
      torques_(static_cast<int>(q_.size())) {}

bool MotionCheck::update(const JointVector& q, const JointVector* v, const JointVector& torque,
                         const JointVector& external, double dt, const JointMatrix* M) noexcept {
  if (!q.allFinite() || (v && !v->allFinite())) return false;
  if (begun_ && !(dt > 0.0)) return false;
  const MotionReading now{q, q - q_, v, v ? &v_ : nullptr, torque, external, M, dt};
  const bool judged = begun_ && cause_.empty();
  if (begun_) by_positions_ += dt / (kSmooth + dt) * (now.moved / dt - by_positions_);
  if (judged) cause_ = jumps(now, limits_);
  if (judged && cause_.empty()) cause_ = races(now, limits_, by_positions_);
  if (judged && cause_.empty()) cause_ = speeds_.update(now, limits_);
  if (judged && cause_.empty()) cause_ = stand_.update(now, limits_);
  if (judged && cause_.empty()) cause_ = torques_.update(now, limits_);
  q_ = q;
  if (v) v_ = *v;
  if (!begun_ && v) by_positions_ = *v;
  begun_ = true;
  return judged && !cause_.empty();
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
