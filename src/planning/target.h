// The ideal line: the artwork before rounding, joining or compensation, projected along z onto the
// true canvas.
#pragma once

#include <vector>

#include "impedraw/drawing/placement.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

struct TargetLine {
  std::vector<Eigen::Vector3d> points;  // on the canvas, W [m]
  std::vector<int> stroke;              // stroke of each point, nondecreasing
};

struct TargetSettings {
  double spacing = 4e-4;  // largest gap within a stroke [m]
  // chords are halved until their midpoint is this close to the canvas [m]
  double tolerance = 2e-6;
};

// Throws InputError for a point without canvas below it (surface_height.h).
TargetLine project_target(const std::vector<PlacedStroke>& strokes, const SurfaceHeight& canvas,
                          const TargetSettings& settings = {});

}  // namespace impedraw
