// Lays a patch of the surface flat: least-squares conformal map, then as rigid as possible. libigl
// does it, in flatten_patch.py beside this.
#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "impedraw/planning/wrap/surface_patch.h"

namespace impedraw {

// Where each of the patch's vertices goes [m], the centre to the origin; turned anyhow, not
// mirrored. Deterministic. `python` is an interpreter with libigl, empty: the venv that impedraw
// was built with. InputError: the script fails (its last line tells why), or triangles fold over,
// with the place of the first one in the drawing plane.
std::vector<Eigen::Vector2d> flatten_patch(const SurfacePatch& patch,
                                           const std::filesystem::path& python = {});

}  // namespace impedraw
