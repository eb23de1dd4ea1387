#include "impedraw/canvas/built_in_rough.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "impedraw/canvas/describe_built_in.h"
#include "impedraw/canvas/mesh_patterns.h"
#include "impedraw/canvas/shape_checks.h"
#include "impedraw/common/range_check.h"

namespace impedraw {
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

TriangleMesh graph(const FootprintSettings& s, double edge,
                   const std::function<double(double, double)>& h) {
  const double heading = s.heading_deg * std::numbers::pi / 180.0;
  const Eigen::Vector3d e_x(std::cos(heading), std::sin(heading), 0.0);
  const Eigen::Vector3d e_y(-e_x.y(), e_x.x(), 0.0);
  return grid_mesh(cells(s.width, edge), cells(s.height, edge),
                   [&](double u, double v) -> Eigen::Vector3d {
                     const double x = s.width * (u - 0.5), y = s.height * (v - 0.5);
                     return s.centre + x * e_x + y * e_y + h(x, y) * Eigen::Vector3d::UnitZ();
                   });
}

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
  const double edge = std::min(s.footprint.edge, s.wavelength / 4.0);
  require_fair_size("rough", edge, 2.0 * s.footprint.width * s.footprint.height / (edge * edge));
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
