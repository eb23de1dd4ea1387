// Convex hull of points in the plane, and how far a point is from it.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace impedraw {

// Corners counter-clockwise (Andrew's monotone chain); one or two points where that is all there
// is.
std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points);

// 0 inside. The hull has at least one corner.
double distance_to_hull(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& p);

}  // namespace impedraw
