#include "canvas/built_in.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "common/errors.h"

namespace impedraw {
namespace {

constexpr double kMostTriangles = 2e7;  // beyond it, a slip of units rather than a wish

void require_positive(std::string_view shape, std::string_view name, double value) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw InputError(fmt::format("{}: {} = {} m, must be a finite length above 0", shape, name, value));
  }
}

void require_finite(std::string_view shape, std::string_view name, const Eigen::Vector3d& value) {
  if (!value.allFinite()) {
    throw InputError(fmt::format("{}: {} = ({}, {}, {}), must be finite", shape, name, value.x(), value.y(), value.z()));
  }
}

void require_fair_size(std::string_view shape, double edge, double triangles) {
  if (triangles > kMostTriangles) {
    throw InputError(fmt::format("{}: edge = {} m makes {:.0e} triangles, at most {:.0e} are made: take a longer edge", shape, edge,
                                 triangles, kMostTriangles));
  }
}

void validate(std::string_view shape, const CapSettings& s) {
  require_positive(shape, "radius", s.radius);
  require_positive(shape, "opening_radius", s.opening_radius);
  require_positive(shape, "edge", s.edge);
  require_finite(shape, "centre", s.centre);
  if (s.opening_radius > s.radius) {
    throw InputError(fmt::format("{}: opening_radius = {} m, must be at most the radius, {} m", shape, s.opening_radius, s.radius));
  }
  if (s.edge > s.opening_radius) {
    throw InputError(fmt::format("{}: edge = {} m, must be at most the opening_radius, {} m", shape, s.edge, s.opening_radius));
  }
}

// The cap about +z of the sphere, wound outward. Ring k holds as many vertices as its circumference has edges; neighbouring rings are
// stitched by always taking the shorter diagonal.
TriangleMesh cap_about_z(const CapSettings& s) {
  const double half_angle = std::asin(s.opening_radius / s.radius);
  const int rings = std::max(1, static_cast<int>(std::ceil(s.radius * half_angle / (s.edge * std::sqrt(0.75)))));
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0.0, 0.0, s.radius);
  int inner_first = 0;
  int inner_count = 1;
  for (int ring = 1; ring <= rings; ++ring) {
    const double theta = half_angle * ring / rings;
    const double rho = s.radius * std::sin(theta);
    const int outer_first = static_cast<int>(mesh.vertices.size());
    const int outer_count = std::max(6, static_cast<int>(std::lround(2.0 * std::numbers::pi * rho / s.edge)));
    for (int i = 0; i < outer_count; ++i) {
      const double phi = 2.0 * std::numbers::pi * i / outer_count;
      mesh.vertices.emplace_back(rho * std::cos(phi), rho * std::sin(phi), s.radius * std::cos(theta));
    }
    const int inner_steps = inner_count == 1 ? 0 : inner_count;  // the pole is no ring: a fan about it
    int i = 0;
    int j = 0;
    while (i < inner_steps || j < outer_count) {
      const int inner = inner_first + i % inner_count;
      const int outer = outer_first + j % outer_count;
      // The shorter of the two diagonals, compared as angles in whole numbers: (2 j + 1)/outer_count ≤ (2 i + 1)/inner_count.
      const bool shorter = std::int64_t{2 * j + 1} * inner_count <= std::int64_t{2 * i + 1} * outer_count;
      const bool take_outer = j < outer_count && (i >= inner_steps || shorter);
      if (take_outer) {
        mesh.triangles.emplace_back(inner, outer, outer_first + (j + 1) % outer_count);
        ++j;
      } else {
        mesh.triangles.emplace_back(inner, outer, inner_first + (i + 1) % inner_count);
        ++i;
      }
    }
    inner_first = outer_first;
    inner_count = outer_count;
  }
  return mesh;
}

TriangleMesh cap(std::string_view shape, const CapSettings& s, double up) {
  validate(shape, s);
  const double area = 2.0 * std::numbers::pi * s.radius * s.radius * (1.0 - std::sqrt(1.0 - std::pow(s.opening_radius / s.radius, 2)));
  require_fair_size(shape, s.edge, area / (s.edge * s.edge * std::sqrt(3.0) / 4.0));
  TriangleMesh mesh = cap_about_z(s);
  // up = −1 mirrors the cap to the sphere's lowest part; the mirror also turns the winding, so that the normals come to point inward.
  for (auto& p : mesh.vertices) p = s.centre + Eigen::Vector3d(p.x(), p.y(), up * p.z());
  return mesh;
}

}  // namespace

TriangleMesh make_bowl(const BowlSettings& settings) { return cap("bowl", settings, -1.0); }

TriangleMesh make_dome(const DomeSettings& settings) { return cap("dome", settings, 1.0); }

TriangleMesh make_plane(const PlaneSettings& s) {
  require_positive("plane", "width", s.width);
  require_positive("plane", "height", s.height);
  require_positive("plane", "edge", s.edge);
  require_finite("plane", "centre", s.centre);
  require_finite("plane", "normal", s.normal);
  if (s.normal.norm() < 1e-9) throw InputError("plane: normal = (0, 0, 0), must have a direction");
  require_fair_size("plane", s.edge, 2.0 * s.width * s.height / (s.edge * s.edge));

  const Eigen::Vector3d z = s.normal.normalized();
  const Eigen::Vector3d along = std::abs(z.x()) < 0.99 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d x = (along - z * z.dot(along)).normalized();
  const Eigen::Vector3d y = z.cross(x);
  const int columns = std::max(1, static_cast<int>(std::lround(s.width / s.edge)));
  const int rows = std::max(1, static_cast<int>(std::lround(s.height / s.edge)));
  TriangleMesh mesh;
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column <= columns; ++column) {
      mesh.vertices.push_back(s.centre + x * (s.width * (double(column) / columns - 0.5)) + y * (s.height * (double(row) / rows - 0.5)));
    }
  }
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int a = row * (columns + 1) + column;
      const int b = a + columns + 1;
      mesh.triangles.emplace_back(a, a + 1, b + 1);
      mesh.triangles.emplace_back(a, b + 1, b);
    }
  }
  return mesh;
}

}  // namespace impedraw
