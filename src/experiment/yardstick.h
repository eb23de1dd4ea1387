// What a drawing is judged against, as data for the log and the metrics. The loop does not read it.
#pragma once

#include <memory>

#include "impedraw/canvas/triangle_mesh.h"
#include "impedraw/metrics/promise.h"
#include "impedraw/planning/target.h"

namespace impedraw {

class Canvas;

struct Yardstick {
  TargetLine target;                      // the promised strokes on the true canvas, in W
  TriangleMesh canvas;                    // the true one, as the run begins, in W
  std::shared_ptr<const Canvas> surface;  // the same, to be searched
  bool canvas_moves = false;
  Promise promise;
};

}  // namespace impedraw
