// Convex hull of points in the plane, and the distance of a point from it.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace impedraw {

// Returns the corners counter-clockwise (Andrew's monotone chain). Degenerate input gives one or
// two points.
std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points);

// 0 inside. The hull must have at least one corner.
double distance_to_hull(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& p);

}  // namespace impedraw
