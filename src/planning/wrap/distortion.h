// How much lengths, areas and angles of the page change on the surface, when the page is projected
// along −z and when it is wrapped.
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
  double angle()
      // by how much the angle between two directions changes at most: 2 asin((σ₁ − σ₂) / (σ₁ + σ₂))
      // [rad]
      const;
  double length_error() const;  // max(|σ₁ − 1|, |σ₂ − 1|)
};

LocalStretch stretch_of_projection(const SurfaceSample& sample);
LocalStretch stretch_of_wrap(const SurfaceSample& sample,
                             const FlatChart& chart);  // the sample lies on the chart's patch

// Over strokes: stretch along the strokes, from chords of at most 0.5 mm, weighted by page length;
// area and angles at the chords' middles. Over a patch: stretch in all directions at its vertices
// (rms over σ₁ and σ₂), weighted by page area.
struct Distortion {
  double stretch_min = 1, stretch_max = 1;  // surface length / page length
  double stretch_rms = 0;                   // rms of its deviation from 1
  double area_min = 1, area_max = 1;        // surface area / page area
  double angle_max = 0;                     // [rad]
  // that was measured, without what lies off the surface or off the patch [m]; 0 over a patch
  double page_length = 0;
};

// `strokes` are flat, that is as placed. Without anything to measure: no distortion, page_length 0.
Distortion distortion_of_projection(const std::vector<PlacedStroke>& strokes,
                                    const SurfaceHeight& surface);
Distortion distortion_of_wrap(const std::vector<PlacedStroke>& strokes,
                              const SurfaceHeight& surface, const FlatChart& chart);

Distortion patch_distortion_of_projection(const SurfacePatch& patch);
Distortion patch_distortion_of_wrap(const FlatChart& chart);

}  // namespace impedraw
