// A stroke laid on the surface: where there is one that can be drawn on.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "impedraw/planning/preflight/preflight.h"

namespace impedraw {

// A stretch of a stroke over which the answer is the same: all can be drawn on (no problem), or
// none. In the drawing frame P.
struct SurfaceSpan {
  double from = 0, to = 0;         // as StrokePart's [m]
  std::optional<Problem> problem;  // off_canvas, fold, too_steep, or too_short between edges
  std::vector<double>
      along;  // no problem: places of the samples, rising, the first at `from`, the last at `to` …
  std::vector<SurfaceSample> samples;             // … and the surface there
  double slope = 0;                               // steepest [rad]; no problem or too_steep
  double worst = 0;                               // a problem: place of the worst …
  Eigen::Vector3d p_P = Eigen::Vector3d::Zero();  // … point there …
  std::string text;                               // … and what of it
};

// Without gaps from the stroke's start to its end. A fold's span is at most some 10 µm long: the
// surface is known on both sides of it. A dot's is [start, start].
std::vector<SurfaceSpan> walk_surface(const PlacedStroke& stroke, const SurfaceHeight& surface,
                                      const PreflightSettings& settings);

// Surface along a span without a problem; linear between samples, normals averaged over `smoothing`
// [m].
class SurfaceProfile {
 public:
  SurfaceProfile(const SurfaceSpan& span, double smoothing);
  SurfaceSample at(double along) const;

 private:
  Eigen::Vector3d normal_integral(double along) const;
  std::size_t interval(double along) const;  // index of the sample that it ends at

  const SurfaceSpan& span_;
  double smoothing_;
  std::vector<Eigen::Vector3d> integral_;  // of n over the span, to each sample [m]
};

}  // namespace impedraw
