#include "impedraw/experiment/hatch_distances.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "impedraw/planning/cover/surface_grid.h"

namespace impedraw {

SurfaceDistances hatch_distances(const SurfaceHeight& surface, const Placement& placement,
                                 const std::vector<Area>& areas) {
  constexpr double kStep = 3e-3, kMostPlaces = 4e4;  // of the grid [m]; asked for
  constexpr double kSteepest = 80.0;                 // beyond it is an edge [deg]
  using Eigen::Vector2d;
  Eigen::AlignedBox2d box;
  for (const Area& area : areas)
    for (const auto& outline : area.outlines)
      for (const Vector2d& p : outline) box.extend(placement.to_plane(p));
  const double step = std::max(kStep, std::sqrt(box.sizes().prod() / kMostPlaces));
  box.extend(box.min() - Vector2d::Constant(2 * step));
  box.extend(box.max() + Vector2d::Constant(2 * step));
  const auto grid =
      std::make_shared<const SurfaceGrid>(sample_surface(surface, box, step, kSteepest));
  return [grid, placement, middle = Vector2d(box.center())](const Vector2d& across) {
    const Vector2d rising = (placement.A * across).normalized();
    const auto distance = std::make_shared<const std::vector<double>>(
        distance_across(*grid, middle, {rising.y(), -rising.x()}));
    const double of_middle = across.dot(placement.to_page(middle)), mm = 1e3 / placement.scale();
    return [grid, distance, placement, of_middle, mm](const Vector2d& page_mm) {
      return of_middle + mm * grid->sample(*distance, placement.to_plane(page_mm));
    };
  };
}

}  // namespace impedraw
