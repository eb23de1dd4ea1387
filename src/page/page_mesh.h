// Meshes with few enough triangles for a page.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

struct PageMesh {
  std::vector<Eigen::Vector3d> vertices{};   // some of those given
  std::vector<Eigen::Vector3i> triangles{};  // into `vertices`
  // Fewer triangles on the same vertices: what a renderer without a graphics card draws. Empty
  // where that saves less than a third of them.
  std::vector<Eigen::Vector3i> coarse{};
  std::size_t of = 0;  // triangles given
  double error = 0.0;  // largest distance to the mesh given, as the method estimates it [m]
};

// Leaves at most about `most` triangles, or all if there are fewer: edges are collapsed where that
// changes the surface least (meshoptimizer); borders stay. A mesh that is still too large by then,
// as one of many loose pieces, is merged on a grid. The coarse ones are within about `off` [m].
PageMesh page_mesh(const std::vector<Eigen::Vector3d>& vertices,
                   const std::vector<Eigen::Vector3i>& triangles, std::size_t most, double off);

// What a page shows of the canvas.
PageMesh canvas_mesh(const std::vector<Eigen::Vector3d>& vertices,
                     const std::vector<Eigen::Vector3i>& triangles);

}  // namespace impedraw
