#include "impedraw/control/torque_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace impedraw {

namespace {

struct Share {
  double s, alpha;
};

// The largest s in [0, 1] for which an α exists with lower ≤ τ + s u + α d ≤ upper, and the least
// such |α|. If there is none, s is NaN. Each joint bounds α from both sides by lines in s. Every
// lower bound must lie below every upper bound.
Share largest_share(const JointVector& tau, const JointVector& u, const JointVector& d,
                    const JointVector& lower, const JointVector& upper) {
  constexpr double kNone = 1e-9;
  double from = 0.0, to = 1.0;
  // a + b s ≤ 0
  const auto require = [&](double a, double b) {
    if (b > 0.0)
      to = std::min(to, -a / b);
    else if (b < 0.0)
      from = std::max(from, -a / b);
    else if (a > 0.0)
      to = -1.0;
  };
  struct Line {
    double a, b;  // a + b s
  };
  Line low[kMaxJoints], high[kMaxJoints];  // bounds of α
  int bounds = 0;
  for (Eigen::Index i = 0; i < tau.size(); ++i) {
    if (std::abs(d[i]) < kNone) {
      require(tau[i] - upper[i] - kNone, u[i]);
      require(lower[i] - tau[i] - kNone, -u[i]);
      continue;
    }
    const double b = -u[i] / d[i];
    low[bounds] = {((d[i] > 0.0 ? lower[i] : upper[i]) - tau[i]) / d[i], b};
    high[bounds++] = {((d[i] > 0.0 ? upper[i] : lower[i]) - tau[i]) / d[i], b};
  }
  for (int i = 0; i < bounds; ++i)
    for (int j = 0; j < bounds; ++j) require(low[i].a - high[j].a - kNone, low[i].b - high[j].b);
  if (!(from <= to)) return {std::nan(""), 0.0};
  double least = -std::numeric_limits<double>::infinity(), most = -least;
  for (int i = 0; i < bounds; ++i) {
    least = std::max(least, low[i].a + to * low[i].b);
    most = std::min(most, high[i].a + to * high[i].b);
  }
  return {to, std::max(least, std::min(most, 0.0))};
}

}  // namespace

TorqueLimits::TorqueLimits(const Eigen::VectorXd& limit, const Eigen::VectorXd& rate, double dt)
    : limit_(limit), step_(rate * dt) {}

bool TorqueLimits::inside(const JointVector& tau) const noexcept {
  for (int i = 0; i < tau.size(); ++i)
    if (tau[i] < -limit_[i] || tau[i] > limit_[i]) return false;
  return true;
}

// The last torque is always within the limits, so what lies between it and a torque within the
// limits does, too.
void TorqueLimits::clip_rate(LimitedTorque* out) noexcept {
  if (started_ && step_.size() != 0) {
    for (int i = 0; i < out->tau.size(); ++i) {
      const double within = std::clamp(out->tau[i], last_[i] - step_[i], last_[i] + step_[i]);
      out->limited |= within != out->tau[i];
      out->tau[i] = within;
    }
  }
  last_ = out->tau;
  started_ = true;
}

LimitedTorque TorqueLimits::clip(const JointVector& tau) noexcept {
  LimitedTorque out{tau, !inside(tau)};
  if (out.limited) out.tau = tau.cwiseMax(-limit_).cwiseMin(limit_);
  clip_rate(&out);
  return out;
}

LimitedTorque TorqueLimits::nearest(const JointVector& tau,
                                    const OperationalSpace& space) noexcept {
  const Eigen::Index n = tau.size();
  JointVector lower = -limit_, upper = limit_;
  if (started_ && step_.size() != 0) {
    lower = lower.cwiseMax(last_ - step_);
    upper = upper.cwiseMin(last_ + step_);
  }
  LimitedTorque out{tau.cwiseMax(lower).cwiseMin(upper)};
  out.limited = out.tau != tau;
  if (out.limited) {
    constexpr int kSweeps = 30;  // of projected Gauss-Seidel
    JointMatrix inverse(n, n);   // M⁻¹
    for (Eigen::Index j = 0; j < n; ++j)
      inverse.col(j) = space.acceleration(JointVector::Unit(n, j));
    for (int sweep = 0; sweep < kSweeps; ++sweep)
      for (Eigen::Index i = 0; i < n; ++i) {
        const double error = inverse.col(i).dot(out.tau - tau);
        out.tau[i] = std::clamp(out.tau[i] - error / inverse(i, i), lower[i], upper[i]);
      }
  }
  last_ = out.tau;
  started_ = true;
  return out;
}

LimitedTorque TorqueLimits::apply(const JointVector& hold, const JointVector& task,
                                  const JointVector& null, const ArmTerms& arm,
                                  const OperationalSpace& space) noexcept {
  LimitedTorque out{hold + task + null};
  if (!inside(out.tau)) {
    out.limited = true;
    Eigen::Index worst = 0;
    (out.tau.cwiseAbs() - limit_).maxCoeff(&worst);
    const JointVector unit = JointVector::Unit(hold.size(), worst);
    const JointVector d = unit - arm.J.transpose().lazyProduct(space.project_to_tip(unit));
    const Share share = largest_share(hold + null, task, d, -limit_, limit_);
    out.task_share = std::isnan(share.s) ? 0.0 : share.s;
    if (!std::isnan(share.s)) out.tau = hold + null + share.s * task + share.alpha * d;
    out.tau = out.tau.cwiseMax(-limit_).cwiseMin(limit_);  // for rounding errors and step 3
  }
  const LimitedTorque within = nearest(out.tau, space);
  out.tau = within.tau;
  out.limited |= within.limited;
  return out;
}

}  // namespace impedraw
