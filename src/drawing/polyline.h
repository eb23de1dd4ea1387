// Flat polylines: what a stroke is before it is laid on the surface.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace impedraw {

double length(const std::vector<Eigen::Vector2d>& line);

// Distance of p to the part of the line between its vertices first and last.
double distance(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& line,
                std::size_t first, std::size_t last);

// Indices of the vertices that are left when those within `tolerance` of the rest are dropped
// (Douglas and Peucker); the ends stay.
std::vector<std::size_t> simplified(const std::vector<Eigen::Vector2d>& line, double tolerance);

// Indices into the line where it turns by more than `angle` [rad]; consecutive points differ.
std::vector<std::size_t> corners(const std::vector<Eigen::Vector2d>& line, double angle);

}  // namespace impedraw
