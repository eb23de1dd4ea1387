#include "impedraw/canvas/built_in_graphs.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string_view>
#include <vector>

#include "impedraw/canvas/mesh_patterns.h"
#include "impedraw/canvas/shape_checks.h"
#include "impedraw/common/range_check.h"

namespace impedraw {
namespace {

void validate(std::string_view shape, const FootprintSettings& s) {
  using Limits = FootprintSettings::Limits;
  require_in_range(shape, Limits::centre, s.centre);
  require_in_range(shape, Limits::heading, s.heading_deg);
  require_in_range(shape, Limits::width, s.width);
  require_in_range(shape, Limits::height, s.height);
  require_in_range(shape, Limits::edge, s.edge);
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
  validate("wave", s.footprint);
  require_in_range("wave", WaveSettings::Limits::amplitude, s.amplitude);
  require_in_range("wave", WaveSettings::Limits::wavelength, s.wavelength);
  require_fine_edge("wave", s.footprint, "an eighth of the wavelength", s.wavelength);
  return graph(s.footprint, [&](double x, double) {
    return s.amplitude * std::sin(2.0 * std::numbers::pi * x / s.wavelength);
  });
}

TriangleMesh make_saddle(const SaddleSettings& s) {
  validate("saddle", s.footprint);
  require_in_range("saddle", SaddleSettings::Limits::radius, s.radius);
  return graph(s.footprint, [&](double x, double y) { return (x * x - y * y) / (2.0 * s.radius); });
}

TriangleMesh make_terrain(const TerrainSettings& s) {
  validate("terrain", s.footprint);
  require_in_range("terrain", TerrainSettings::Limits::amplitude, s.amplitude);
  require_in_range("terrain", TerrainSettings::Limits::feature, s.feature);
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

}  // namespace impedraw
