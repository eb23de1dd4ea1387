// Mean forces on a turning conical cutter that moves along its groove: the linear edge-force model
// of milling, integrated over a cone in a slot.
//
//   dF_t = K_tc h db + K_te db,  dF_r = K_rc h db + K_re db      on an edge of length db
//   db = dz/cos α,  h = c sin φ cos α,  c = v/(N n)              chip; φ from across the way
//   dF_t acts along the edge's motion, dF_r along the cone's normal
//
// In fresh material, of the depth d:
//   normal = N sin α (K_rc c/π + K_re/(2 cos α)) d
//   drag   = N (K_rc c cos α/4 + K_re/π) d                       against the way
//   side   = N (K_tc c/4 + K_te/(π cos α)) d                     across it
// Within a groove of depth g < d along the same way, δ = d − g, only the sides cut where z > δ:
// there cos φ > 1 − δ/z.
//
// Model: Y. Altintas, Manufacturing Automation, 2nd ed., 2012, chapter 2. Coefficients: Al 7075-T6,
// carbide, dry, as listed in Chinese J. Mech. Eng. 34, 2021 (10.1186/s10033-021-00536-9), table 5,
// its reference 160.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace impedraw {

struct CutterSettings {
  double half_angle = 0.7853981633974483;   // α, of the cone [rad]
  int flutes = 1;                           // N
  double turns = 400.0;                     // n [1/s]
  double K_tc = 600.46e6, K_rc = 180.96e6;  // [N/m²]
  double K_te = 17.9e3, K_re = 20.42e3;     // [N/m]
  double hardness = 1.0;                    // a multiple of all four
};

struct CutForces {
  double normal = 0.0, drag = 0.0, side = 0.0;  // [N]
};

// depth d, groove g [m]; speed v along the surface [m/s]. None where the depth is not above the
// groove's.
inline CutForces cut_forces(const CutterSettings& s, double depth, double groove,
                            double speed) noexcept {
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
