#include "impedraw/canvas/built_in.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "impedraw/canvas/describe_built_in.h"
#include "impedraw/canvas/mesh_patterns.h"
#include "impedraw/canvas/shape_checks.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"

namespace impedraw {

namespace {

void validate(std::string_view shape, const CapSettings& s) {
  require_ranges(std::string(shape), s);
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
  require_ranges("plane", s);
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

namespace {

template <class Settings>
void validate(std::string_view shape, const Settings& settings) {
  require_ranges(std::string(shape), settings);
  const FootprintSettings& s = settings.footprint;
  require_fair_size(shape, s.edge, 2.0 * s.width * s.height / (s.edge * s.edge));
}

// A coarser grid would show a different wave.
void require_fine_edge(std::string_view shape, const FootprintSettings& s, std::string_view what,
                       double wavelength) {
  require_at_most(shape, "edge", s.edge, what, wavelength / 8.0);
}

template <class Height>
TriangleMesh graph(const FootprintSettings& s, const Height& h) {
  const double heading = s.heading_deg * std::numbers::pi / 180.0;
  const Eigen::Vector3d e_x(std::cos(heading), std::sin(heading), 0.0);
  const Eigen::Vector3d e_y(-e_x.y(), e_x.x(), 0.0);
  return grid_mesh(cells(s.width, s.edge), cells(s.height, s.edge),
                   [&](double u, double v) -> Eigen::Vector3d {
                     const double x = s.width * (u - 0.5);
                     const double y = s.height * (v - 0.5);
                     return s.centre + x * e_x + y * e_y + h(x, y) * Eigen::Vector3d::UnitZ();
                   });
}

}  // namespace

TriangleMesh make_wave(const WaveSettings& s) {
  validate("wave", s);
  require_fine_edge("wave", s.footprint, "an eighth of the wavelength", s.wavelength);
  return graph(s.footprint, [&](double x, double) {
    return s.amplitude * std::sin(2.0 * std::numbers::pi * x / s.wavelength);
  });
}

TriangleMesh make_saddle(const SaddleSettings& s) {
  validate("saddle", s);
  return graph(s.footprint, [&](double x, double y) { return (x * x - y * y) / (2.0 * s.radius); });
}

TriangleMesh make_terrain(const TerrainSettings& s) {
  validate("terrain", s);
  require_fine_edge("terrain", s.footprint, "an eighth of the feature", s.feature);

  struct Wave {
    double k_x, k_y, phase;
  };
  std::mt19937_64 bits(static_cast<std::uint64_t>(s.seed));
  // The distributions of <random> differ from one library to the next; the generator's bits do not.
  const auto uniform = [&bits] { return static_cast<double>(bits() >> 11) * 0x1p-53; };
  std::vector<Wave> waves;
  for (int i = 0; i < s.kWaves; ++i) {
    const double k = 2.0 * std::numbers::pi / (s.feature * (1.0 + uniform()));
    const double heading = std::numbers::pi * (i + uniform()) / s.kWaves;
    waves.push_back(
        {k * std::cos(heading), k * std::sin(heading), 2.0 * std::numbers::pi * uniform()});
  }
  return graph(s.footprint, [&](double x, double y) {
    double sum = 0.0;
    for (const Wave& w : waves) sum += std::sin(w.k_x * x + w.k_y * y + w.phase);
    return s.amplitude / s.kWaves * sum;
  });
}

namespace {

// up = 1: outside of the upper part; −1: inside of the lower part. Normals point up in both.
TriangleMesh part_of_cylinder(std::string_view shape, const CylinderSettings& s, double up) {
  require_ranges(std::string(shape), s);
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
  require_ranges("cone", s);
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
