#include "impedraw/run/motion_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <Eigen/Cholesky>

namespace impedraw {

namespace {

constexpr double kFastest = 3.0, kJump = 0.01;                               // of v_max; [rad]
constexpr double kApart = 8e-3, kLag = 0.03, kUsual = 5e-3, kForget = 1;     // [rad], [s]
constexpr double kUnmoved = 0.15, kStill = 1e-4, kAsked = 0.1;               // [s], [rad], share
constexpr double kHeld = 0.02, kSame = 8e-3, kFrozen = 1e-4;                 // [s], [s], [rad]
constexpr double kSameReadings = 3, kFriction = 0.02, kLeastFriction = 1.5;  // share, [Nm]
constexpr double kBeside = 0.05, kMostBeside = 1e-3;                         // [s], [rad]
constexpr double kSmooth = 4e-3;                                             // [s]
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
      fastest_(q_),
      torque_(q_),
      external_(q_),
      grain_(JointVector::Constant(speed_limit.size(), std::numeric_limits<double>::infinity())),
      still_(q_),
      steady_(q_),
      still_readings_(q_),
      steady_readings_(q_),
      beside_(q_),
      held_(JointVector::Constant(speed_limit.size(), -1.0)),
      stopped_(q_),
      place_(q_) {
  speeds_.fill(q_);
}

bool MotionCheck::update(const JointVector& q, const JointVector* v, const JointVector& torque,
                         const JointVector& external, double dt, const JointMatrix* M) noexcept {
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
  update_still(v, torque, external, dt, M);
  by_positions_ += dt / (kSmooth + dt) * (moved_ / dt - by_positions_);
  if (v) {
    const double kept = std::exp(-dt / kForget);
    apart_ = kept * (apart_ + moved_ - 0.5 * dt * (*v + v_));
    fastest_ = (kept * fastest_).cwiseMax(v->cwiseAbs()).cwiseMin(speed_limit_);
    v_ = *v;
  }
  if ((q - place_).cwiseAbs().maxCoeff() > kStill) {
    place_ = q;
    unmoved_ = 0.0;
  }
  const JointVector shares = (torque.cwiseAbs() - external.cwiseAbs()).cwiseQuotient(torque_limit_);
  if (shares.allFinite()) {
    share_ = shares.maxCoeff();
    unmoved_ = std::max(0.0, unmoved_ + (share_ - kAsked) * dt);
    for (Eigen::Index j = 0; j < held_.size(); ++j)
      if (moved_[j] != 0.0)
        held_[j] = 0.0;
      else if (held_[j] >= 0.0)
        held_[j] = std::max(0.0, held_[j] + (shares[j] - kAsked) * dt);
  }
  if (!cause_.empty()) return false;
  cause_ = contradiction(dt);
  return !cause_.empty();
}

void MotionCheck::update_still(const JointVector* v, const JointVector& torque,
                               const JointVector& external, double dt,
                               const JointMatrix* M) noexcept {
  JointVector stops = JointVector::Zero(q_.size());
  for (Eigen::Index j = 0; j < q_.size(); ++j) {
    const bool steady = v && (*v)[j] == v_[j];
    steady_[j] = steady ? steady_[j] + dt : 0.0;
    steady_readings_[j] = steady ? steady_readings_[j] + 1.0 : 0.0;
    beside_[j] = steady ? std::exp(-dt / kBeside) * (beside_[j] + moved_[j] - v_[j] * dt) : 0.0;
    if (moved_[j] != 0.0) {
      grain_[j] = std::min(grain_[j], std::abs(moved_[j]));
      still_[j] = still_readings_[j] = stopped_[j] = 0.0;
      continue;
    }
    if (still_readings_[j]++ == 0.0) {
      const std::size_t n = speeds_.size();
      const double last = speeds_[(oldest_ + n - 1) % n][j],
                   goes_on = 2.0 * last - speeds_[(oldest_ + n - 2) % n][j];
      double least = goes_on;
      for (const JointVector& speed : speeds_) {
        if (speed[j] * least <= 0.0) least = 0.0;
        if (std::abs(speed[j]) < std::abs(least)) least = speed[j];
      }
      const double rounding = std::min(std::abs(least), 2.0 * grain_[j] / dt);
      stops[j] = least - std::copysign(rounding, least);
    }
    still_[j] += dt;
  }
  if (M && M->allFinite() && !stops.isZero(0.0)) {
    const auto needed = M->lazyProduct(stops).cwiseAbs() / dt;
    const auto changed = (torque - torque_).cwiseAbs() + (external - external_).cwiseAbs();
    const auto friction = (kFriction * torque_limit_).cwiseMax(kLeastFriction);
    if ((needed - changed - friction).maxCoeff() > 0.0)
      stopped_ = (stops.array() != 0.0).select(stops, stopped_);
  }
  torque_ = torque;
  external_ = external;
  speeds_[oldest_] = moved_ / dt;
  oldest_ = (oldest_ + 1) % speeds_.size();
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
  if ((apart_.array().abs() / (kApart + late * fastest_.array())).maxCoeff(&j) > 1.0)
    return fmt::format(
        "the positions of joint {} contradict its speed: they are {:.3f} rad away from where it "
        "led, and it is {:.2f} rad/s",
        j + 1, apart_[j], v_[j]);
  const auto lasts = [](const JointVector& time, const JointVector& readings) -> JointVector {
    return (time.array() >= kSame && readings.array() >= kSameReadings).cast<double>();
  };
  const JointVector still = lasts(still_, still_readings_),
                    steady = lasts(steady_, steady_readings_);
  if (still.cwiseProduct(steady)
          .cwiseProduct(still_.cwiseMin(steady_))
          .cwiseProduct(v_)
          .cwiseAbs()
          .maxCoeff(&j) > kFrozen)
    return fmt::format(
        "joint {} turns at {:.3f} rad/s, but its position has not changed for {:.0f} ms", j + 1,
        v_[j], 1e3 * still_[j]);
  if (steady.cwiseProduct(beside_).cwiseAbs().maxCoeff(&j) > kMostBeside)
    return fmt::format(
        "the speed of joint {} has been {:.3f} rad/s for {:.0f} ms, which its positions contradict",
        j + 1, v_[j], 1e3 * steady_[j]);
  if (still.cwiseProduct(stopped_).cwiseAbs().maxCoeff(&j) > 0.0)
    return fmt::format(
        "the arm does not move, although joint {} turned at {:.3f} rad/s and no torque stopped it: "
        "brakes, or positions that stand still",
        j + 1, stopped_[j]);
  if (held_.maxCoeff(&j) > kHeld)
    return fmt::format(
        "joint {} does not move by a bit, although its torque asks it to: a brake, a wall, or a "
        "position that stands still",
        j + 1);
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
