// Built-in rough canvases, for measuring what the pen can follow: a height h(x, y) over a rectangle
// (built_in.h), with a root-mean-square slope s (s = tan of `slope`) and a length λ.
//
// fractal  Σ a_i sin(k_i (x cos β_i + y sin β_i) + φ_i): wavelengths from λ to kLongest, a_i ∝
//          λ_i^0.8 as on a fractal of dimension 2.2, scaled to √(Σ a_i² k_i²/2) = s
// facets   flat triangles over a square grid of side λ; heights at its corners are normally
//          distributed, scaled to s over the surface
// ridges   a zigzag along x of wavelength λ, slopes ±s
// ripple   the top of a cylinder along x, of radius kRippleRadius, with a sine of wavelength λ
//          along it
// step     0 for x < 0, `rise` for x > 0; the wall is kWall wide
// hole     level, with a round hole of diameter λ in the middle
// lip      level; a second sheet `rise` above it, over x > 0, shadows it
//
// Random numbers come from std::mt19937_64(seed), so that a seed gives the same surface on every
// machine, to rounding. Cells are at most λ/4 wide, so that the mesh shows the shape.
#pragma once

#include "impedraw/canvas/built_in.h"

namespace impedraw {

enum class RoughForm { fractal, facets, ridges, ripple, step, hole, lip };

struct RoughSettings {
  static constexpr double kLongest = 0.15, kRippleRadius = 0.2, kWall = 2e-4;  // [m]
  FootprintSettings footprint{.centre = {0.60, 0.0, 0.05}, .width = 0.30, .height = 0.30};
  RoughForm form = RoughForm::fractal;
  int seed = 1;
  double slope_deg = 10.0;    // root mean square
  double wavelength = 0.015;  // λ [m]
  double height = 0.010;      // of a step or lip [m]
};

// Throws InputError naming the setting, its value and what would be valid.
TriangleMesh make_rough(const RoughSettings& settings = {});

}  // namespace impedraw
