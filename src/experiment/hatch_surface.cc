#include "impedraw/experiment/hatch_surface.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "impedraw/drawing/polyline.h"
#include "impedraw/planning/cover/surface_grid.h"

namespace impedraw {
namespace {

constexpr double kGridStep = 3e-3, kMostPlaces = 4e4;  // of the grid [m]; asked for
constexpr double kSteepest = 80.0;                     // beyond it is an edge [deg]
constexpr double kRingStep = 1.0 / 3.0;                // of the grid for rings [spacings]
constexpr double kMostRingPlaces = 1e6;
constexpr double kSeedReach = 2.0;  // of seeds from where the distance is 0 [steps]

using Eigen::Vector2d;

// The same surface, about a box.
SurfaceGrid resampled(const SurfaceGrid& grid, Eigen::AlignedBox2d box, double step) {
  box.extend(box.min() - Vector2d::Constant(3 * step));
  box.extend(box.max() + Vector2d::Constant(3 * step));
  const SurfaceHeight heights = [&grid](double x, double y) -> SurfaceHeight::Sample {
    return SurfaceSample{grid.lifted({x, y}), Eigen::Vector3d::UnitZ()};  // slopes do not matter
  };
  return sample_surface(heights, box, step, kSteepest);
}

// Distances to the vertices about a segment in the plane.
void seed(const SurfaceGrid& grid, const Vector2d& a, const Vector2d& b,
          std::vector<double>* seeds) {
  const Vector2d reach = Vector2d::Constant(kSeedReach * grid.step);
  const Vector2d low = (a.cwiseMin(b) - reach - grid.low) / grid.step,
                 high = (a.cwiseMax(b) + reach - grid.low) / grid.step;
  for (int j = std::max(0, static_cast<int>(low.y())); j <= std::min(grid.ny - 1.0, high.y()); ++j)
    for (int i = std::max(0, static_cast<int>(low.x())); i <= std::min(grid.nx - 1.0, high.x());
         ++i) {
      const std::size_t v = grid.index(i, j);
      const Vector2d p = grid.plane(v);
      const Vector2d foot = nearest_on_segment(a, b, p);
      if ((p - foot).norm() <= kSeedReach * grid.step)
        (*seeds)[v] = std::min((*seeds)[v], (grid.point(v) - grid.lifted(foot)).norm());
    }
}

std::vector<HatchLine> rings_on(const SurfaceGrid& surface, const Placement& placement,
                                const Outlines& region, HatchStyle style, double spacing_mm) {
  std::vector<HatchLine> lines;
  Outlines outlines = region;
  for (auto& outline : outlines)
    for (Vector2d& p : outline) p = placement.to_plane(p);
  const Eigen::AlignedBox2d box = outlines_box(outlines);
  if (box.isEmpty()) return lines;
  const double spacing = spacing_mm * placement.scale() / 1e3;  // [m]
  const double step =
      std::max(kRingStep * spacing, std::sqrt(box.sizes().prod() / kMostRingPlaces));
  const SurfaceGrid grid = resampled(surface, box, step);
  std::vector<double> seeds(grid.size(), kFar);
  if (style == HatchStyle::concentric) {
    seed(grid, box.center(), box.center(), &seeds);
  } else {
    for (const auto& outline : outlines)
      for (std::size_t i = 0; i < outline.size(); ++i)
        seed(grid, outline[i], outline[(i + 1) % outline.size()], &seeds);
  }
  const std::vector<double> distance = surface_distance(grid, std::move(seeds));
  const double rows =
      require_few_rows(*std::max_element(distance.begin(), distance.end()), spacing);
  for (double k = 0; k + 0.5 < rows; ++k)
    for (std::vector<Vector2d>& line : level_lines(grid, distance, (k + 0.5) * spacing)) {
      const bool closed = is_closed(line);
      for (Vector2d& p : line) p = placement.to_page(p);
      if (closed) line.back() = line.front();
      lines.push_back({std::move(line), static_cast<std::int64_t>(k)});
    }
  return lines;
}

}  // namespace

HatchSurface hatch_surface(const SurfaceHeight& surface, const Placement& placement,
                           const std::vector<Area>& areas) {
  Eigen::AlignedBox2d box;
  for (const Area& area : areas)
    for (const auto& outline : area.outlines)
      for (const Vector2d& p : outline) box.extend(placement.to_plane(p));
  const double step = std::max(kGridStep, std::sqrt(box.sizes().prod() / kMostPlaces));
  box.extend(box.min() - Vector2d::Constant(2 * step));
  box.extend(box.max() + Vector2d::Constant(2 * step));
  const auto grid =
      std::make_shared<const SurfaceGrid>(sample_surface(surface, box, step, kSteepest));
  HatchSurface on;
  on.distances = [grid, placement, middle = Vector2d(box.center())](const Vector2d& across) {
    const Vector2d rising = (placement.A * across).normalized();
    const auto distance = std::make_shared<const std::vector<double>>(
        distance_across(*grid, middle, {rising.y(), -rising.x()}));
    const double of_middle = across.dot(placement.to_page(middle)), mm = 1e3 / placement.scale();
    return [grid, distance, placement, of_middle, mm](const Vector2d& page_mm) {
      return of_middle + mm * grid->sample(*distance, placement.to_plane(page_mm));
    };
  };
  on.rings = [grid, placement](const Outlines& region, HatchStyle style, double spacing_mm) {
    return rings_on(*grid, placement, region, style, spacing_mm);
  };
  return on;
}

}  // namespace impedraw
