#include <fmt/format.h>

#include "impedraw/canvas/mesh_tokens.h"
#include "impedraw/canvas/polygon_mesh.h"
#include "impedraw/common/errors.h"

namespace impedraw {

PolygonMesh parse_off(std::string_view text, const std::string& name) {
  std::string_view line, rest;
  std::size_t number = 0;
  const auto fail = [&](const char* desired) {
    throw InputError(
        fmt::format("{}:{}: '{}', must be {}", name, number, line.substr(0, 60), desired));
  };
  const auto read_line = [&](const char* what, std::size_t i) {  // one that holds something
    do {
      if (!next_line(&text, &line))
        throw InputError(fmt::format("{}: truncated in {} {}", name, what, i));
      ++number;
      rest = line = line.substr(0, line.find('#'));
    } while (next_word(&rest).empty());
    rest = line;
  };
  read_line("line", 0);
  if (next_word(&rest).ends_with("OFF")) {  // or COFF, NOFF, STOFF
    if (std::string_view counts = rest; next_word(&counts).empty()) read_line("header", 0);
  } else {
    rest = line;
  }
  std::size_t vertices, faces, corners;
  if (!whole_number(next_word(&rest), &vertices) || !whole_number(next_word(&rest), &faces))
    fail("OFF, then the numbers of vertices and of faces");
  PolygonMesh mesh;
  for (std::size_t i = 0; i < vertices; ++i) {  // normals and colours follow in the line
    read_line("vertex", i);
    Eigen::Vector3d p;
    for (double& value : p)
      if (!finite_number(next_word(&rest), &value)) fail("three finite numbers");
    mesh.vertices.push_back(p);
  }
  for (std::size_t i = 0; i < faces; ++i) {
    read_line("face", i);
    if (!whole_number(next_word(&rest), &corners)) fail("a number of corners");
    if (corners < 3) continue;  // a point or a line
    for (std::size_t k = 0; k < corners; ++k)
      if (!whole_number(next_word(&rest), &mesh.corners.emplace_back())) fail("whole numbers");
    mesh.ends.push_back(mesh.corners.size());
  }
  return mesh;
}

}  // namespace impedraw
