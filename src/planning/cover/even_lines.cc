#include "impedraw/planning/cover/even_lines.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace impedraw {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Line = std::vector<Vector2d>;

constexpr int kMovingRounds = 100, kMoveSmoothings = 5;
constexpr double kMost = 1e-3, kLeast = 2e-5, kFirst = 0.5e-3;  // of a round's moves [m]
constexpr double kMomentum = 0.8;  // share of the way of the round before that a round goes on
constexpr double kLongest = 2.0;   // of a knot's way, over the RMS of all: else few hold all back
constexpr double kLongestPart = 3.0;  // that is repeated at once, in radii
constexpr double kWorth = 1e-4;       // least fall of the squared variation, for one more stroke

struct Unevenness {
  std::vector<double> e_area;  // of each vertex: e dA
  double rms = 0.0, mean = 0.0;
};

std::vector<double> areas_of(const SurfaceGrid& g, const std::vector<char>& places) {
  std::vector<double> area(g.size());
  for (std::size_t v = 0; v < g.size(); ++v) area[v] = places[v] ? g.area[v] : 0.0;
  return area;
}

Unevenness unevenness(const SurfaceGrid& g, const std::vector<double>& area,
                      const std::vector<double>& dose) {
  Unevenness u{std::vector<double>(g.size())};
  double whole = 0.0, sum = 0.0, squares = 0.0;
  for (std::size_t v = 0; v < g.size(); ++v) whole += area[v], sum += area[v] * dose[v];
  if (!(sum > 0.0)) return u;
  u.mean = sum / whole;
  for (std::size_t v = 0; v < g.size(); ++v) {
    if (!(area[v] > 0.0)) continue;
    const double e = dose[v] / u.mean - 1.0;
    u.e_area[v] = e * area[v];
    squares += e * u.e_area[v];
  }
  u.rms = std::sqrt(squares / whole);
  return u;
}

Vector2d gradient(const SurfaceGrid& g, const std::vector<double>& field, const Vector2d& p) {
  const Vector2d x(g.step, 0.0), y(0.0, g.step);
  return Vector2d(g.sample(field, p + x) - g.sample(field, p - x),
                  g.sample(field, p + y) - g.sample(field, p - y)) /
         (2.0 * g.step);
}

// ∫ e p dA under a footprint on p, whose rim is as wide as the grid's step.
double under(const SurfaceGrid& g, const std::vector<double>& e_area, const Vector2d& p,
             const PressedFeet& feet) {
  const Vector3d centre = g.lifted(p);
  const PressedFoot pressed = feet.at(g, p);
  const double radius = feet.foot().radius;
  double sum = 0.0;
  around(g, centre, radius + 0.5 * g.step, [&](std::size_t v) {
    if (e_area[v] == 0.0) return;
    const Vector3d q = g.point(v);
    const double inside = (radius - (q - centre).norm()) / g.step + 0.5;
    sum += std::min(inside, 1.0) * e_area[v] * pressed.pressure(q);
  });
  return sum;
}

// Its gradient along the surface, in the plane.
Vector2d pull(const SurfaceGrid& g, const Unevenness& u, const Vector2d& p,
              const PressedFeet& feet) {
  const Vector2d slope = gradient(g, g.z, p);
  const Vector3d a = Vector3d(1.0, 0.0, slope.x()).normalized(),
                 b = Vector3d(-slope.x(), -slope.y(), 1.0).normalized().cross(a);
  Vector2d sum = Vector2d::Zero();
  for (const Vector3d& t : {a, b}) {
    const Vector2d by = g.step * t.head<2>();
    sum += (under(g, u.e_area, p + by, feet) - under(g, u.e_area, p - by, feet)) / (2.0 * g.step) *
           t.head<2>();
  }
  return sum;
}

// The motion of each knot, per way at it, uphill on E.
Line uphill(const SurfaceGrid& g, const Unevenness& u, const Line& line, const PressedFeet& feet) {
  const std::size_t n = line.size();
  const bool closed = is_closed(line);
  Line way(n, Vector2d::Zero());
  std::vector<double> m(n), along(n, 1e-4);
  for (std::size_t i = 0; i < n; ++i) m[i] = under(g, u.e_area, line[i], feet);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double length = (g.lifted(line[i + 1]) - g.lifted(line[i])).norm();
    along[i] += 0.5 * length, along[i + 1] += 0.5 * length;
    const Vector2d longer = 0.5 * (m[i] + m[i + 1]) * (line[i + 1] - line[i]).stableNormalized();
    way[i] -= longer, way[i + 1] += longer;
  }
  if (closed) {
    way.front() = way.back() = way.front() + way.back();
    along.front() = along.back() = along.front() + along.back();
  }
  for (std::size_t i = 0; i < n; ++i) way[i] = way[i] / along[i] + pull(g, u, line[i], feet);
  for (int k = 0; k < kMoveSmoothings; ++k) {
    Line next = way;
    for (std::size_t i = 1; i + 1 < n; ++i)
      next[i] = 0.25 * way[i - 1] + 0.5 * way[i] + 0.25 * way[i + 1];
    if (closed) next.front() = next.back() = 0.25 * way[n - 2] + 0.5 * way[0] + 0.25 * way[1];
    way = std::move(next);
  }
  return way;
}

// The place nearest to p among the centres; `before` where none is near.
Vector2d onto_centres(const SurfaceGrid& g, const std::vector<double>& clearance, Vector2d p,
                      const Vector2d& before) {
  for (int k = 0; k < 3 && g.sample(clearance, p) < 0.0; ++k) {
    const Vector2d up = gradient(g, clearance, p);
    if (up.norm() < 1e-3) break;
    p -= g.sample(clearance, p) * up / up.squaredNorm();
  }
  return g.sample(clearance, p) < std::min(0.0, g.sample(clearance, before)) - 0.1e-3 ? before : p;
}

// A knot of a line that may be repeated.
struct Knot {
  double at, way;  // along the line, and from the knot before [m]
  double own;      // ∫ p dA over the places under the footprint [m²]
};

std::vector<std::vector<Knot>> knots_of(const SurfaceGrid& g, const std::vector<double>& area,
                                        const PlaneLines& lines, const PressedFeet& feet) {
  std::vector<std::vector<Knot>> all;
  for (const Line& line : lines) {
    std::vector<Knot>& knots = all.emplace_back(line.size(), Knot{0.0, 0.0, 0.0});
    for (std::size_t i = 1; i < line.size(); ++i) {
      const double way = (g.lifted(line[i]) - g.lifted(line[i - 1])).norm();
      knots[i] = {knots[i - 1].at + way, way, under(g, area, line[i], feet)};
    }
  }
  return all;
}

struct Part {
  std::size_t line = 0, from = 0, to = 0;  // knots, the last one included
  double gain = 0.0;                       // of E [m²]
};

// The part whose repetition promises the most: a pass at knot i adds w p / d̄ to e, and on average
// its own chord over a disc besides.
Part best_part(const SurfaceGrid& g, const Unevenness& u, const PlaneLines& lines,
               const std::vector<std::vector<Knot>>& knots, const PressedFeet& feet) {
  const double chord = 16.0 / (3.0 * std::numbers::pi) * feet.foot().radius;
  Part best;
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const Line& line = lines[l];
    const std::vector<Knot>& on = knots[l];
    std::vector<double> gain(line.size());
    for (std::size_t i = 1; i < line.size(); ++i)
      gain[i] = -on[i].way / u.mean *
                (2.0 * under(g, u.e_area, line[i], feet) + chord / u.mean * on[i].own);
    for (std::size_t from = 0; from < line.size(); ++from) {
      double sum = 0.0;
      for (std::size_t to = from + 1;
           to < line.size() && on[to].at - on[from].at < kLongestPart * feet.foot().radius; ++to)
        if ((sum += gain[to]) > best.gain && on[to].at - on[from].at > feet.foot().radius)
          best = {l, from, to, sum};
    }
  }
  return best;
}

}  // namespace

PlaneLines repeats(const SurfaceGrid& g, const PressedFeet& feet, const std::vector<char>& places,
                   const PlaneLines& lines) {
  const std::vector<double> area = areas_of(g, places);
  const std::vector<std::vector<Knot>> knots = knots_of(g, area, lines, feet);
  std::vector<double> dose = dose_of(g, lines, feet);
  Unevenness u = unevenness(g, area, dose);
  PlaneLines added;
  while (u.mean > 0.0) {
    const Part part = best_part(g, u, lines, knots, feet);
    if (!(part.gain > 0.0)) break;
    const auto first = lines[part.line].begin();
    Line piece(first + static_cast<std::ptrdiff_t>(part.from),
               first + static_cast<std::ptrdiff_t>(part.to) + 1);
    const std::vector<double> more = dose_of(g, {piece}, feet);
    for (std::size_t v = 0; v < g.size(); ++v) dose[v] += more[v];
    Unevenness after = unevenness(g, area, dose);
    if (!(u.rms * u.rms - after.rms * after.rms > kWorth)) break;
    u = std::move(after);
    added.push_back(std::move(piece));
  }
  return added;
}

double even_lines(const SurfaceGrid& g, const Centres& centres, const std::vector<char>& places,
                  std::size_t fixed, PlaneLines* lines) {
  const PressedFeet& feet = centres.feet;
  const std::vector<double> area = areas_of(g, places);
  Unevenness u = unevenness(g, area, dose_of(g, *lines, feet));
  double most = kFirst;
  PlaneLines before;
  for (int round = 0; round < kMovingRounds && most > kLeast; ++round) {
    PlaneLines ways(lines->size());
    double squares = 0.0, knots = 0.0;
    for (std::size_t l = fixed; l < lines->size(); ++l) {
      ways[l] = uphill(g, u, (*lines)[l], feet);
      for (std::size_t i = 0; i < ways[l].size(); ++i) {
        if (!before.empty()) ways[l][i] += kMomentum * before[l][i];
        squares += ways[l][i].squaredNorm(), knots += 1.0;
      }
    }
    if (!(squares > 0.0)) break;
    const double longest = kLongest * std::sqrt(squares / knots);
    PlaneLines moved = *lines;
    for (std::size_t l = fixed; l < lines->size(); ++l)
      for (std::size_t i = 0; i < ways[l].size(); ++i) {
        Vector2d& way = ways[l][i];
        way *= longest / std::max(longest, way.norm());
        const Vector2d& p = (*lines)[l][i];
        moved[l][i] = onto_centres(g, centres.clearance, p - most / longest * way, p);
      }
    Unevenness after = unevenness(g, area, dose_of(g, moved, feet));
    if (after.rms < u.rms) {
      u = std::move(after);
      *lines = std::move(moved);
      before = std::move(ways);
      most = std::min(1.2 * most, kMost);
    } else {
      before.clear();
      most *= 0.6;
    }
  }
  return u.rms;
}

}  // namespace impedraw
