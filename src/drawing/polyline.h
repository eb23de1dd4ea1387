// Flat polylines: strokes before they are mapped to the surface.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace impedraw {

double length(const std::vector<Eigen::Vector2d>& line);

// The point of the segment from a to b that is nearest to p.
Eigen::Vector2d nearest_on_segment(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                                   const Eigen::Vector2d& p);

// Distance from p to the part of the line between vertices `first` and `last`.
double distance(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& line,
                std::size_t first, std::size_t last);

// Indices of the vertices that remain after dropping those within `tolerance` of the rest
// (Douglas and Peucker). The ends stay.
std::vector<std::size_t> simplified(const std::vector<Eigen::Vector2d>& line, double tolerance);

// Turn of the line at its inner vertex i, counter-clockwise, within ± π [rad].
double turn_at(const std::vector<Eigen::Vector2d>& line, std::size_t i);

// Indices of the vertices where the line turns by more than `angle` [rad]. Precondition:
// consecutive points differ.
std::vector<std::size_t> corners(const std::vector<Eigen::Vector2d>& line, double angle);

}  // namespace impedraw
