// Polygon meshes as listed in files, and the parsers of the formats.
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
  std::vector<int> corners;               // vertex indices of all faces in turn, from 0
  std::vector<std::size_t> ends;          // end of each face in `corners`
  double unit = 0.0;                      // [m], as the file says; 0: it says nothing
  bool y_up = false;                      // the file's format has its y axis up
  std::vector<std::string> warnings;      // one line each

  std::size_t faces() const { return ends.size(); }
  std::span<const int> face(std::size_t i) const {
    const std::size_t begin = i == 0 ? 0 : ends[i - 1];
    return {corners.data() + begin, ends[i] - begin};
  }
};

// Each throws InputError naming the file (`name`) and the line, vertex or face (from 0): truncated
// data, a text vertex without three finite numbers, a face with fewer than three corners, or an OBJ
// index out of range. The caller checks the other indices and whether binary values are finite.
PolygonMesh parse_obj(std::string_view text, const std::string& name);
PolygonMesh parse_stl(std::string_view text, const std::string& name);  // text or binary
PolygonMesh parse_ply(std::string_view text, const std::string& name);  // all three formats
PolygonMesh parse_off(std::string_view text, const std::string& name);  // text
// glb, gltf, 3mf and dae (read_scene.cc): all meshes where the scene's nodes place them. Assimp
// parses them in a process of its own, which may use 60 s and 4 GiB. A glTF's buffers are read from
// the folder of `name` and below.
PolygonMesh parse_scene(std::string_view text, const std::string& name);

// Triangulates all faces, keeping their order and winding. A face may be non-convex; one whose
// outline crosses itself is cut arbitrarily. InputError: a non-convex outline of more than 2,000
// corners.
std::vector<Eigen::Vector3i> triangulate(const PolygonMesh& mesh, const std::string& name);

}  // namespace impedraw
