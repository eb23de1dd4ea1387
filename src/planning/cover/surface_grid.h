// Distances along a surface, on a square grid of heights over the drawing plane.
//
//   |∇_S T| = 1,  T = T_0 at the seeds             eikonal equation on the surface
//
// Each vertex takes its distance through the eight triangles around it, as a plane wave crosses
// them; sweeps in four orders repeat until nothing changes. First order in the step. Level sets of
// T are equally spaced on the surface, on whatever slope.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/planning/surface_height.h"

namespace impedraw {

struct SurfaceGrid {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();  // of vertex (0, 0), in P [m]
  double step = 0.0;                              // [m]
  int nx = 0, ny = 0;
  std::vector<double> z;     // heights [m]; where there is no surface, continued smoothly
  std::vector<char> known;   // there is a surface, no steeper than allowed
  std::vector<double> area;  // of the surface about each vertex, by its normal; 0 without one [m²]
  std::vector<double> unsure;  // by how much it may lie off, along its normal; empty: not [m]

  std::size_t size() const { return z.size(); }
  std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(i);
  }
  int i_of(std::size_t v) const { return static_cast<int>(v % static_cast<std::size_t>(nx)); }
  int j_of(std::size_t v) const { return static_cast<int>(v / static_cast<std::size_t>(nx)); }
  Eigen::Vector2d plane(std::size_t v) const {
    return low + step * Eigen::Vector2d(i_of(v), j_of(v));
  }
  Eigen::Vector3d point(std::size_t v) const {
    const Eigen::Vector2d p = plane(v);
    return {p.x(), p.y(), z[v]};
  }
  Eigen::Vector2d slope(std::size_t v) const;  // ∇z
  // Bilinear in a field of the grid; outside: of the nearest place on its border.
  double sample(const std::vector<double>& field, const Eigen::Vector2d& p) const;
  Eigen::Vector3d lifted(const Eigen::Vector2d& p) const { return {p.x(), p.y(), sample(z, p)}; }
};

// Asks for the surface over `box` [m]. `progress`: told the share that is done.
SurfaceGrid sample_surface(const SurfaceHeight& surface, const Eigen::AlignedBox2d& box,
                           double step, double max_slope_deg,
                           const std::function<void(double)>& progress = {});
// The same vertices, seen from above, on another surface.
SurfaceGrid same_places(const SurfaceGrid& grid, const SurfaceHeight& surface,
                        double max_slope_deg);

inline constexpr double kFar = std::numeric_limits<double>::infinity();

// T of every vertex [m]; `seeds`: T_0, infinite where there is none.
std::vector<double> surface_distance(const SurfaceGrid& grid, std::vector<double> seeds);

// Distance to the nearest vertex's cell that is not `inside` [m]; 0 outside. Half a step is given
// away, so that it is rather too small.
std::vector<double> distance_to_edge(const SurfaceGrid& grid, const std::vector<char>& inside);

// Signed distance from the line through `middle` along `direction` (unit), drawn on the surface;
// positive to its left.
std::vector<double> distance_across(const SurfaceGrid& grid, const Eigen::Vector2d& middle,
                                    const Eigen::Vector2d& direction);

// The lines on which a field has this value, in the plane; closed ones repeat their first point.
std::vector<std::vector<Eigen::Vector2d>> level_lines(const SurfaceGrid& grid,
                                                      const std::vector<double>& field,
                                                      double level);

inline bool is_closed(const std::vector<Eigen::Vector2d>& line) {
  return (line.front() - line.back()).norm() < 1e-9;
}

// Visits the vertices whose surface point lies within `radius` of p.
template <class Visit>
void around(const SurfaceGrid& grid, const Eigen::Vector3d& p, double radius, Visit&& visit) {
  const auto range = [&](double x, double low, int n, int* from, int* to) {
    *from = std::max(0, static_cast<int>(std::ceil((x - radius - low) / grid.step)));
    *to = std::min(n - 1, static_cast<int>(std::floor((x + radius - low) / grid.step)));
  };
  int i0, i1, j0, j1;
  range(p.x(), grid.low.x(), grid.nx, &i0, &i1);
  range(p.y(), grid.low.y(), grid.ny, &j0, &j1);
  for (int j = j0; j <= j1; ++j)
    for (int i = i0; i <= i1; ++i) {
      const std::size_t v = grid.index(i, j);
      if ((grid.point(v) - p).squaredNorm() <= radius * radius) visit(v);
    }
}

}  // namespace impedraw
