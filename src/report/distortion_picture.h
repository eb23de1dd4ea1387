// Picture of the length distortion of a projected and a wrapped drawing. Two maps show the patch
// side by side, seen along the drawing axis (up is the plane's +x, right its −y), with the strokes
// on top. The colour is the largest length error in any direction, max(|σ₁ − 1|, |σ₂ − 1|)
// (planning/distortion.h). Both maps share one colour bar.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "impedraw/planning/wrap/distortion.h"

namespace impedraw {

struct DistortionPicture {
  std::string title;
  const FlatChart& chart;                      // chart of the patch shown
  const std::vector<PlacedStroke>& projected;  // strokes as placed in the drawing plane
  const std::vector<PlacedStroke>& wrapped;    // strokes after Wrap::wrap, in the drawing plane
  Distortion of_projected, of_wrapped;         // over the strokes; printed below each map
  int png_width = 1600;                        // [px]
};

// Writes `stem`.svg (one unit per millimetre) and `stem`.png. Throws std::runtime_error naming the
// file if it cannot be written.
void write_distortion(const DistortionPicture& picture, const std::filesystem::path& stem);

}  // namespace impedraw
