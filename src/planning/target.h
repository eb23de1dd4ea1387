// The line that ought to be drawn: the artwork itself, before rounding, joining or compensation,
// projected along z on the true canvas.
#pragma once

#include <vector>

#include "impedraw/drawing/placement.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

struct TargetLine {
  std::vector<Eigen::Vector3d> points;  // on the canvas, W [m]
  std::vector<int> stroke;              // of each point, rising
};

struct TargetSettings {
  double spacing = 4e-4;  // largest gap within a stroke [m]
  // and chords are halved until their middle is this close to the canvas [m]
  double tolerance = 2e-6;
};

// InputError: a point without canvas beneath it (surface_height.h).
TargetLine project_target(const std::vector<PlacedStroke>& strokes, const SurfaceHeight& canvas,
                          const TargetSettings& settings = {});

}  // namespace impedraw
