// Capsules around the triangles of a link's body: for the clearance, the cameras and the contact,
// which know bodies of no other shape.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

struct Capsule {  // all points within `radius` of the segment a–b
  Eigen::Vector3d a, b;
  double radius;  // [m]
  double volume() const;
};

using Triangle = std::array<Eigen::Vector3d, 3>;

// At most four capsules, each of which holds whole triangles; all are held. A body is cut in halves
// across its longest axis where that leaves less than 0.8 of the volume.
std::vector<Capsule> enclosing_capsules(const std::vector<Triangle>& triangles);

// The triangles of an STL, Collada, OBJ or PLY file, in the file's axes [m]; a Collada file's unit
// is applied. Throws InputError.
std::vector<Triangle> read_triangles(const std::filesystem::path& file);
std::vector<Triangle> box_triangles(const Eigen::Vector3d& edges);

}  // namespace impedraw
