// Meshes as files list them, and the readers of the three formats.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

struct PolygonMesh {
  std::vector<Eigen::Vector3d> vertices;  // [file's unit]
  std::vector<int> corners;               // of all faces, one face after another; from 0
  std::vector<std::size_t> ends;          // of each face in `corners`

  std::size_t faces() const { return ends.size(); }
  std::span<const int> face(std::size_t i) const {
    const std::size_t begin = i == 0 ? 0 : ends[i - 1];
    return {corners.data() + begin, ends[i] - begin};
  }
};

// Each throws InputError naming the file (`name`) and the line, vertex or face (from 0): it is cut
// short or runs on, a text holds a vertex without three finite numbers, a face has fewer than three
// corners, an index of an OBJ is out of range. Left for the caller to check: indices of a PLY, and
// whether binary values are finite.
PolygonMesh parse_obj(std::string_view text, const std::string& name);
PolygonMesh parse_stl(std::string_view text, const std::string& name);  // text or binary
PolygonMesh parse_ply(std::string_view text, const std::string& name);  // all three formats

// Triangles of all faces, in their order and wound as they are. A face may have a hollow outline;
// one whose outline crosses itself is cut in some way. InputError: a hollow outline of more than
// 2,000 corners.
std::vector<Eigen::Vector3i> triangulate(const PolygonMesh& mesh, const std::string& name);

}  // namespace impedraw
