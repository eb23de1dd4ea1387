#include "impedraw/simulation/cutter_contact.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace impedraw {

void CutterContact::keep(const Cut& cut) noexcept {
  KeptPlace* const place = floor_.at(cut.p);
  if (!place || cut.depth <= place->value) return;
  place->p = cut.p;
  place->value = cut.depth;
}

void CutterContact::release() noexcept {
  for (std::size_t i = 0; i < count_; ++i) keep(own_[(oldest_ + i) % own_.size()]);
  count_ = 0;
  way_.setZero();
}

void CutterContact::engage(const Eigen::Vector3d& p, const Eigen::Vector3d& n,
                           const Eigen::Vector3d& v, double depth, double dt, TipMaterial* tip,
                           Eigen::Vector3d* side) noexcept {
  const double v_n = n.dot(v), slope = std::tan(settings_.half_angle);
  const Eigen::Vector3d v_t = v - n * v_n;
  const double speed = v_t.norm();
  const double turned = std::min(1.0, 2.0 * speed * dt / (slope * depth));
  if (speed > 0.0) way_ += turned * (v_t / speed - way_);
  const Eigen::Vector3d across = n.cross(way_);
  double groove = 0.0;
  floor_.around(p, [&](const KeptPlace& cut) {
    const Eigen::Vector3d to = cut.p - p;
    if (to.squaredNorm() > kNear * kNear) return;
    groove = std::max(groove, cut.value - std::abs(across.dot(to)) / slope);
  });
  const auto own = [this](std::size_t i) -> Cut& { return own_[(oldest_ + i) % own_.size()]; };
  while (count_ > 0 && (count_ == own_.size() || (own(0).p - p).norm() > kNear)) {
    keep(own(0));
    oldest_ = (oldest_ + 1) % own_.size();
    --count_;
  }
  if (count_ == 0 || (own(count_ - 1).p - p).norm() > kApart) own(count_++) = {p, depth};
  own(count_ - 1).depth = std::max(own(count_ - 1).depth, depth);
  const double sliding = std::max(speed, kLeastSpeed);
  const CutForces f = cut_forces(settings_, depth, groove, sliding);
  tip->stiffness = f.normal / depth;
  tip->damping =
      2.0 * f.normal * slope / (std::numbers::pi * std::max(sliding, slope * std::abs(v_n)));
  tip->friction = f.normal > 0.0 ? f.drag / f.normal : 0.0;
  *side = f.side * across;
}

}  // namespace impedraw
