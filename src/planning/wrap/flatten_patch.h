// Flattens a patch of the surface: least-squares conformal map, then as-rigid-as-possible. Uses
// libigl through flatten_patch.py in this folder.
#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "impedraw/planning/wrap/surface_patch.h"

namespace impedraw {

// Returns the flat position of each of the patch's vertices [m]. The centre goes to the origin. The
// rotation is arbitrary; the map is not mirrored. Deterministic. `python` is an interpreter with
// libigl; if empty, the venv that impedraw was built with. Throws InputError if the script fails
// (with the script's last line). Triangles may fold over (folded_triangles).
std::vector<Eigen::Vector2d> flatten_patch(const SurfacePatch& patch,
                                           const std::filesystem::path& python = {});

// The triangles that fold over in the flat positions or are stretched there more than fourfold,
// ascending.
std::vector<int> folded_triangles(const SurfacePatch& patch,
                                  const std::vector<Eigen::Vector2d>& flat);

}  // namespace impedraw
