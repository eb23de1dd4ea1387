#include "impedraw/canvas/built_in_ruled.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "impedraw/canvas/mesh_patterns.h"
#include "impedraw/canvas/shape_checks.h"
#include "impedraw/common/range_check.h"

namespace impedraw {
namespace {

// up = 1: outside of the upper part; −1: inside of the lower part. Normals point up in both.
TriangleMesh part_of_cylinder(std::string_view shape, const CylinderSettings& s, double up) {
  using Limits = CylinderSettings::Limits;
  require_in_range(shape, Limits::middle, s.middle);
  require_in_range(shape, Limits::heading, s.heading_deg);
  require_in_range(shape, Limits::radius, s.radius);
  require_in_range(shape, Limits::length, s.length);
  require_in_range(shape, Limits::width, s.width);
  require_in_range(shape, Limits::edge, s.edge);
  require_at_most(shape, "width", s.width, "twice the radius", 2.0 * s.radius);
  require_at_most(shape, "edge", s.edge, "the width", s.width);
  const double half_angle = std::asin(std::min(1.0, 0.5 * s.width / s.radius));
  const double arc = 2.0 * s.radius * half_angle;
  require_fair_size(shape, s.edge, 2.0 * s.length * arc / (s.edge * s.edge));

  const double heading = s.heading_deg * std::numbers::pi / 180.0;
  const Eigen::Vector3d along(std::cos(heading), std::sin(heading), 0.0);
  const Eigen::Vector3d across(-along.y(), along.x(), 0.0);
  return grid_mesh(cells(s.length, s.edge), cells(arc, s.edge),
                   [&](double u, double v) -> Eigen::Vector3d {
                     const double theta = half_angle * (2.0 * v - 1.0);
                     const double rise = up * s.radius * (std::cos(theta) - 1.0);
                     return s.middle + s.length * (u - 0.5) * along +
                            s.radius * std::sin(theta) * across + rise * Eigen::Vector3d::UnitZ();
                   });
}

}  // namespace

TriangleMesh make_cylinder(const CylinderSettings& settings) {
  return part_of_cylinder("cylinder", settings, 1.0);
}

TriangleMesh make_trough(const CylinderSettings& settings) {
  return part_of_cylinder("trough", settings, -1.0);
}

TriangleMesh make_cone(const ConeSettings& s) {
  using Limits = ConeSettings::Limits;
  require_in_range("cone", Limits::apex, s.apex);
  require_in_range("cone", Limits::slope, s.slope_deg);
  require_in_range("cone", Limits::base_radius, s.base_radius);
  require_in_range("cone", Limits::edge, s.edge);
  require_at_most("cone", "edge", s.edge, "the base_radius", s.base_radius);
  const double slope = s.slope_deg * std::numbers::pi / 180.0;
  const double slant = s.base_radius / std::cos(slope);
  require_fair_size(
      "cone", s.edge,
      std::numbers::pi * s.base_radius * slant / (s.edge * s.edge * std::sqrt(3.0) / 4.0));

  const int count = std::max(1, static_cast<int>(std::ceil(slant / (s.edge * std::sqrt(0.75)))));
  std::vector<Ring> rings;
  for (int k = 1; k <= count; ++k) {
    const double rho = s.base_radius * k / count;
    // A chord of length l deviates from the cone by l² sin(slope)/(8 ρ). Shorter chords near the
    // apex keep the bound.
    const double chord = s.edge * std::min(1.0, std::sqrt(8.0 * rho / s.base_radius));
    rings.push_back(
        {rho, -std::tan(slope) * rho,
         std::max(6, static_cast<int>(std::ceil(2.0 * std::numbers::pi * rho / chord)))});
  }
  TriangleMesh mesh = ring_mesh(0.0, rings);
  for (auto& p : mesh.vertices) p += s.apex;
  return mesh;
}

}  // namespace impedraw
