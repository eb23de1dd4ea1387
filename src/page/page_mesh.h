// A mesh with few enough triangles for a page.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace impedraw {

struct PageMesh {
  std::vector<Eigen::Vector3d> vertices;   // some of those given
  std::vector<Eigen::Vector3i> triangles;  // into `vertices`
  double error = 0.0;  // largest distance to the mesh given, as the method estimates it [m]
};

// Leaves at most about `most` triangles, or all if there are fewer: edges are collapsed where that
// changes the surface least (meshoptimizer); borders stay. A mesh that is still too large by then,
// as one of many loose pieces, is merged on a grid.
PageMesh page_mesh(const std::vector<Eigen::Vector3d>& vertices,
                   const std::vector<Eigen::Vector3i>& triangles, std::size_t most);

// Fewer triangles on the same vertices, within about `off` [m] of the mesh: what a renderer without
// a graphics card draws. Empty where that saves less than a third of them.
std::vector<Eigen::Vector3i> coarse_triangles(const PageMesh& mesh, double off);

}  // namespace impedraw
