#include "impedraw/planning/cover/even_forces.h"

#include <algorithm>
#include <cstdint>

namespace impedraw {

namespace {

constexpr int kRounds = 40, kSmoothings = 2;

// The places under the footprint at each point of the lines, and the way there.
struct Knot {
  double way;  // [m]
  std::vector<std::uint32_t> places;
};

std::vector<Knot> knots_of(const SurfaceGrid& g, const PlaneLines& lines, double radius) {
  std::vector<Knot> knots;
  for (const auto& line : lines)
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Eigen::Vector3d p = g.lifted(line[i]);
      Knot& knot = knots.emplace_back(Knot{0.0, {}});
      if (i > 0) knot.way += 0.5 * (p - g.lifted(line[i - 1])).norm();
      if (i + 1 < line.size()) knot.way += 0.5 * (g.lifted(line[i + 1]) - p).norm();
      around(g, p, radius,
             [&](std::size_t v) { knot.places.push_back(static_cast<std::uint32_t>(v)); });
    }
  return knots;
}

std::vector<double> dose_of(const SurfaceGrid& g, const std::vector<Knot>& knots,
                            const std::vector<double>& force) {
  std::vector<double> dose(g.size(), 0.0);
  for (std::size_t k = 0; k < knots.size(); ++k)
    for (const std::uint32_t v : knots[k].places) dose[v] += knots[k].way * force[k];
  return dose;
}

}  // namespace

std::vector<double> dose_of(const SurfaceGrid& g, const PlaneLines& lines, double radius,
                            const std::vector<std::vector<double>>& forces) {
  const std::vector<Knot> knots = knots_of(g, lines, radius);
  std::vector<double> force;
  for (const auto& line : forces) force.insert(force.end(), line.begin(), line.end());
  force.resize(knots.size(), 1.0);
  return dose_of(g, knots, force);
}

std::vector<std::vector<double>> even_forces(const SurfaceGrid& g, const PlaneLines& lines,
                                             double radius, const std::vector<char>& places,
                                             double most) {
  const std::vector<Knot> knots = knots_of(g, lines, radius);
  std::vector<double> force(knots.size(), 1.0);
  double mean = 0.0, area = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<double> dose = dose_of(g, knots, force);
    if (round == 0)
      for (std::size_t v = 0; v < g.size(); ++v)
        if (places[v]) mean += g.area(v) * dose[v], area += g.area(v);
    if (!(area > 0.0)) break;
    for (std::size_t k = 0; k < knots.size(); ++k) {
      double sum = 0.0;
      int n = 0;
      for (const std::uint32_t v : knots[k].places)
        if (places[v]) sum += mean / area / dose[v], ++n;
      if (n > 0) force[k] = std::clamp(force[k] * sum / n, 1.0 - most, 1.0 + most);
    }
    std::size_t first = 0;
    for (const auto& line : lines) {
      for (int i = 0; i < kSmoothings; ++i) {
        double before = force[first];
        for (std::size_t k = first + 1; k + 1 < first + line.size(); ++k) {
          const double own = force[k];
          force[k] = 0.25 * before + 0.5 * own + 0.25 * force[k + 1];
          before = own;
        }
      }
      first += line.size();
    }
  }
  for (int round = 0; round < kRounds; ++round) {
    double way = 0.0, pressed = 0.0;
    for (std::size_t k = 0; k < knots.size(); ++k)
      way += knots[k].way, pressed += knots[k].way * force[k];
    for (double& f : force) f = std::clamp(f * way / pressed, 1.0 - most, 1.0 + most);
  }
  std::vector<std::vector<double>> forces;
  auto at = force.begin();
  for (const auto& line : lines) {
    forces.emplace_back(at, at + static_cast<std::ptrdiff_t>(line.size()));
    at += static_cast<std::ptrdiff_t>(line.size());
  }
  return forces;
}

}  // namespace impedraw
