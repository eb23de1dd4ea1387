// Reads triangle meshes from files, without merging vertices or repairing faults.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

bool is_mesh_file(const std::filesystem::path& file);  // by extension, ignoring case

// Reads an OBJ, STL (text or binary) or PLY (all three formats) file, selected by its extension.
// `unit` is the length of one unit of the file [m]. Faces with more than three corners are
// triangulated; groups and solids are concatenated. Lines, points, colours, normals and materials
// are ignored, and no other file is opened. Throws InputError naming the file and the fault: an
// unreadable, truncated or overlong file, a vertex without three finite numbers, a face with fewer
// than three corners, an index out of range, or no triangle at all.
TriangleMesh read_mesh(const std::filesystem::path& file, double unit);
// `text` is the content of a file named `name`.
TriangleMesh parse_mesh(std::string_view text, const std::string& name, double unit);

}  // namespace impedraw
