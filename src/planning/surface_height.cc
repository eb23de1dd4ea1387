#include "impedraw/planning/surface_height.h"

#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace impedraw {
namespace {

using Eigen::Vector2d;
constexpr double kSearched = 0.5;  // [m]
constexpr double kRing = 0.005;    // [m]
constexpr int kDirections = 36;    // the distance is at most 0.4 % too large
constexpr double kNearer = 1e-4;   // a ray counts that meets the surface by so much earlier [m]

bool has(const SurfaceHeight& surface, const Vector2d& p) {
  return surface(p.x(), p.y()).has_value();
}

}  // namespace

// Finds the first circle that meets the surface, then bisects along those of its rays that meet it
// before the others.
std::optional<double> distance_off(const SurfaceHeight& surface, const Vector2d& p,
                                   double searched) {
  for (double r = kRing; r <= searched; r += kRing) {
    double nearest = r + 1;
    for (int i = 0; i < kDirections; ++i) {
      const Vector2d ray(std::cos(2 * std::numbers::pi * i / kDirections),
                         std::sin(2 * std::numbers::pi * i / kDirections));
      double without = r - kRing, with = std::min(r, nearest - kNearer);
      if (with <= without || !has(surface, p + with * ray)) continue;
      for (int k = 0; k < 12; ++k)
        (has(surface, p + (without + with) / 2 * ray) ? with : without) = (without + with) / 2;
      nearest = std::min(nearest, with);
    }
    if (nearest <= r) return nearest;
  }
  return std::nullopt;
}

SurfaceSample sample_or_throw(const SurfaceHeight& surface, const Vector2d& p,
                              const Vector2d& page_mm, int stroke, SurfaceHeight::Sample& last) {
  if (const SurfaceHeight::Sample sample = surface(p.x(), p.y(), last)) return *sample;
  const std::optional<double> off = distance_off(surface, p, kSearched);
  throw OffSurface(
      fmt::format(
          "stroke {} leaves the canvas at page ({:.2f}, {:.2f}) mm, world ({:.4f}, {:.4f}) m, {}",
          stroke, page_mm.x(), page_mm.y(), p.x(), p.y(),
          off ? fmt::format("{:.1f} mm off it", 1e3 * *off)
              : fmt::format("more than {:.0f} mm off it", 1e3 * kSearched)),
      stroke, p);
}

}  // namespace impedraw
