// Finds where along a stroke the surface can be drawn on.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "impedraw/planning/preflight/preflight.h"

namespace impedraw {

// A part of a stroke with one verdict: either all of it can be drawn on (no problem) or none of it.
// In the drawing frame P.
struct SurfaceSpan {
  double from = 0, to = 0;         // as in StrokePart [m]
  std::optional<Problem> problem;  // off_canvas, fold, too_steep, or too_short between edges
  // no problem: positions of the samples, rising, the first at `from`, the last at `to`
  std::vector<double> along;
  std::vector<SurfaceSample> samples;             // the surface at these positions
  double step = 0;                                // fold: its height [m]
  double slope = 0;                               // steepest [rad]; no problem or too_steep
  double worst = 0;                               // problem: position of the worst point
  Eigen::Vector3d p_P = Eigen::Vector3d::Zero();  // problem: the worst point [m]
  std::string text;                               // problem: description
};

// The spans cover the stroke from start to end without gaps. A fold's span is at most about 10 µm
// long; the surface is known on both sides of it. A dot's span is [start, start].
std::vector<SurfaceSpan> walk_surface(const PlacedStroke& stroke, const SurfaceHeight& surface,
                                      const PreflightSettings& settings);

// The surface along a span without a problem: linear between samples, normals averaged over
// `smoothing` [m].
class SurfaceProfile {
 public:
  SurfaceProfile(const SurfaceSpan& span, double smoothing);
  SurfaceSample at(double along) const;

 private:
  Eigen::Vector3d normal_integral(double along) const;
  std::size_t interval(double along) const;  // index of the sample at the interval's end

  const SurfaceSpan& span_;
  double smoothing_;
  std::vector<Eigen::Vector3d> integral_;  // integral of n from the span's start to each sample [m]
};

}  // namespace impedraw
