// Surfaces and strokes that several tests of the wrap share.
#pragma once

#include <functional>
#include <numbers>
#include <vector>

#include "planning/surfaces.h"

namespace impedraw::surfaces {

// z(x, y) everywhere, normals by central differences.
inline SurfaceHeight height_field(const std::function<double(double, double)>& z) {
  return [z](double x, double y) -> std::optional<SurfaceSample> {
    const double d = 1e-6;
    const Vector3d n(-(z(x + d, y) - z(x - d, y)) / (2 * d), -(z(x, y + d) - z(x, y - d)) / (2 * d),
                     1);
    return SurfaceSample{{x, y, z(x, y)}, n.normalized()};
  };
}

inline PlacedStroke circle(const Vector2d& centre, double radius) {
  std::vector<Vector2d> points;
  for (int k = 0; k <= 72; ++k)
    points.push_back(centre + radius * Vector2d(std::cos(k * std::numbers::pi / 36),
                                                std::sin(k * std::numbers::pi / 36)));
  return line(points);
}

}  // namespace impedraw::surfaces
