// A surface made of triangles.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace impedraw {

// Triangles index vertices and are wound so that the right-hand normal, (v1 − v0) × (v2 − v0),
// points outward, to the drawing side.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;   // [m], world frame W
  std::vector<Eigen::Vector3i> triangles;  // 0-based
};

}  // namespace impedraw
