// The line under the tip: friction that varies along it, and a tip that wears.
//
//   μ(s) = μ (1 + a sin(2π s/L))    s: length slid, a: friction_change, L: friction_length
//   ẇ    = k f_n |v_t|              w: length worn off, k: wear (Archard, J. Appl. Phys. 24, 1953)
#pragma once

#include <cmath>
#include <numbers>

#include "impedraw/simulation/world_settings.h"

namespace impedraw {

class TipLine {
 public:
  void reset() noexcept { *this = TipLine(); }

  // f_n: force along the normal [N]; v_t: sliding speed [m/s]; h: step [s].
  void advance(const TipMaterial& tip, double f_n, double v_t, double h) noexcept {
    slid_ += v_t * h;
    worn_ += tip.wear * f_n * v_t * h;
  }

  double slid() const { return slid_; }  // s [m]
  double worn() const { return worn_; }  // w [m]

  // The tip with the friction of this place.
  TipMaterial here(TipMaterial tip) const noexcept {
    if (tip.friction_change != 0.0)
      tip.friction *= 1.0 + tip.friction_change *
                                std::sin(2.0 * std::numbers::pi * slid_ / tip.friction_length);
    return tip;
  }

 private:
  double slid_ = 0.0, worn_ = 0.0;
};

}  // namespace impedraw
