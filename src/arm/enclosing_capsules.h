// Capsules around a link's body: clearance, cameras and contact know no other shapes but cylinders
// and spheres.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

struct Capsule {  // all points within `radius` of the segment a–b [m]
  Eigen::Vector3d a, b;
  double radius;
};

using Triangle = std::array<Eigen::Vector3d, 3>;

// At most four; each triangle lies in one of them. A body is cut in halves across its longest
// principal axis where that leaves less than 0.8 of the volume.
std::vector<Capsule> enclosing_capsules(const std::vector<Triangle>& triangles, int cuts = 2);

// The triangles of an STL, Collada, OBJ or PLY file, in its axes; a Collada file's unit is applied.
// Throws InputError.
std::vector<Triangle> read_triangles(const std::filesystem::path& file);

}  // namespace impedraw
