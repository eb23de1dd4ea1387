// Distances between hatch lines, measured on surfaces in closed form.
#include "impedraw/experiment/artwork.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/core.h>
#include <gtest/gtest.h>

#include "impedraw/drawing/hatch.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

using Height = double (*)(double x, double y);

SurfaceHeight surface_of(Height z) {
  return [z](double x, double y) -> SurfaceHeight::Sample {
    constexpr double h = 1e-6;
    const Vector3d n((z(x - h, y) - z(x + h, y)) / (2 * h), (z(x, y - h) - z(x, y + h)) / (2 * h),
                     1.0);
    return SurfaceSample{Vector3d(x, y, z(x, y)), n.normalized()};
  };
}

// Slopes of up to 45°, but for the dome's 27°.
const std::vector<std::pair<const char*, Height>> kSurfaces = {
    {"slope", [](double x, double) { return x - 0.6; }},
    {"across", [](double, double y) { return 0.7 * y; }},
    {"wave", [](double x, double) { return 0.04 * std::sin((x - 0.57) / 0.04); }},
    {"hills",
     [](double x, double y) {
       return 0.035 * std::sin((x - 0.58) / 0.035) * std::cos((y - 0.01) / 0.035);
     }},
    {"dome", [](double x, double y) {
       const double r2 = (x - 0.6) * (x - 0.6) + y * y;
       return std::sqrt(0.1 * 0.1 - std::min(r2, 0.006));
     }}};

// To the next line on the left, relative to the spacing, sorted: from places of a ring about the
// drawing's middle.
std::vector<double> spacings(const std::vector<Stroke>& lines, const Placement& placement, Height z,
                             double spacing, double radius, double hole = 0) {
  struct Place {
    Vector3d p;
    Vector2d along;
  };
  std::vector<std::vector<Place>> laid;
  for (const Stroke& line : lines) {
    laid.emplace_back();
    for (std::size_t k = 1; k < line.points.size(); ++k) {
      const Vector2d a = placement.to_plane(line.points[k - 1]),
                     b = placement.to_plane(line.points[k]);
      const int steps = std::max(1, static_cast<int>((b - a).norm() / 2e-4));
      for (int i = 0; i < steps; ++i) {
        const Vector2d p = a + (b - a) * i / steps;
        laid.back().push_back({{p.x(), p.y(), z(p.x(), p.y())}, b - a});
      }
    }
  }
  std::vector<double> found;
  for (const auto& line : laid)
    for (std::size_t i = 0; i < line.size(); i += 100) {
      const double from_middle = (line[i].p.head<2>() - placement.centre_m).norm();
      if (from_middle > radius || from_middle < hole) continue;
      double nearest = 4.0;
      for (const auto& other : laid) {
        if (&other == &line) continue;
        for (const Place& there : other) {
          const Vector3d way = there.p - line[i].p;
          const bool left = line[i].along.x() * way.y() > line[i].along.y() * way.x();
          if (left) nearest = std::min(nearest, way.norm() / spacing);
        }
      }
      found.push_back(nearest);
    }
  std::sort(found.begin(), found.end());
  return found;
}

TEST(HatchSurface, LinesAreEvenOnSlopesOf45Degrees) {
  const Area square{{{{0, 0}, {120, 0}, {120, 120}, {0, 120}}}, false, 0};
  Artwork artwork;
  artwork.areas = {square};
  PlacementSettings settings;
  settings.scale = 0.9;
  settings.rotate_deg = 20;
  const Placement placement = place(artwork, settings);
  for (const auto& [name, z] : kSurfaces) {
    const HatchSurface distances = hatch_surface(surface_of(z), placement, artwork.areas);
    double widest = 0;
    for (const double angle : {0.0, 45.0, 110.0}) {
      SCOPED_TRACE(fmt::format("{} {}", name, angle));
      const HatchSettings hatch{.spacing_mm = 2, .angle_deg = angle};
      const auto measured = [&](const HatchSurface& by) {
        return spacings(hatch_lines(square, hatch, placement.scale(), by), placement, z, 2e-3,
                        0.045);
      };
      const std::vector<double> even = measured(distances), flat = measured({});
      ASSERT_GT(even.size(), 100u);
      fmt::print("{:6} {:3}: {:.3f} to {:.3f}; of the page {:.3f} to {:.3f}\n", name, angle,
                 even.front(), even.back(), flat.front(), flat.back());
      EXPECT_GT(even.front(), 0.95);
      EXPECT_LT(even.back(), 1.05);
      widest = std::max(widest, flat.back());
    }
    EXPECT_GT(widest, 1.1) << "any lines would do";
  }
}

TEST(HatchSurface, RingsAreEvenOnSlopesOf45Degrees) {
  Area disc{{{}}, false, 0};
  for (int i = 0; i < 360; ++i) {
    const double at = i * 3.14159265358979 / 180;
    disc.outlines[0].push_back({60 + 55 * std::cos(at), 60 + 55 * std::sin(at)});
  }
  Artwork artwork;
  artwork.areas = {disc};
  PlacementSettings settings;
  settings.scale = 0.9;
  const Placement placement = place(artwork, settings);
  for (const auto& [name, z] : kSurfaces) {
    const HatchSurface surface = hatch_surface(surface_of(z), placement, artwork.areas);
    for (const HatchStyle style : {HatchStyle::concentric, HatchStyle::contour_parallel}) {
      SCOPED_TRACE(fmt::format("{} {}", name, static_cast<int>(style)));
      const HatchSettings hatch{.spacing_mm = 2, .style = style};
      // Insets meet at the middle, where the way to the next one is longer.
      const auto measured = [&](const HatchSurface& by) {
        return spacings(hatch_lines(disc, hatch, placement.scale(), by), placement, z, 2e-3, 0.045,
                        style == HatchStyle::concentric ? 0.005 : 0.03);
      };
      const std::vector<double> even = measured(surface);
      ASSERT_GT(even.size(), 80u);
      const std::size_t few = even.size() / 50;
      fmt::print("{:6} {}: {:.3f} to {:.3f}, but for 2 % on either side {:.3f} to {:.3f}\n", name,
                 static_cast<int>(style), even.front(), even.back(), even[few],
                 even[even.size() - 1 - few]);
      EXPECT_GT(even[few], 0.95);
      EXPECT_LT(even[even.size() - 1 - few], 1.05);
    }
  }
}

}  // namespace
}  // namespace impedraw
