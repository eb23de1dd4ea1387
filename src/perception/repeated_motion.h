// Prediction of a coordinate that does again what it did before: what followed, whenever it had
// moved as it did lately.
//
// A machine that rests and moves by steps has no spectrum that tells where a step ends. The samples
// x_j of the last kPattern are compared with each piece x'_j of the time before, as it was and
// turned round, both without their means:
//
//   r² = Σ_j (x_j − x̄ − s (x'_j − x̄'))²,   s = ±1,   w = exp(−r² / 4 σ²)
//   x(t) = x̄ + Σ w s (x'(t') − x̄') / Σ w    t': as long after the piece as t after the samples
//
// σ²: the samples' mean variance. Pieces that noise alone may set apart count alike.
//
// Sources: E. N. Lorenz, "Atmospheric Predictability as Revealed by Naturally Occurring Analogues",
// J. Atmos. Sci. 26, 1969; the weights are those of Nadaraya's and Watson's kernel regression.
#pragma once

#include <optional>
#include <span>

#include "impedraw/perception/axis_motion.h"

namespace impedraw {

struct RepeatedMotion {
  static constexpr double kPattern = 0.25;  // [s]
  static constexpr double kSpan = 0.12;     // over which it predicts [s]

  // samples: in order of time. Nothing where they are too few, tell of no motion, or of none like
  // that of late. Allocates nothing.
  static std::optional<AxisPolynomial> predict(std::span<const AxisSample> samples) noexcept;
};

}  // namespace impedraw
