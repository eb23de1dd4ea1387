// Fewer points for lines that are to be seen, not measured. Private to src/report.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

using Line2d = std::vector<Eigen::Vector2d>;

// The line without points that lie within `tolerance` of what is left; its ends stay. One pass:
// from the last point that was kept the next is looked for within the wedge of directions that pass
// every point between within the tolerance (a point nearer than one before it ends the search, so a
// line that turns back keeps its tip).
Line2d decimated(const Line2d& line, double tolerance);

// Thins all with one tolerance, the least of finest · 2^(k/2) with which no more than `most` points
// are left in all; gives up at some 200 times the finest. Returns the tolerance.
double decimate_to(std::vector<Line2d>& lines, double finest, std::size_t most);

}  // namespace impedraw
