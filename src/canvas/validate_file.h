// What an importer reads past in silence, found before it reads: a file cut short, a number that is
// none, a face without corners.
#pragma once

#include <cstddef>
#include <filesystem>

namespace impedraw {

bool is_mesh_file(const std::filesystem::path& file);  // by its name's ending, in capitals or not

// The number of faces that an OBJ, STL (text or binary) or PLY (any of its three formats) holds;
// which of them is told from the name's ending. Throws InputError naming the file and the line,
// vertex or face (from 0): the file cannot be read, its name ends otherwise, it is cut short or
// runs on, it holds a vertex without three finite numbers (text files) or a face with fewer than
// three corners, an index of an OBJ is out of range. Not looked at, as importers hand them on:
// indices of a PLY, and values in binary files.
std::size_t validate_mesh_file(const std::filesystem::path& file);

}  // namespace impedraw
