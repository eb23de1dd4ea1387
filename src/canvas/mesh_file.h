// Triangle meshes from files, as they stand there: neither merged nor repaired.
#pragma once

#include <filesystem>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// An OBJ, STL (text or binary) or PLY; `unit` is the length of one unit of the file [m]. Read by
// Assimp, in single precision; faces with more than three corners are cut into triangles, groups
// and solids follow one another. Lines, points, colours, normals and materials are left aside, and
// no other file is opened. Throws InputError naming the file and the fault: all of
// validate_mesh_file, an index out of range, no triangle at all, or what Assimp says.
TriangleMesh read_mesh(const std::filesystem::path& file, double unit);

}  // namespace impedraw
