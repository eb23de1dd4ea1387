// Triangle meshes from files, as they stand there: neither merged nor repaired.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

bool is_mesh_file(const std::filesystem::path& file);  // by its name's ending, in capitals or not

// An OBJ, STL (text or binary) or PLY (any of its three formats), told by the name's ending; `unit`
// is the length of one unit of the file [m]. Faces with more than three corners are cut into
// triangles; groups and solids follow one another. Lines, points, colours, normals and materials
// are left aside, and no other file is opened. Throws InputError naming the file and the fault: the
// file cannot be read, is cut short or runs on, a vertex without three finite numbers, a face with
// fewer than three corners, an index out of range, no triangle at all.
TriangleMesh read_mesh(const std::filesystem::path& file, double unit);
// `text` stands for a file named `name`.
TriangleMesh parse_mesh(std::string_view text, const std::string& name, double unit);

}  // namespace impedraw
