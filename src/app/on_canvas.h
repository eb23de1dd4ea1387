// Does all of the drawing lie on the canvas, seen along −z, and within the arm's reach there?
#pragma once

#include <functional>
#include <vector>

#include "canvas/triangle_mesh.h"
#include "drawing/placement.h"
#include "planning/surface_height.h"

namespace impedraw {

// Looks every millimetre along each stroke. InputError at the first stroke that leaves the canvas: which one, where it is farthest off, and
// by how much. `canvas` is the height of `mesh`.
void require_on_canvas(const std::vector<PlacedStroke>& strokes, const TriangleMesh& mesh, const SurfaceHeight& canvas);

// Asks every centimetre along each stroke, with the pen along the canvas's normal or, `vertical_pen`, along −z. InputError at the first
// stroke that the arm cannot reach: which one, where it is farthest, and by how much. The strokes lie on the canvas.
// `short_of`: how far short of a point the tip stays [m]; 0 where it gets there. The ways in between are planning/reach.h's to check.
using ShortOf = std::function<double(const Eigen::Vector3d& p_WD, const Eigen::Vector3d& n_W)>;
void require_strokes_in_reach(const std::vector<PlacedStroke>& strokes, const SurfaceHeight& canvas, bool vertical_pen,
                              const ShortOf& short_of);

}  // namespace impedraw
