// Surfaces in closed form, and strokes on them.
#pragma once

#include <cmath>

#include "impedraw/drawing/placement.h"
#include "impedraw/drawing/shapes.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw::surfaces {

using Eigen::Vector2d;
using Eigen::Vector3d;

inline const Vector3d kBowlCentre{0.60, 0, 0.40};
constexpr double kBowlRadius = 0.30;

inline std::optional<SurfaceSample> bowl(double x, double y) {
  const double r = std::hypot(x - 0.60, y);
  if (r > 0.18) return std::nullopt;
  const Vector3d p(x, y, 0.40 - std::sqrt(kBowlRadius * kBowlRadius - r * r));
  return SurfaceSample{p, (kBowlCentre - p) / kBowlRadius};
}

inline std::optional<SurfaceSample> table(double x, double y) {
  return SurfaceSample{{x, y, 0.1}, Vector3d::UnitZ()};
}

// z = 0.1 + 20 mm sin(40 x) cos(30 y): steep up to 39°.
inline std::optional<SurfaceSample> waves(double x, double y) {
  const double a = 0.02;
  const Vector3d n(-a * 40 * std::cos(40 * x) * std::cos(30 * y),
                   a * 30 * std::sin(40 * x) * std::sin(30 * y), 1);
  return SurfaceSample{{x, y, 0.1 + a * std::sin(40 * x) * std::cos(30 * y)}, n.normalized()};
}

inline std::vector<PlacedStroke> shape(const std::string& name) {
  const Artwork drawn = make_shape(name).drawn;
  return placed_strokes(drawn, place(drawn, shape_placement()));
}

// Accelerations as of a robot rather than a pen plotter.
inline PathSettings brisk() {
  PathSettings settings;
  settings.draw_acceleration = settings.travel_acceleration = 1.0;
  return settings;
}

inline PlacedStroke line(std::vector<Vector2d> world, int number = 0) {
  return {world, world, number};
}

}  // namespace impedraw::surfaces
