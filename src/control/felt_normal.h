// The surface's normal under the tip, as the measured force tells it. Perception smooths a surface
// that is rougher than its points are close; the force does not.
//
// Law   f = f_n (n_F − μ s), s: the direction of the slip, of length below 1 while it fades in
//       x = n + |s| (f_t + min(max(−f_t·s, 0), μ̂ f_n) s) / f_n,  f_n = n·f,  f_t = f − f_n n
//       n_F ← n_F + (Δt/T) (x − n_F), T = 5 ms
// A force that friction up to μ̂ can explain is no slope, so the angle is exact across the
// stroke and only what exceeds friction along it.
// Away from another normal m, n_F counts only beyond deviation + force_error/f_n, a tangent, by 1
// at most: a smooth surface is perceived better than felt. A force along m leaves m as it is.
// The pen's axis does not follow it: a wrist that turns with every grain shakes the pen.
// Requires   unit normals; f: the force on the tip, in W, of a contact that lasts.
#pragma once

#include <algorithm>

#include <Eigen/Core>

namespace impedraw {

struct FeltNormalSettings {
  // Share of the felt normal, beyond the deviation, in the normal that the law follows. 0: unused
  // at all, neither for that nor for where the tip touches nor for the push. A hand that pushes the
  // tip aside feels like a slope: to be used where perception is known to smooth the surface.
  double share = 0.0;
  double deviation = 0.1;     // tangent of the angle below which perception is believed
  double force_error = 0.25;  // of the measured force across the normal [N]
};

// The part of a force across the normal that Coulomb friction up to `most` explains [N]: against
// the slip, along which the rest may only push.
inline Eigen::Vector3d friction_in(const Eigen::Vector3d& f_t, const Eigen::Vector3d& slip,
                                   double most) noexcept {
  return -std::clamp(-f_t.dot(slip), 0.0, most) * slip;
}

class FeltNormal {
 public:
  FeltNormal(const FeltNormalSettings& settings, double dt) : settings_(settings), dt_(dt) {}

  bool in_use() const noexcept { return settings_.share > 0.0; }

  // n: the normal that the law follows; slip: see above; least_force: f_n below which the force
  // tells nothing [N].
  void update(const Eigen::Vector3d& n, const Eigen::Vector3d& f, const Eigen::Vector3d& slip,
              double friction, double least_force) noexcept {
    constexpr double kTime = 5e-3;  // 0.25 mm at 50 mm/s: a quarter of the ball's radius [s]
    if (!in_use()) return;
    if (!known_) n_F_ = n;
    known_ = true;
    const double f_n = n.dot(f);
    if (f_n < least_force) return;
    const Eigen::Vector3d f_t = f - f_n * n;
    const Eigen::Vector3d aside = f_t - friction_in(f_t, slip, friction * f_n);
    // At rest the spring's own pull would be taken for a slope.
    const Eigen::Vector3d x = (n + slip.norm() / f_n * aside).normalized();
    n_F_ = (n_F_ + std::min(1.0, dt_ / kTime) * (x - n_F_)).normalized();
    deviation_ = settings_.deviation + settings_.force_error / f_n;
  }
  void reset() noexcept { known_ = false; }

  // The normal where the tip touches, by one who follows n; n itself without a contact.
  Eigen::Vector3d seen_from(const Eigen::Vector3d& n) const noexcept {
    return (n + beyond(n)).normalized();
  }
  // The perceived normal, corrected by `share` of what was felt.
  Eigen::Vector3d corrected(const Eigen::Vector3d& perceived) const noexcept {
    return (perceived + settings_.share * beyond(perceived)).normalized();
  }

 private:
  Eigen::Vector3d beyond(const Eigen::Vector3d& m) const noexcept {
    constexpr double kMost = 1.0, kLeastCosine = 0.1;
    if (!known_) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d tangent = n_F_ / std::max(n_F_.dot(m), kLeastCosine);
    const Eigen::Vector3d aside = tangent - m * m.dot(tangent);
    const double size = aside.norm();
    return aside * (std::clamp(size - deviation_, 0.0, kMost) / std::max(size, 1e-9));
  }

  FeltNormalSettings settings_;
  double dt_;
  bool known_ = false;
  double deviation_ = 0.0;  // with the present force
  Eigen::Vector3d n_F_ = Eigen::Vector3d::UnitZ();
};

}  // namespace impedraw
