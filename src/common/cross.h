#pragma once

#include <Eigen/Core>

namespace impedraw {

// The third component of a × b: twice the signed area of the triangle 0, a, b.
inline double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace impedraw
