// Contact of a turning conical cutter with the canvas, whose material it takes away.
//
//   f_n = max(0, F_n(d, g, v) − b v_n),  b = 2 F_n tan α/(π u),  u = max(v, |v_n| tan α, 1 mm/s)
//   |f_t| ≤ F_drag f_n/F_n,  side = F_side n × w                          cut_forces.h
//   ẇ = (v_t − v w)/ℓ,  ℓ = d tan α/2        w: where the uncut material is, 0 as it sinks in
//
// d: depth of the apex below the canvas; g: of the groove that lies ahead. b: a cutter that also
// sinks cuts with more than its front, as far as its motion faces the cone. Run-out of the spindle
// keeps it cutting at rest as at 1 mm/s. What is cut is a groove once the cutter has left it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/common/place_map.h"
#include "impedraw/simulation/cut_forces.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

class CutterContact {
 public:
  explicit CutterContact(const CutterSettings& settings) : settings_(settings) {}

  // The apex is `depth` below p, where the canvas has the normal n, and moves with v relative to
  // it; all in the canvas's frame. Sets what the tip is like there, and the force across its way.
  // Takes the material away.
  void engage(const Eigen::Vector3d& p, const Eigen::Vector3d& n, const Eigen::Vector3d& v,
              double depth, double dt, TipMaterial* tip, Eigen::Vector3d* side) noexcept {
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
  void release() noexcept {
    for (std::size_t i = 0; i < count_; ++i) keep(own_[(oldest_ + i) % own_.size()]);
    count_ = 0;
    way_.setZero();
  }  // it is out of the material

 private:
  static constexpr double kLeastSpeed = 1e-3;               // [m/s]
  static constexpr double kCell = 0.25e-3, kNear = 0.5e-3;  // [m]
  static constexpr double kApart = 0.05e-3;                 // between cuts that are kept [m]

  struct Cut {
    Eigen::Vector3d p;
    double depth;
  };
  void keep(const Cut& cut) noexcept {
    KeptPlace* const place = floor_.at(cut.p);
    if (!place || cut.depth <= place->value) return;
    place->p = cut.p;
    place->value = cut.depth;
  }  // as a groove

  CutterSettings settings_;
  PlaceMap floor_{kCell, 1u << 18};                // value: depth [m]
  std::array<Cut, 64> own_;                        // not yet left
  std::size_t oldest_ = 0, count_ = 0;             // of own_
  Eigen::Vector3d way_ = Eigen::Vector3d::Zero();  // w
};

}  // namespace impedraw
