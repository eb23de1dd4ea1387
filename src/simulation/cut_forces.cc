#include "impedraw/simulation/cut_forces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace impedraw {

CutForces cut_forces(const CutterSettings& s, double depth, double groove, double speed) noexcept {
  using std::numbers::pi;
  const double fresh = depth - std::max(0.0, groove);  // δ
  if (!(fresh > 0.0)) return {};
  // Lengths of a fresh edge with the same ∫ sin φ, ∫ 1 and ∫ sin² φ over what cuts: slices of equal
  // ratio, from δ up.
  double sine = fresh, one = fresh, square = fresh;
  constexpr int kSlices = 16;
  const double step = std::log(depth / fresh) / kSlices;
  for (int i = 0; step > 0.0 && i < kSlices; ++i) {
    const double z = fresh * std::exp((i + 0.5) * step), dz = z * step, share = fresh / z,
                 rest = 1.0 - share, phi = std::acos(rest);
    sine += share * dz;
    one += 2.0 / pi * phi * dz;
    square += 2.0 / pi * (phi - rest * std::sqrt(1.0 - rest * rest)) * dz;
  }
  const double c = speed / (s.flutes * s.turns), cosine = std::cos(s.half_angle);
  const double scale = s.hardness * s.flutes;
  return {scale * std::sin(s.half_angle) * (s.K_rc * c / pi * sine + s.K_re / (2.0 * cosine) * one),
          scale * (s.K_rc * c * cosine / 4.0 * square + s.K_re / pi * sine),
          scale * (s.K_tc * c / 4.0 * square + s.K_te / (pi * cosine) * sine)};
}

}  // namespace impedraw
