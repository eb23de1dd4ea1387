// Distortion of the page's lengths, areas and angles on the surface, for projection along −z and
// for wrapping.
//
// With J = d flat / d plane and the surface's metric G = I + ∇h ∇hᵀ above a point of the drawing
// plane (∇h = −(n_x, n_y) / n_z), a page direction t is stretched by |G^½ J⁻¹ t|; J = I for the
// projection. σ₁ ≥ σ₂ are the singular values of G^½ J⁻¹.
#pragma once

#include <vector>

#include "impedraw/drawing/placement.h"
#include "impedraw/planning/surface_height.h"
#include "impedraw/planning/wrap/flat_chart.h"

namespace impedraw {

struct LocalStretch {
  double largest = 1, smallest = 1;  // σ₁, σ₂: surface length per page length

  double area() const { return largest * smallest; }
  // Largest change of the angle between two directions: 2 asin((σ₁ − σ₂) / (σ₁ + σ₂)) [rad].
  double angle() const;
  double length_error() const;  // max(|σ₁ − 1|, |σ₂ − 1|)
};

LocalStretch stretch_of_projection(const SurfaceSample& sample);
// The sample must lie on the chart's patch.
LocalStretch stretch_of_wrap(const SurfaceSample& sample, const FlatChart& chart);

// Over strokes: stretch along the strokes, from chords of at most 0.5 mm, weighted by page length.
// Area and angles are taken at the chord midpoints.
struct Distortion {
  double stretch_min = 1, stretch_max = 1;  // surface length / page length
  double stretch_rms = 0;                   // rms of its deviation from 1
  double area_min = 1, area_max = 1;        // surface area / page area
  double angle_max = 0;                     // [rad]
  // measured length, excluding parts off the surface or off the patch [m]
  double page_length = 0;
};

// `strokes` are flat, as placed. If there is nothing to measure, the result has no distortion and
// page_length 0.
Distortion distortion_of_projection(const std::vector<PlacedStroke>& strokes,
                                    const SurfaceHeight& surface);
Distortion distortion_of_wrap(const std::vector<PlacedStroke>& strokes,
                              const SurfaceHeight& surface, const FlatChart& chart);

}  // namespace impedraw
