#include "impedraw/planning/preflight/posture_check.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "impedraw/arm/least_energy_step.h"
#include "impedraw/common/errors.h"
#include "impedraw/control/heading.h"

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr double kMostDrift = 0.1;  // per step [rad]
constexpr double kThere = 0.1;      // joints of an arm that is at a place already [rad]
constexpr int kFollowSteps = 30, kEnterSteps = 100, kLostSteps = 20;

double limit_distance(const ArmLimits& limits, const JointVector& q, int j) {
  return std::min(q[j] - limits.lower[j], limits.upper[j] - q[j]);
}

// Rotation about the pen's axis is free, so its row is removed.
TipJacobian without_spin(const ArmTerms& terms) {
  TipJacobian J = terms.J;
  const Vector3d z = terms.X_WE.R.col(2);
  J.bottomRows<3>() -= z * (z.transpose() * terms.J.bottomRows<3>());
  return J;
}

// The law's defaults for this arm.
ImpedanceSettings law_of(const ArmModel& arm) {
  ImpedanceSettings law;
  law.joint_range.lower = arm.limits().lower;
  law.joint_range.upper = arm.limits().upper;
  return law.completed(arm.joints());
}

JointVector sized(const JointVector& q, const ArmModel& arm, const char* name) {
  if (q.size() == arm.joints()) return q;
  throw InputError(
      fmt::format("preflight: {} has {} entries, the arm {} joints", name, q.size(), arm.joints()));
}

}  // namespace

JointVector holding_torque(const ArmTerms& terms, const Vector3d& axis, double normal_force,
                           double friction) {
  JointVector torque(terms.g.size());
  for (Eigen::Index j = 0; j < torque.size(); ++j) {
    const Vector3d column = terms.J.col(j).head<3>();
    const double along = column.dot(axis);
    torque[j] = std::abs(terms.g[j] + normal_force * along) +
                friction * normal_force * (column - along * axis).norm();
  }
  return torque;
}

PostureCheck::PostureCheck(const ArmModel& arm, const Canvas* obstacle, const JointVector& start_q,
                           const PreflightSettings& settings)
    : arm_(arm),
      settings_(settings),
      start_(sized(start_q, arm, "start_q")),
      rest_(settings.rest_q ? sized(*settings.rest_q, arm, "rest_q") : start_),
      clearance_(arm, obstacle, settings.table_z, settings.clearance, settings.tip_length, start_),
      terms_(arm.joints()),
      law_(law_of(arm)),
      range_(law_),
      space_(settings.space) {}

PostureCheck::Change PostureCheck::change(const Posture& a, const Posture& b) {
  Change change;
  change.by = (b.q - a.q).cwiseAbs().maxCoeff(&change.joint);
  return change;
}

JointVector PostureCheck::drift(const JointVector& q) const {
  JointVector d = rest_ - q;
  for (Eigen::Index j = 0; j < d.size(); ++j) {
    const JointRange::Depth depth = range_.depth(q, j);
    d[j] += law_.joint_range.torque / law_.null_space.stiffness[j] *
            (depth.lower * depth.lower - depth.upper * depth.upper);
  }
  const TipJacobian& J = terms_.J;
  const Matrix6 A = J * J.transpose() + 1e-9 * Matrix6::Identity();
  return d - J.transpose() * A.llt().solve(J * d);
}

// The joints' way in that time, as the law turns the pen about its axis (heading.h). The rate falls
// as the joint leaves its end, by d(rate)/d(angle) = 2 √(kHeadingRate rate) / margin where it turns
// as the pen does: an implicit step, which does not overshoot.
JointVector PostureCheck::turned(double time) {
  space_.update(terms_);
  const double rate = heading_rate(terms_, space_, range_);
  const double slope = 2.0 * std::sqrt(kHeadingRate * std::abs(rate)) / law_.joint_range.margin;
  Vector6 spin = Vector6::Zero();
  spin.tail<3>() = rate * time / (1.0 + slope * time) * terms_.X_WE.R.col(2);
  return space_.joint_speed(spin);
}

double PostureCheck::effective_mass() const {
  Vector6 scale;
  scale << Vector3d::Ones(), Vector3d::Constant(settings_.space.characteristic_length);
  const TipJacobian J = scale.asDiagonal() * terms_.J;
  const Matrix6 A = J * terms_.M.llt().solve(JointMatrix(J.transpose()));
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(A, Eigen::EigenvaluesOnly);
  return 1 / std::max(eigen.eigenvalues()[0], 1e-12);
}

void PostureCheck::say_unreached(const PenPlacement& pen, const IkResult& found, Posture* posture) {
  const Vector6 e = tip_displacement(terms_.X_WE, pen.p_WE, pen.z_WE, pen.x_WE);
  // The error that would remain without joint limits. If it is small, a limit is the cause.
  const TipJacobian J = pen.led() ? terms_.J : without_spin(terms_);
  constexpr double kDamping = 1e-3, kAtLimit = 0.02;
  const Matrix6 A = J * J.transpose() + kDamping * Matrix6::Identity();
  const double stays = (kDamping * A.llt().solve(e)).norm() / std::max(e.norm(), 1e-12);
  int at_limit = -1;
  for (int j = 0; j < found.q.size(); ++j) {
    if (limit_distance(arm_.limits(), found.q, j) < kAtLimit) at_limit = j;
  }
  const double degrees = found.axis_error * 180 / std::numbers::pi, mm = 1e3 * found.position_error;
  posture->amount = found.position_error + 0.3 * found.axis_error;
  if (at_limit >= 0 && stays < 0.5) {
    posture->problem = Problem::joint_limit;
    posture->text =
        fmt::format("joint {} at its limit of {:.2f} rad, the tip stays {:.0f} mm and {:.0f}° off",
                    at_limit + 1, found.q[at_limit], mm, degrees);
  } else {
    posture->problem = Problem::out_of_reach;
    posture->text = degrees < 1
                        ? fmt::format("{:.0f} mm too far", mm)
                        : fmt::format("the tip stays {:.0f} mm and {:.0f}° off", mm, degrees);
  }
}

void PostureCheck::examine(const PenPlacement& pen, Posture* posture) {
  Posture& p = *posture;
  const ArmLimits& limits = arm_.limits();
  const int n = arm_.joints();
  const auto report = [&p](Problem problem, double amount, std::string text) {
    if (p.problem) return;
    p.problem = problem;
    p.amount = amount;
    p.text = std::move(text);
  };

  int nearest = 0;
  for (int j = 0; j < n; ++j) {
    const double room = limit_distance(limits, p.q, j);
    if (room < p.margins.joint) p.margins.joint = room, nearest = j;
  }
  if (p.margins.joint < settings_.joint_margin)
    report(Problem::joint_limit, -p.margins.joint,
           fmt::format("joint {} at {:.2f} rad, {:.3f} rad from its limit", nearest + 1,
                       p.q[nearest], p.margins.joint));

  p.margins.effective_mass = effective_mass();
  if (p.margins.effective_mass > settings_.space.max_effective_mass)
    report(Problem::near_singular, p.margins.effective_mass,
           fmt::format("effective mass {:.0f} kg, allowed {:.0f} kg", p.margins.effective_mass,
                       settings_.space.max_effective_mass));

  if (asked.torque) {
    const JointVector torque =
        holding_torque(terms_, pen.z_WE, settings_.normal_force, settings_.friction);
    int worst = 0;
    double needed = 0;
    for (int j = 0; j < n; ++j) {
      if (torque[j] <= p.margins.torque_share * limits.torque[j]) continue;
      p.margins.torque_share = torque[j] / limits.torque[j];
      needed = torque[j];
      worst = j;
    }
    if (p.margins.torque_share > settings_.torque_share)
      report(Problem::torque, p.margins.torque_share,
             fmt::format("joint {} needs {:.0f} Nm, allowed {:.0f} Nm", worst + 1, needed,
                         settings_.torque_share * limits.torque[worst]));
  }

  const Gap arm = clearance_.arm(p.q);
  p.margins.clearance = arm.gap;
  if (arm.gap < settings_.clearance)
    report(Problem::arm_collision, -arm.gap,
           fmt::format("{} {:.0f} mm {} the {}", arm.body, 1e3 * std::abs(arm.gap),
                       arm.gap < 0 ? "into" : "from", arm.obstacle));
  if (!asked.pen || p.problem) return;
  Gap shaft = clearance_.pen(p.q, terms_.X_WE);
  if (settings_.height_error) shaft.gap -= settings_.height_error(terms_.X_WE.p);
  if (shaft.gap < 0)
    report(Problem::pen_collision, -shaft.gap,
           fmt::format("the tool {:.0f} mm above its tip is {:.1f} mm too near the {}",
                       1e3 * shaft.above_tip, -1e3 * shaft.gap, shaft.obstacle));
}

Posture PostureCheck::solve(const PenPlacement& pen, const JointVector& seed, int max_steps,
                            bool free_spin) {
  IkSettings ik;
  ik.free_spin = free_spin;
  ik.position_tolerance = ik.axis_tolerance = 1e-5;
  ik.max_steps = max_steps;
  const IkResult found = find_posture(arm_, pen, seed, ik);
  Posture posture;
  posture.q = found.q;
  posture.reached = found.reached;
  arm_.compute(found.q, JointVector::Zero(found.q.size()), &terms_);
  posture.drift = drift(found.q);
  if (!found.reached) say_unreached(pen, found, &posture);
  return posture;
}

Posture PostureCheck::follow(const PenPlacement& pen, const Posture& last, double moved,
                             std::optional<double> time) {
  JointVector pull = (1 - std::exp(-moved / kRelax)) * last.drift;
  if (!last.reached)
    pull.setZero();
  else
    pull *= std::min(1.0, kMostDrift / std::max(pull.cwiseAbs().maxCoeff(), 1e-12));
  Posture posture = solve(pen, last.q + pull, last.reached ? kFollowSteps : kLostSteps, false);
  if (posture.reached && !pen.led() && range_.room(posture.q) < law_.joint_range.margin) {
    const JointVector turn = turned(time.value_or(moved / settings_.speed));
    if (!turn.isZero()) {
      Posture away = solve(pen, posture.q + turn, kFollowSteps, false);
      if (away.reached)
        posture = std::move(away);
      else
        arm_.compute(posture.q, JointVector::Zero(posture.q.size()), &terms_);
    }
  }
  if (posture.reached) examine(pen, &posture);
  return posture;
}

Posture PostureCheck::begin(const PenPlacement& pen, const JointVector& q) {
  Posture posture = solve(pen, q, kFollowSteps, false);
  if (!posture.reached || (posture.q - q).cwiseAbs().maxCoeff() > kThere) return enter(pen, q);
  examine(pen, &posture);
  return posture;
}

Posture PostureCheck::enter(const PenPlacement& pen, const JointVector& last) {
  std::optional<Posture> best;
  for (const JointVector& seed : {last, rest_, start_}) {
    Posture posture = solve(pen, seed, kEnterSteps);
    for (int i = 0; posture.reached && i < 15 && posture.drift.norm() > 0.05; ++i) {
      const double most = std::max(posture.drift.cwiseAbs().maxCoeff(), 1e-12);
      Posture rested = solve(pen, posture.q + std::min(0.5, 3 * kMostDrift / most) * posture.drift,
                             kFollowSteps);
      if (!rested.reached) break;
      posture = std::move(rested);
    }
    if (posture.reached) {
      arm_.compute(posture.q, JointVector::Zero(posture.q.size()), &terms_);
      examine(pen, &posture);
      if (!posture.problem) return posture;
    }
    const bool better = !best || (posture.reached && !best->reached) ||
                        (!posture.reached && !best->reached && posture.amount < best->amount);
    if (better) best = std::move(posture);
  }
  return *best;
}

}  // namespace impedraw
