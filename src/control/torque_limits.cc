#include "impedraw/control/torque_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

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

// The x in [lower, upper] with the least (x − tau)ᵀ M⁻¹ (x − tau). Where x_A lies at its bounds and
// the rest is free: λ_A = M_AA⁻¹ (x_A − tau_A), x = tau + M_·A λ_A. A is found by pivoting: each
// joint outside goes to its bound, each that its bound need not hold is freed, all at once. While
// that does not lessen their number, only the last one is, which ends after finitely many pivots
// (Júdice and Pires 1994).
JointVector nearest_in_box(const JointVector& tau, const JointVector& lower,
                           const JointVector& upper, const JointMatrix& M) {
  constexpr int kMostPivots = 100, kPatience = 3;
  constexpr double kNone = 1e-9;
  const int n = static_cast<int>(tau.size());
  JointVector x = tau;
  int side[kMaxJoints] = {};  // -1: at lower, 1: at upper, 0: free
  int fewest = n + 1, patience = kPatience;
  JointVector pull = JointVector::Zero(n);  // λ
  for (int pivot = 0; pivot < kMostPivots; ++pivot) {
    int wanted[kMaxJoints];
    int changes = 0, last = 0;
    for (int i = 0; i < n; ++i) {
      wanted[i] = side[i] != 0 ? (pull[i] * side[i] > kNone ? 0 : side[i])
                               : (x[i] > upper[i] + kNone) - (x[i] < lower[i] - kNone);
      if (wanted[i] == side[i]) continue;
      ++changes;
      last = i;
    }
    if (changes == 0) return x.cwiseMax(lower).cwiseMin(upper);
    patience = changes < fewest ? kPatience : patience - 1;
    fewest = std::min(fewest, changes);
    if (patience >= 0)
      std::copy(wanted, wanted + n, side);
    else
      side[last] = wanted[last];

    int at[kMaxJoints];
    int m = 0;
    for (int i = 0; i < n; ++i)
      if (side[i] != 0) at[m++] = i;
    JointMatrix M_AA(m, m);
    JointVector lack(m);
    for (int r = 0; r < m; ++r) {
      lack[r] = (side[at[r]] > 0 ? upper : lower)[at[r]] - tau[at[r]];
      for (int c = 0; c < m; ++c) M_AA(r, c) = M(at[r], at[c]);
    }
    M_AA.llt().solveInPlace(lack);
    x = tau;
    pull.setZero();
    for (int r = 0; r < m; ++r) {
      pull[at[r]] = lack[r];
      x += lack[r] * M.col(at[r]);
    }
    for (int r = 0; r < m; ++r) x[at[r]] = (side[at[r]] > 0 ? upper : lower)[at[r]];
  }
  return tau.cwiseMax(lower).cwiseMin(upper);
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

LimitedTorque TorqueLimits::nearest(const JointVector& tau, const JointMatrix& M) noexcept {
  JointVector lower = -limit_, upper = limit_;
  if (started_ && step_.size() != 0) {
    lower = lower.cwiseMax(last_ - step_);
    upper = upper.cwiseMin(last_ + step_);
  }
  LimitedTorque out{tau.cwiseMax(lower).cwiseMin(upper)};
  out.limited = out.tau != tau;
  if (out.limited) out.tau = nearest_in_box(tau, lower, upper, M);
  last_ = out.tau;
  started_ = true;
  return out;
}

LimitedTorque TorqueLimits::apply(const JointVector& hold, const JointVector& task,
                                  const JointVector& null, const ArmTerms& arm,
                                  const OperationalSpace& space, const Eigen::Vector3d& n,
                                  double rho) noexcept {
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
  JointMatrix M = arm.M;
  if (rho > 0.0) {
    const JointVector g = arm.J.topRows<3>().transpose() * n;
    M -= rho / g.dot(space.acceleration(g)) * g * g.transpose();
  }
  const LimitedTorque within = nearest(out.tau, M);
  out.tau = within.tau;
  out.limited |= within.limited;
  return out;
}

}  // namespace impedraw
