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

#include <array>

#include <Eigen/Core>

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
              double depth, double dt, TipMaterial* tip, Eigen::Vector3d* side) noexcept;
  void release() noexcept;  // it is out of the material

 private:
  static constexpr double kLeastSpeed = 1e-3;               // [m/s]
  static constexpr double kCell = 0.25e-3, kNear = 0.5e-3;  // [m]
  static constexpr double kApart = 0.05e-3;                 // between cuts that are kept [m]

  struct Cut {
    Eigen::Vector3d p;
    double depth;
  };
  void keep(const Cut& cut) noexcept;  // as a groove

  CutterSettings settings_;
  PlaceMap floor_{kCell, 1u << 18};                // value: depth [m]
  std::array<Cut, 64> own_;                        // not yet left
  std::size_t oldest_ = 0, count_ = 0;             // of own_
  Eigen::Vector3d way_ = Eigen::Vector3d::Zero();  // w
};

}  // namespace impedraw
