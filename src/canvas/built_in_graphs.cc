#include "impedraw/canvas/built_in_graphs.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string_view>
#include <vector>

#include "impedraw/canvas/mesh_patterns.h"
#include "impedraw/canvas/shape_checks.h"

namespace impedraw {
namespace {

constexpr double kPi = std::numbers::pi;

void validate(std::string_view shape, const FootprintSettings& s) {
  using Limits = FootprintSettings::Limits;
  require(shape, "centre", s.centre, Limits::centre);
  require(shape, "heading", s.heading_deg, Limits::heading, "deg");
  require(shape, "width", s.width, Limits::side);
  require(shape, "height", s.height, Limits::side);
  require(shape, "edge", s.edge, Limits::edge);
  require_fair_size(shape, s.edge, 2.0 * s.width * s.height / (s.edge * s.edge));
}

// A coarser grid would show a different wave.
void require_fine_edge(std::string_view shape, const FootprintSettings& s, std::string_view what,
                       double wavelength) {
  require_at_most(shape, "edge", s.edge, what, wavelength / 8.0);
}

template <class Height>
TriangleMesh graph(const FootprintSettings& s, const Height& h) {
  const double heading = s.heading_deg * kPi / 180.0;
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
  validate("wave", s.footprint);
  require("wave", "amplitude", s.amplitude, WaveSettings::Limits::amplitude);
  require("wave", "wavelength", s.wavelength, WaveSettings::Limits::wavelength);
  require_fine_edge("wave", s.footprint, "an eighth of the wavelength", s.wavelength);
  return graph(s.footprint, [&](double x, double) {
    return s.amplitude * std::sin(2.0 * kPi * x / s.wavelength);
  });
}

TriangleMesh make_saddle(const SaddleSettings& s) {
  validate("saddle", s.footprint);
  require("saddle", "radius", s.radius, SaddleSettings::Limits::radius);
  return graph(s.footprint, [&](double x, double y) { return (x * x - y * y) / (2.0 * s.radius); });
}

TriangleMesh make_terrain(const TerrainSettings& s) {
  validate("terrain", s.footprint);
  require("terrain", "amplitude", s.amplitude, TerrainSettings::Limits::amplitude);
  require("terrain", "feature", s.feature, TerrainSettings::Limits::feature);
  require_fine_edge("terrain", s.footprint, "an eighth of the feature", s.feature);

  struct Wave {
    double k_x, k_y, phase;
  };
  std::mt19937_64 bits(static_cast<std::uint64_t>(s.seed));
  // The distributions of <random> differ from one library to the next; the generator's bits do not.
  const auto uniform = [&bits] { return static_cast<double>(bits() >> 11) * 0x1p-53; };
  std::vector<Wave> waves;
  for (int i = 0; i < s.kWaves; ++i) {
    const double k = 2.0 * kPi / (s.feature * (1.0 + uniform()));
    const double heading = kPi * (i + uniform()) / s.kWaves;
    waves.push_back({k * std::cos(heading), k * std::sin(heading), 2.0 * kPi * uniform()});
  }
  return graph(s.footprint, [&](double x, double y) {
    double sum = 0.0;
    for (const Wave& w : waves) sum += std::sin(w.k_x * x + w.k_y * y + w.phase);
    return s.amplitude / s.kWaves * sum;
  });
}

}  // namespace impedraw
