// The angle between two vectors.
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

// 0 … π [rad], of any lengths above 0. Exact for small angles and near π, where acos of the cosine
// is not.
inline double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace impedraw
