#include "impedraw/planning/cover/even_forces.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace impedraw {

namespace {

constexpr int kRounds = 40, kSmoothings = 2;

// The way on which the footprint holds each place, times its pressure there, of one segment of a
// line.
struct Segment {
  double way;  // [m]
  std::vector<std::pair<std::uint32_t, double>> places;
};

// The segments of all lines, and one more for each line's last point.
std::vector<Segment> segments_of(const SurfaceGrid& g, const PlaneLines& lines,
                                 const PressedFeet& feet) {
  std::vector<Segment> segments;
  for (const auto& line : lines)
    for (std::size_t i = 0; i < line.size(); ++i) {
      Segment& s = segments.emplace_back(Segment{0.0, {}});
      if (i + 1 == line.size()) continue;
      const Eigen::Vector3d a = g.lifted(line[i]), d = g.lifted(line[i + 1]) - a;
      s.way = d.norm();
      if (!(s.way > 0.0)) continue;
      const Eigen::Vector3d u = d / s.way;
      const PressedFoot pressed = feet.at(g, 0.5 * (line[i] + line[i + 1]));
      const double radius = feet.foot().radius;
      around(g, a + 0.5 * d, radius + 0.5 * s.way, [&](std::size_t v) {
        const Eigen::Vector3d q = g.point(v) - a;
        const double middle = q.dot(u), half2 = radius * radius - q.squaredNorm() + middle * middle;
        if (!(half2 > 0.0)) return;
        const double half = std::sqrt(half2);
        const double held = std::min(s.way, middle + half) - std::max(0.0, middle - half);
        if (held > 0.0)
          s.places.emplace_back(static_cast<std::uint32_t>(v), held * pressed.pressure(g.point(v)));
      });
    }
  return segments;
}

std::vector<double> dose_of(const SurfaceGrid& g, const std::vector<Segment>& segments,
                            const std::vector<double>& force) {
  std::vector<double> dose(g.size(), 0.0);
  for (std::size_t k = 0; k < segments.size(); ++k)
    for (const auto& [v, way] : segments[k].places)
      dose[v] += 0.5 * way * (force[k] + force[k + 1]);
  return dose;
}

}  // namespace

double mean_of(const SurfaceGrid& g, const std::vector<double>& field,
               const std::vector<char>& places) {
  double sum = 0.0, area = 0.0;
  for (std::size_t v = 0; v < g.size(); ++v)
    if (places[v]) sum += g.area[v] * field[v], area += g.area[v];
  return area > 0.0 ? sum / area : 0.0;
}

std::vector<double> dose_of(const SurfaceGrid& g, const PlaneLines& lines, const PressedFeet& feet,
                            const std::vector<std::vector<double>>& forces) {
  const std::vector<Segment> segments = segments_of(g, lines, feet);
  std::vector<double> force;
  for (const auto& line : forces) force.insert(force.end(), line.begin(), line.end());
  force.resize(segments.size(), 1.0);
  return dose_of(g, segments, force);
}

std::vector<std::vector<double>> even_forces(const SurfaceGrid& g, const PlaneLines& lines,
                                             const PressedFeet& feet, const WantedDose& wanted,
                                             const ForceRange& range) {
  const std::vector<Segment> segments = segments_of(g, lines, feet);
  const std::vector<char>& places = wanted.places;
  std::vector<double> force(segments.size(), 1.0);
  double whole = wanted.whole;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<double> dose = dose_of(g, segments, force);
    if (round == 0 && wanted.share.empty()) whole = mean_of(g, dose, places);
    if (!(whole > 0.0)) break;
    for (std::size_t k = 0; k < segments.size(); ++k) {
      double sum = 0.0, n = 0.0;
      for (const auto& [v, way] : segments[k].places)
        if (places[v] && dose[v] > 0.0)
          sum += way * (wanted.share.empty() ? whole : whole * wanted.share[v]) / dose[v], n += way;
      if (n > 0.0) force[k] = std::clamp(force[k] * sum / n, range.least, range.most);
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
  for (int round = 0; round < kRounds && wanted.share.empty(); ++round) {
    double way = 0.0, pressed = 0.0;
    for (std::size_t k = 0; k < segments.size(); ++k)
      way += segments[k].way, pressed += segments[k].way * force[k];
    for (double& f : force) f = std::clamp(f * way / pressed, range.least, range.most);
  }
  std::vector<std::vector<double>> forces;
  auto at = force.begin();
  for (const auto& line : lines) {
    forces.emplace_back(at, at + static_cast<std::ptrdiff_t>(line.size()));
    at += static_cast<std::ptrdiff_t>(line.size());
  }
  return forces;
}

PlaneLines in_passes(const SurfaceGrid& g, const PlaneLines& lines, const PressedFeet& feet,
                     const WantedDose& wanted, const ForceRange& range, int passes) {
  const auto forces = even_forces(g, lines, feet, wanted, {range.least, passes * range.most});
  PlaneLines all = lines;
  for (int before = 1; before < passes; ++before)
    for (std::size_t l = 0; l < lines.size(); ++l) {
      std::vector<Eigen::Vector2d> part;
      double way = 0.0;
      const auto close = [&] {
        if (way > feet.foot().radius) all.push_back(part);
        part.clear();
        way = 0.0;
      };
      for (std::size_t i = 0; i < lines[l].size(); ++i) {
        if (forces[l][i] <= before * range.most) {
          close();
          continue;
        }
        if (!part.empty()) way += (g.lifted(lines[l][i]) - g.lifted(part.back())).norm();
        part.push_back(lines[l][i]);
      }
      close();
    }
  return all;
}

}  // namespace impedraw
