// What each pen of a drawing draws, and the flat picture of it (report/preview_picture.h).
#pragma once

#include <string>
#include <vector>

#include "impedraw/experiment/artwork.h"
#include "impedraw/metrics/pens.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/report/preview_picture.h"

namespace impedraw {

// A pen's part of a path, with the ways to its strokes.
struct PenSum {
  std::size_t strokes = 0;
  double length = 0.0, time = 0.0;  // in the drawing plane [mm], [s]
};
std::vector<PenSum> sums_of(const DrawnPens& pens, const std::vector<PlacedStroke>& strokes,
                            const TipPath& path);

// "coast: 2 strokes, 310 mm, 12 s"
std::string pen_text(const DrawnPen& pen, const PenSum& sum);
// The same with its ink: "…; #204080, 0.6 mm wide at 3 N".
std::string ink_text(const DrawnPen& pen, const PenSum& sum);

// `pens`: one for each layer of the artwork, or one for all. Its subtitle is the size as drawn.
PreviewPicture preview_of(const Scenario& scenario, const SettingErrors& setting_errors,
                          const PlacedArtwork& artwork, const std::vector<DrawnPen>& pens,
                          const std::vector<PenSum>& sums);

}  // namespace impedraw
