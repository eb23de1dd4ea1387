#include "impedraw/canvas/built_in.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "impedraw/canvas/mesh_patterns.h"
#include "impedraw/canvas/shape_checks.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"

namespace impedraw {
namespace {

void validate(std::string_view shape, const CapSettings& s) {
  using Limits = CapSettings::Limits;
  require_in_range(shape, Limits::radius, s.radius);
  require_in_range(shape, Limits::opening_radius, s.opening_radius);
  require_in_range(shape, Limits::edge, s.edge);
  require_in_range(shape, Limits::centre, s.centre);
  require_at_most(shape, "opening_radius", s.opening_radius, "the radius", s.radius);
  require_at_most(shape, "edge", s.edge, "the opening_radius", s.opening_radius);
}

// The cap about the sphere's +z axis, wound outward. A ring has as many vertices as edges fit its
// circumference.
TriangleMesh cap_about_z(const CapSettings& s) {
  const double half_angle = std::asin(s.opening_radius / s.radius);
  const int count =
      std::max(1, static_cast<int>(std::ceil(s.radius * half_angle / (s.edge * std::sqrt(0.75)))));
  std::vector<Ring> rings;
  for (int k = 1; k <= count; ++k) {
    const double theta = half_angle * k / count;
    const double rho = s.radius * std::sin(theta);
    const int vertices =
        std::max(6, static_cast<int>(std::lround(2.0 * std::numbers::pi * rho / s.edge)));
    rings.push_back({rho, s.radius * std::cos(theta), vertices});
  }
  return ring_mesh(s.radius, rings);
}

TriangleMesh cap(std::string_view shape, const CapSettings& s, double up) {
  validate(shape, s);
  const double area = 2.0 * std::numbers::pi * s.radius * s.radius *
                      (1.0 - std::sqrt(1.0 - std::pow(s.opening_radius / s.radius, 2)));
  require_fair_size(shape, s.edge, area / (s.edge * s.edge * std::sqrt(3.0) / 4.0));
  TriangleMesh mesh = cap_about_z(s);
  // up = −1 mirrors the cap to the sphere's lowest part. The mirror also reverses the winding, so
  // that the normals point inward.
  for (auto& p : mesh.vertices) p = s.centre + Eigen::Vector3d(p.x(), p.y(), up * p.z());
  return mesh;
}

}  // namespace

TriangleMesh make_bowl(const BowlSettings& settings) { return cap("bowl", settings, -1.0); }

TriangleMesh make_dome(const DomeSettings& settings) { return cap("dome", settings, 1.0); }

TriangleMesh make_plane(const PlaneSettings& s) {
  using Limits = PlaneSettings::Limits;
  require_in_range("plane", Limits::width, s.width);
  require_in_range("plane", Limits::height, s.height);
  require_in_range("plane", Limits::edge, s.edge);
  require_in_range("plane", Limits::centre, s.centre);
  require_in_range("plane", Limits::normal, s.normal);
  if (s.normal.norm() < 1e-9)
    throw InputError("plane.normal is (0, 0, 0), allowed is any other direction");
  require_fair_size("plane", s.edge, 2.0 * s.width * s.height / (s.edge * s.edge));

  const Eigen::Vector3d z = s.normal.normalized();
  const Eigen::Vector3d along =
      std::abs(z.x()) < 0.99 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d x = (along - z * z.dot(along)).normalized();
  const Eigen::Vector3d y = z.cross(x);
  const int columns = std::max(1, static_cast<int>(std::lround(s.width / s.edge)));
  const int rows = std::max(1, static_cast<int>(std::lround(s.height / s.edge)));
  return grid_mesh(columns, rows, [&](double u, double v) -> Eigen::Vector3d {
    return s.centre + x * (s.width * (u - 0.5)) + y * (s.height * (v - 0.5));
  });
}

}  // namespace impedraw
