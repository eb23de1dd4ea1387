#include "impedraw/run/motion_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

constexpr double kApart = 8e-3, kLag = 0.03, kUsual = 5e-3, kForget = 1;      // [rad], [s]
constexpr double kUnmoved = 0.15, kStill = 1e-4, kAsked = 0.1, kHeld = 0.02;  // [s], [rad], share
constexpr double kSame = 8e-3, kSameReadings = 3, kFrozen = 1e-4;             // [s], –, [rad]
constexpr double kFriction = 0.02, kLeastFriction = 1.5;                      // share, [Nm]
constexpr Eigen::Index kTogether = 3;                                         // joints
constexpr double kCreeps = 1e-3;                                              // [rad/s]
constexpr double kBeside = 0.05, kMostBeside = 1e-3;                          // [s], [rad]

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

std::string SpeedsBesidePositions::update(const MotionReading& now, const MotionLimits& limits) {
  if (!now.v) return {};
  const double kept = std::exp(-now.dt / kForget);
  apart_ = kept * (apart_ + now.moved - 0.5 * now.dt * (*now.v + *now.v_before));
  fastest_ = (kept * fastest_).cwiseMax(now.v->cwiseAbs()).cwiseMin(limits.speed);
  Eigen::Index j = 0;
  const double late = kLag + std::max(0.0, now.dt - kUsual);
  if ((apart_.array().abs() / (kApart + late * fastest_.array())).maxCoeff(&j) <= 1.0) return {};
  return fmt::format(
      "the positions of joint {} contradict its speed: they are {:.3f} rad away from where it led, "
      "and it is {:.2f} rad/s",
      j + 1, apart_[j], (*now.v)[j]);
}

ReadingsThatStand::ReadingsThatStand(int joints)
    : still_{JointVector::Zero(joints), JointVector::Zero(joints)},
      steady_{JointVector::Zero(joints), JointVector::Zero(joints)},
      beside_(JointVector::Zero(joints)),
      grain_(JointVector::Constant(joints, std::numeric_limits<double>::infinity())),
      stopped_(JointVector::Zero(joints)),
      torque_(JointVector::Zero(joints)),
      external_(JointVector::Zero(joints)) {
  speeds_.fill(beside_);
}

void ReadingsThatStand::Same::update(Eigen::Index j, bool same, double dt) noexcept {
  time[j] = same ? time[j] + dt : 0.0;
  readings[j] = same ? readings[j] + 1.0 : 0.0;
}

JointVector ReadingsThatStand::Same::lasts() const {
  return (time.array() >= kSame && readings.array() >= kSameReadings).cast<double>();
}

std::string ReadingsThatStand::update(const MotionReading& now, const MotionLimits& limits) {
  for (Eigen::Index j = 0; j < now.moved.size(); ++j) {
    const bool steady = now.v && (*now.v)[j] == (*now.v_before)[j];
    steady_.update(j, steady, now.dt);
    beside_[j] = steady ? std::exp(-now.dt / kBeside) *
                              (beside_[j] + now.moved[j] - (*now.v_before)[j] * now.dt)
                        : 0.0;
    still_.update(j, now.moved[j] == 0.0, now.dt);
    if (now.moved[j] == 0.0) continue;
    grain_[j] = std::min(grain_[j], std::abs(now.moved[j]));
    if (stopped_[j] != 0.0) stopped_.setZero();  // it goes on: there was no such stop
  }
  update_stops(now, limits);
  Eigen::Index j = 0;
  const JointVector still = still_.lasts(), steady = steady_.lasts();
  if (now.v && (still.array() * steady.array() * still_.time.cwiseMin(steady_.time).array() *
                now.v->array().abs())
                       .maxCoeff(&j) > kFrozen)
    return fmt::format(
        "joint {} turns at {:.3f} rad/s, but its position has not changed for {:.0f} ms", j + 1,
        (*now.v)[j], 1e3 * still_.time[j]);
  if (steady.cwiseProduct(beside_).cwiseAbs().maxCoeff(&j) > kMostBeside)
    return fmt::format(
        "the speed of joint {} has been {:.3f} rad/s for {:.0f} ms, which its positions contradict",
        j + 1, (*now.v)[j], 1e3 * steady_.time[j]);
  if (still.cwiseProduct(stopped_).cwiseAbs().maxCoeff(&j) > 0.0)
    return fmt::format(
        "the arm does not move, although joint {} turned at {:.3f} rad/s and no torque stopped it: "
        "brakes, or positions that stand still",
        j + 1, stopped_[j]);
  return {};
}

void ReadingsThatStand::update_stops(const MotionReading& now, const MotionLimits& limits) {
  const std::size_t n = speeds_.size();
  const auto goes_on = 2.0 * speeds_[(oldest_ + n - 1) % n] - speeds_[(oldest_ + n - 2) % n];
  JointVector stops = JointVector::Zero(now.moved.size());
  for (Eigen::Index j = 0; j < stops.size(); ++j) {
    if (still_.readings[j] != 1.0) continue;
    double least = goes_on[j];
    for (const JointVector& speed : speeds_) {
      if (speed[j] * least <= 0.0) least = 0.0;
      if (std::abs(speed[j]) < std::abs(least)) least = speed[j];
    }
    const double rounding = std::min(std::abs(least), 2.0 * grain_[j] / now.dt);
    stops[j] = least - std::copysign(rounding, least);
  }
  if (now.M && now.M->allFinite() && !stops.isZero(0.0)) {
    JointVector reacts = now.moved / now.dt - goes_on;
    reacts = (still_.readings.array() == 1.0).select(0.0, reacts);
    const auto needed = now.M->lazyProduct(stops).cwiseAbs().cwiseMin(
                            now.M->lazyProduct(stops - reacts).cwiseAbs()) /
                        now.dt;
    const auto changed = (now.torque - torque_).cwiseAbs() + (now.external - external_).cwiseAbs();
    const auto friction = (kFriction * limits.torque).cwiseMax(kLeastFriction);
    if (((stops.array() != 0.0).count() >= kTogether && stops.cwiseAbs().maxCoeff() > kCreeps) ||
        (needed - changed - friction).maxCoeff() > 0.0)
      stopped_ = (stops.array() != 0.0).select(stops, stopped_);
  }
  torque_ = now.torque;
  external_ = now.external;
  speeds_[oldest_] = now.moved / now.dt;
  oldest_ = (oldest_ + 1) % n;
}

std::string TorquesThatMoveNothing::update(const MotionReading& now, const MotionLimits& limits) {
  if ((now.q - place_).cwiseAbs().maxCoeff() > kStill) {
    place_ = now.q;
    unmoved_ = 0.0;
  }
  const JointVector shares =
      (now.torque.cwiseAbs() - now.external.cwiseAbs()).cwiseQuotient(limits.torque);
  if (!shares.allFinite()) return {};
  unmoved_ = std::max(0.0, unmoved_ + (shares.maxCoeff() - kAsked) * now.dt);
  for (Eigen::Index j = 0; j < held_.size(); ++j)
    if (now.moved[j] != 0.0)
      held_[j] = 0.0;
    else if (held_[j] >= 0.0)
      held_[j] = std::max(0.0, held_[j] + (shares[j] - kAsked) * now.dt);
  Eigen::Index j = 0;
  if (held_.maxCoeff(&j) > kHeld)
    return fmt::format(
        "joint {} does not move by a bit, although its torque asks it to: a brake, a wall, or a "
        "position that stands still",
        j + 1);
  if (unmoved_ > kUnmoved)
    return fmt::format(
        "the arm does not move, although {:.0f} % of a joint's largest torque ask it to: brakes, a "
        "wall, or positions that stand still",
        1e2 * shares.maxCoeff());
  return {};
}

}  // namespace impedraw
