// The header of a PLY file, of a mesh or of a cloud.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace impedraw {

struct PlyProperty {
  std::string_view name;
  int count_size = 0;  // bytes of a list's count; 0: not a list
  bool count_signed = false;
  int size = 0;        // bytes
  bool whole = false;  // not a float
  bool has_sign = false;
};

struct PlyElement {
  std::string_view name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  enum class Format { text, little_endian, big_endian } format = Format::text;
  std::vector<PlyElement> elements;
};

// Removes the header from the front of `text`, which the names refer to. Throws InputError naming
// the file `name`, the line and the fault.
PlyHeader read_ply_header(std::string_view* text, const std::string& name);

}  // namespace impedraw
