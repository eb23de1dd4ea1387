#include "impedraw/canvas/built_in.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/canvas/describe_built_in.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"

namespace impedraw {
namespace {

// A circle of vertices about the z axis, counter-clockwise seen from above.
struct Ring {
  double radius = 0.0;  // [m]
  double z = 0.0;       // [m]
  int count = 0;        // vertices, at least 3, the first at y = 0
};

// A grid of columns × rows cells, each cut along the same diagonal. Vertices are at(u, v), with u
// and v from 0 to 1. Normals point along ∂at/∂u × ∂at/∂v.
TriangleMesh grid_mesh(int columns, int rows,
                       const std::function<Eigen::Vector3d(double u, double v)>& at) {
  TriangleMesh mesh;
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column <= columns; ++column)
      mesh.vertices.push_back(at(double(column) / columns, double(row) / rows));
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

// The smallest number of equal cells, each at most `edge` long, that make up `length`; at least
// one.
int cells(double length, double edge) {
  // The factor keeps 0.36/0.0015 at 240 despite rounding.
  return std::max(1, static_cast<int>(std::ceil(length / edge * (1.0 - 1e-12))));
}

// A pole on the z axis and the rings about it, innermost first. Neighbouring rings are stitched
// along the shorter diagonals. Normals point up if the rings widen away from the pole.
TriangleMesh ring_mesh(double pole_z, const std::vector<Ring>& rings) {
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0.0, 0.0, pole_z);
  int inner_first = 0;
  int inner_count = 1;
  for (const Ring& ring : rings) {
    const int outer_first = static_cast<int>(mesh.vertices.size());
    const int outer_count = ring.count;
    for (int i = 0; i < outer_count; ++i) {
      const double phi = 2.0 * std::numbers::pi * i / outer_count;
      mesh.vertices.emplace_back(ring.radius * std::cos(phi), ring.radius * std::sin(phi), ring.z);
    }
    // a fan about the pole
    const int inner_steps = inner_count == 1 ? 0 : inner_count;
    int i = 0;
    int j = 0;
    while (i < inner_steps || j < outer_count) {
      const int inner = inner_first + i % inner_count;
      const int outer = outer_first + j % outer_count;
      // The shorter of the two diagonals, compared as angles in whole numbers: (2 j +
      // 1)/outer_count ≤ (2 i + 1)/inner_count.
      const bool shorter =
          std::int64_t{2 * j + 1} * inner_count <= std::int64_t{2 * i + 1} * outer_count;
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

constexpr double kMostShapeTriangles = 2e6;  // 1.5 m square in the usual cells of 1.5 mm

// Checks of the sizes of built-in canvases. Each throws InputError naming the shape, the setting,
// its value and what would be valid.
void require_at_most(std::string_view shape, std::string_view name, double value,
                     std::string_view what, double most) {
  if (value > most)
    throw InputError(
        fmt::format("{}.{} is {} m, allowed is at most {}, {} m", shape, name, value, what, most));
}

// The edge of two triangles to a square, longer where the area [m²] would take too many of them.
double fair_edge(double edge, double area) {
  return std::max(edge, std::sqrt(2.0 * area / kMostShapeTriangles));
}

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

TriangleMesh cap(std::string_view shape, CapSettings s, double up) {
  validate(shape, s);
  const double area = 2.0 * std::numbers::pi * s.radius * s.radius *
                      (1.0 - std::sqrt(1.0 - std::pow(s.opening_radius / s.radius, 2)));
  s.edge = fair_edge(s.edge, area);
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
  const double edge = fair_edge(s.edge, s.width * s.height);
  const Eigen::Vector3d z = s.normal.normalized();
  const Eigen::Vector3d along =
      std::abs(z.x()) < 0.99 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d x = (along - z * z.dot(along)).normalized();
  const Eigen::Vector3d y = z.cross(x);
  const int columns = std::max(1, static_cast<int>(std::lround(s.width / edge)));
  const int rows = std::max(1, static_cast<int>(std::lround(s.height / edge)));
  return grid_mesh(columns, rows, [&](double u, double v) -> Eigen::Vector3d {
    return s.centre + x * (s.width * (u - 0.5)) + y * (s.height * (v - 0.5));
  });
}

namespace {

// The distributions of <random> differ from one library to the next; the generator's bits do not.
class Random {
 public:
  explicit Random(int seed) : bits_(static_cast<std::uint64_t>(seed)) {}
  double uniform() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }
  double normal() {
    const double u = 1.0 - uniform(), v = uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
  }

 private:
  std::mt19937_64 bits_;
};

// The side of a cell, at most `longest`: a coarser grid would show a different wave.
double cell_of(const FootprintSettings& s, double longest) {
  return std::min(fair_edge(s.edge, s.width * s.height), longest);
}

template <class Height>
TriangleMesh graph(const FootprintSettings& s, double edge, const Height& h) {
  const double heading = s.heading_deg * std::numbers::pi / 180.0;
  const Eigen::Vector3d e_x(std::cos(heading), std::sin(heading), 0.0);
  const Eigen::Vector3d e_y(-e_x.y(), e_x.x(), 0.0);
  return grid_mesh(cells(s.width, edge), cells(s.height, edge),
                   [&](double u, double v) -> Eigen::Vector3d {
                     const double x = s.width * (u - 0.5), y = s.height * (v - 0.5);
                     return s.centre + x * e_x + y * e_y + h(x, y) * Eigen::Vector3d::UnitZ();
                   });
}

}  // namespace

TriangleMesh make_wave(const WaveSettings& s) {
  require_ranges("wave", s);
  return graph(s.footprint, cell_of(s.footprint, s.wavelength / 8.0), [&](double x, double) {
    return s.amplitude * std::sin(2.0 * std::numbers::pi * x / s.wavelength);
  });
}

TriangleMesh make_saddle(const SaddleSettings& s) {
  require_ranges("saddle", s);
  constexpr double kAny = std::numeric_limits<double>::infinity();
  return graph(s.footprint, cell_of(s.footprint, kAny),
               [&](double x, double y) { return (x * x - y * y) / (2.0 * s.radius); });
}

TriangleMesh make_terrain(const TerrainSettings& s) {
  require_ranges("terrain", s);

  struct Wave {
    double k_x, k_y, phase;
  };
  Random random(s.seed);
  std::vector<Wave> waves;
  for (int i = 0; i < s.kWaves; ++i) {
    const double k = 2.0 * std::numbers::pi / (s.feature * (1.0 + random.uniform()));
    const double heading = std::numbers::pi * (i + random.uniform()) / s.kWaves;
    waves.push_back(
        {k * std::cos(heading), k * std::sin(heading), 2.0 * std::numbers::pi * random.uniform()});
  }
  return graph(s.footprint, cell_of(s.footprint, s.feature / 8.0), [&](double x, double y) {
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
  const double edge = fair_edge(s.edge, s.length * arc);

  const double heading = s.heading_deg * std::numbers::pi / 180.0;
  const Eigen::Vector3d along(std::cos(heading), std::sin(heading), 0.0);
  const Eigen::Vector3d across(-along.y(), along.x(), 0.0);
  return grid_mesh(cells(s.length, edge), cells(arc, edge),
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
  const double edge = fair_edge(s.edge, std::numbers::pi * s.base_radius * slant);
  const int count = std::max(1, static_cast<int>(std::ceil(slant / (edge * std::sqrt(0.75)))));
  std::vector<Ring> rings;
  for (int k = 1; k <= count; ++k) {
    const double rho = s.base_radius * k / count;
    // A chord of length l deviates from the cone by l² sin(slope)/(8 ρ). Shorter chords near the
    // apex keep the bound.
    const double chord = edge * std::min(1.0, std::sqrt(8.0 * rho / s.base_radius));
    rings.push_back(
        {rho, -std::tan(slope) * rho,
         std::max(6, static_cast<int>(std::ceil(2.0 * std::numbers::pi * rho / chord)))});
  }
  TriangleMesh mesh = ring_mesh(0.0, rings);
  for (auto& p : mesh.vertices) p += s.apex;
  return mesh;
}

namespace {

TriangleMesh fractal(const RoughSettings& s, double edge) {
  constexpr int kWaves = 96;
  constexpr double kRoughness = 0.8;  // a ∝ λ^kRoughness
  struct Wave {
    double k_x, k_y, phase, a;
  };
  Random random(s.seed);
  std::vector<Wave> waves;
  double sum = 0.0;
  const double longest = std::max(RoughSettings::kLongest, 1.001 * s.wavelength);
  for (int i = 0; i < kWaves; ++i) {
    const double share = (i + random.uniform()) / kWaves;
    const double length = s.wavelength * std::pow(longest / s.wavelength, share);
    const double k = 2.0 * std::numbers::pi / length,
                 heading = 2.0 * std::numbers::pi * random.uniform();
    const double a = std::pow(length, kRoughness);
    waves.push_back({k * std::cos(heading), k * std::sin(heading),
                     2.0 * std::numbers::pi * random.uniform(), a});
    sum += a * a * k * k / 2.0;
  }
  const double scale = std::tan(s.slope_deg * std::numbers::pi / 180.0) / std::sqrt(sum);
  return graph(s.footprint, edge, [&](double x, double y) {
    double h = 0.0;
    for (const Wave& w : waves) h += w.a * std::sin(w.k_x * x + w.k_y * y + w.phase);
    return scale * h;
  });
}

TriangleMesh facets(const RoughSettings& s) {
  Random random(s.seed);
  // Both triangles of a square have gradient (Δz along one side, Δz along the other)/λ, each
  // difference of variance 2 σ².
  const double sigma = std::tan(s.slope_deg * std::numbers::pi / 180.0) * s.wavelength / 2.0;
  return graph(s.footprint, s.wavelength, [&](double, double) { return sigma * random.normal(); });
}

TriangleMesh hole(const RoughSettings& s, double edge) {
  TriangleMesh mesh = graph(s.footprint, edge, [](double, double) { return 0.0; });
  std::erase_if(mesh.triangles, [&](const Eigen::Vector3i& t) {
    const Eigen::Vector3d middle =
        (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0;
    return (middle - s.footprint.centre).norm() < s.wavelength / 2.0;
  });
  return mesh;
}

TriangleMesh lip(const RoughSettings& s, double edge) {
  TriangleMesh mesh = graph(s.footprint, edge, [](double, double) { return 0.0; });
  FootprintSettings half = s.footprint;
  half.width /= 2.0;
  const double heading = half.heading_deg * std::numbers::pi / 180.0;
  half.centre += Eigen::Vector3d(std::cos(heading), std::sin(heading), 0.0) * half.width / 2.0;
  half.centre.z() += s.height;
  const TriangleMesh sheet = graph(half, edge, [](double, double) { return 0.0; });
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), sheet.vertices.begin(), sheet.vertices.end());
  for (const Eigen::Vector3i& t : sheet.triangles)
    mesh.triangles.push_back(t + Eigen::Vector3i::Constant(first));
  return mesh;
}

}  // namespace

TriangleMesh make_rough(const RoughSettings& s) {
  require_ranges("rough", s);
  const double edge = cell_of(s.footprint, s.wavelength / 4.0);
  const double slope = std::tan(s.slope_deg * std::numbers::pi / 180.0),
               k = 2.0 * std::numbers::pi / s.wavelength;
  switch (s.form) {
    case RoughForm::fractal:
      return fractal(s, edge);
    case RoughForm::facets:
      return facets(s);
    case RoughForm::ridges:
      return graph(s.footprint, edge, [&](double x, double) {
        const double phase = x / s.wavelength - std::floor(x / s.wavelength);
        return slope * s.wavelength * (phase < 0.5 ? phase : 1.0 - phase);
      });
    case RoughForm::ripple:
      return graph(s.footprint, edge, [&](double x, double y) {
        const double radius = RoughSettings::kRippleRadius;
        return std::sqrt(std::max(0.0, radius * radius - y * y)) - radius +
               std::sqrt(2.0) * slope / k * std::sin(k * x);
      });
    case RoughForm::step: {
      // One narrow column of cells makes the wall.
      TriangleMesh mesh = graph(s.footprint, edge, [](double, double) { return 0.0; });
      const double heading = s.footprint.heading_deg * std::numbers::pi / 180.0;
      const Eigen::Vector3d e_x(std::cos(heading), std::sin(heading), 0.0);
      double before = -1e9, after = 1e9;
      for (const Eigen::Vector3d& p : mesh.vertices) {
        const double x = e_x.dot(p - s.footprint.centre);
        (x < -1e-9 ? before : after) = x < -1e-9 ? std::max(before, x) : std::min(after, x);
      }
      for (Eigen::Vector3d& p : mesh.vertices) {
        const double x = e_x.dot(p - s.footprint.centre);
        if (std::abs(x - before) < 1e-6) p += (-RoughSettings::kWall - x) * e_x;
        if (std::abs(x - after) < 1e-6) p += -x * e_x;
        if (x > -1e-9) p.z() += s.height;
      }
      return mesh;
    }
    case RoughForm::hole:
      return hole(s, edge);
    case RoughForm::lip:
      return lip(s, edge);
  }
  return fractal(s, edge);
}

}  // namespace impedraw
