// What a slope does to the page's lengths, projected and wrapped: two maps of the patch side by
// side, seen along the drawing axis (up is the plane's +x, right its −y), coloured by the largest
// error of length in any direction, max(|σ₁ − 1|, |σ₂ − 1|) (planning/distortion.h), the strokes
// over it, one colour bar for both.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "impedraw/planning/wrap/distortion.h"

namespace impedraw {

struct DistortionPicture {
  std::string title;
  const FlatChart& chart;                      // whose patch is shown
  const std::vector<PlacedStroke>& projected;  // in the drawing plane: the strokes as placed
  const std::vector<PlacedStroke>& wrapped;    // and as Wrap::wrap took them there
  Distortion of_projected, of_wrapped;  // over the strokes; its numbers stand beneath each map
  int png_width = 1600;                 // [px]
};

// Writes `stem`.svg, one unit a millimetre, and `stem`.png. Throws std::runtime_error naming the
// file when it cannot be written.
void write_distortion(const DistortionPicture& picture, const std::filesystem::path& stem);

}  // namespace impedraw
