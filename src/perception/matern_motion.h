// A coordinate whose spectrum falls smoothly, as a person's hand moves: its velocity is a Gaussian
// process with a Matérn kernel, of correlation time 1/λ and driven by white noise w of density q.
//
//   order 2   v̇ = −λ v + w             ν = 1/2, spectrum of x ∝ 1/(ω² (ω² + λ²))
//   order 3   v̈ = −λ² v − 2 λ v̇ + w    ν = 3/2, spectrum of x ∝ 1/(ω² (ω² + λ²)²)
//
// With λ = 0 they are integrated Wiener processes. The position needs no mean to return to: x
// drifts where v does.
//
// Source: S. Särkkä, A. Solin, "Applied Stochastic Differential Equations", 2019, section 12.3.
#pragma once

#include <cmath>

#include "impedraw/perception/axis_state.h"

namespace impedraw {

// The state after dt ≥ 0 without noise: [x v a]ᵀ ← F [x v a]ᵀ, F with first column [1 0 0]ᵀ.
struct MaternStep {
  double xv = 0.0, xa = 0.0, vv = 1.0, va = 0.0, av = 0.0, aa = 1.0;

  // order: 2 or 3; rate: λ ≥ 0 [1/s].
  MaternStep(int order, double rate, double dt) noexcept {
    const double u = rate * dt, e = std::exp(-u);
    if (u < 1e-6) {
      xv = dt, xa = 0.5 * dt * dt, va = dt;
    } else if (order == 2) {
      xv = (1.0 - e) / rate, vv = e;
    } else {
      xv = (2.0 - e * (2.0 + u)) / rate, xa = (1.0 - e * (1.0 + u)) / (rate * rate);
      vv = e * (1.0 + u), va = e * dt;
      av = -e * u * rate, aa = e * (1.0 - u);
    }
  }
  AxisState of(const AxisState& s) const noexcept {
    return {s.x + xv * s.v + xa * s.a, vv * s.v + va * s.a, av * s.v + aa * s.a};
  }
};

}  // namespace impedraw
