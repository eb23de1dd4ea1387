// Reduces the number of points of lines for display. Private to src/report.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

using Line2d = std::vector<Eigen::Vector2d>;

// Removes points that lie within `tolerance` of the remaining line; the ends stay. Works in one
// pass. From the last kept point, it intersects the wedges of directions that pass each following
// point within the tolerance. A point nearer than its predecessor ends the search, so a line that
// turns back keeps its tip.
Line2d decimated(const Line2d& line, double tolerance);

// Decimates all lines with one tolerance: the smallest finest · 2^(k/2) that leaves at most `most`
// points in total. Stops at about 200 times the finest. Returns the tolerance.
double decimate_to(std::vector<Line2d>& lines, double finest, std::size_t most);

}  // namespace impedraw
