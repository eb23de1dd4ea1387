#include "impedraw/planning/cover/even_lines.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <Eigen/Geometry>

#include "impedraw/planning/cover/cover_lines.h"

namespace impedraw {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Line = std::vector<Vector2d>;

constexpr int kMovingRounds = 100, kMoveSmoothings = 5;
constexpr double kMost = 1e-3, kLeast = 2e-5, kFirst = 0.5e-3;  // of a round's moves [m]
constexpr double kMomentum = 0.8;  // share of the way of the round before that a round goes on
constexpr double kLongest = 2.0;   // of a knot's way, over the RMS of all: else few hold all back
// Length of a part that is left out or repeated at once, in radii. What is left on either side is
// not shorter.
constexpr double kShortestPart = 1.0, kLongestPart = 6.0;
// Fall of the squared variation that one more stroke is worth, and the least one that counts.
constexpr double kWorth = 1e-4, kLeastFall = 1e-5;

struct Unevenness {
  std::vector<double> e_area;  // of each vertex: e dA
  double rms = 0.0, mean = 0.0;
  double area = 0.0;  // [m²]
};

std::vector<double> areas_of(const SurfaceGrid& g, const std::vector<char>& places) {
  std::vector<double> area(g.size());
  for (std::size_t v = 0; v < g.size(); ++v) area[v] = places[v] ? g.area[v] : 0.0;
  return area;
}

Unevenness unevenness(const SurfaceGrid& g, const std::vector<double>& area,
                      const std::vector<double>& dose) {
  Unevenness u{std::vector<double>(g.size())};
  double sum = 0.0, squares = 0.0;
  for (std::size_t v = 0; v < g.size(); ++v) u.area += area[v], sum += area[v] * dose[v];
  if (!(sum > 0.0)) return u;
  u.mean = sum / u.area;
  for (std::size_t v = 0; v < g.size(); ++v) {
    if (!(area[v] > 0.0)) continue;
    const double e = dose[v] / u.mean - 1.0;
    u.e_area[v] = e * area[v];
    squares += e * u.e_area[v];
  }
  u.rms = std::sqrt(squares / u.area);
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

// Area that two discs share over that of one, x: distance of their centres over the diameter.
double shared(double x) {
  if (x >= 1.0) return 0.0;
  return 2.0 / std::numbers::pi * (std::acos(x) - x * std::sqrt(1.0 - x * x));
}

// A line whose parts may be left out or repeated.
struct PartedLine {
  Line knots;
  std::vector<Vector3d> lifted;
  std::vector<double> at, way;  // along the line, and from the knot before [m]
  std::vector<double> own;      // ∫ p dA over the places under the footprint [m²]
  std::vector<char> stays;      // the way to this knot has been refused to leave

  PartedLine(const SurfaceGrid& g, const std::vector<double>& area, Line line,
             const PressedFeet& feet)
      : knots(std::move(line)), at(knots.size()), way(knots.size()), stays(knots.size()) {
    for (std::size_t i = 0; i < knots.size(); ++i) {
      lifted.push_back(g.lifted(knots[i]));
      own.push_back(under(g, area, knots[i], feet));
      if (i == 0) continue;
      way[i] = (lifted[i] - lifted[i - 1]).norm();
      at[i] = at[i - 1] + way[i];
    }
  }
  // These knots of another one, the last one included.
  PartedLine(const PartedLine& whole, std::size_t from, std::size_t to)
      : knots(cut(whole.knots, from, to)),
        lifted(cut(whole.lifted, from, to)),
        at(knots.size()),
        way(cut(whole.way, from, to)),
        own(cut(whole.own, from, to)),
        stays(cut(whole.stays, from, to)) {
    way[0] = 0.0;
    std::partial_sum(way.begin(), way.end(), at.begin());
  }

  template <class T>
  static std::vector<T> cut(const std::vector<T>& all, std::size_t from, std::size_t to) {
    const auto first = all.begin();
    return {first + static_cast<std::ptrdiff_t>(from), first + static_cast<std::ptrdiff_t>(to) + 1};
  }
};

struct Part {
  std::size_t line = 0, from = 0, to = 0;  // knots, the last one included
  double times = 0.0;                      // 1: repeated, −1: left out
  int strokes = 0;                         // more than before
  double gain = 0.0;  // of E over the area, less what its strokes must be worth
};

// The part that promises the most: a pass at knot i adds a_i = w p / d̄ to e, under its footprint.
//
//   gain = ∓ 2 Σ ∫ e a_i dA − Σ_ij ∫ a_i a_j dA
Part best_part(const SurfaceGrid& g, const Unevenness& u, const std::vector<PartedLine>& lines,
               const PressedFeet& feet) {
  const double shortest = kShortestPart * feet.foot().radius,
               longest = kLongestPart * feet.foot().radius, wide = 2.0 * feet.foot().radius;
  Part best;
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const PartedLine& line = lines[l];
    const std::size_t n = line.knots.size();
    std::vector<double> own(n), squares(n);  // −2 ∫ e a_i dA, and Σ_ij of a part that ends here
    for (std::size_t i = 1; i < n; ++i)
      own[i] = -2.0 * line.way[i] / u.mean * under(g, u.e_area, line.knots[i], feet);
    for (std::size_t from = n - 1; from-- > 0;) {
      const std::size_t i = from + 1;
      double sum = 0.0, with_i = 0.0;
      bool stays = line.at[from] > 0.0 && line.at[from] < shortest;
      for (std::size_t to = i; to < n; ++to) {
        const double length = line.at[to] - line.at[from], left = line.at[n - 1] - line.at[to];
        if (length > longest) break;
        with_i += (i < to ? 2.0 : 1.0) * line.way[i] * line.way[to] *
                  std::sqrt(line.own[i] * line.own[to]) / (u.mean * u.mean) *
                  shared((line.lifted[i] - line.lifted[to]).norm() / wide);
        squares[to] += with_i;
        sum += own[to];
        stays = stays || line.stays[to];
        const bool less = sum < 0.0;
        if (length < shortest || (less && (stays || (left > 0.0 && left < shortest)))) continue;
        const int strokes = less ? (from > 0) + (to + 1 < n) - 1 : 1;
        const double gain = (std::abs(sum) - squares[to]) / u.area - kWorth * strokes;
        if (gain > best.gain) best = {l, from, to, less ? -1.0 : 1.0, strokes, gain};
      }
    }
  }
  return best;
}

PlaneLines lines_of(const std::vector<PartedLine>& parted) {
  PlaneLines lines;
  for (const PartedLine& line : parted)
    if (line.knots.size() > 1) lines.push_back(line.knots);
  return lines;
}

}  // namespace

void even_parts(const SurfaceGrid& g, const PressedFeet& feet, const std::vector<char>& places,
                PlaneLines* lines) {
  const std::vector<double> area = areas_of(g, places);
  std::vector<PartedLine> parted;
  for (const Line& line : *lines) parted.emplace_back(g, area, line, feet);
  const std::vector<char> pressed = surely_pressed(g, *lines, feet);
  std::vector<double> dose = dose_of(g, *lines, feet);
  Unevenness u = unevenness(g, area, dose);
  while (u.mean > 0.0) {
    const Part part = best_part(g, u, parted, feet);
    if (part.times == 0.0) break;
    const Line piece = PartedLine::cut(parted[part.line].knots, part.from, part.to);
    std::vector<double> changed = dose_of(g, {piece}, feet);
    for (std::size_t v = 0; v < g.size(); ++v) changed[v] = dose[v] + part.times * changed[v];
    Unevenness after = unevenness(g, area, changed);
    const double fall = u.rms * u.rms - after.rms * after.rms;
    const bool worth = fall > std::max(kLeastFall, kWorth * part.strokes);
    if (part.times > 0.0) {
      if (!worth) break;
      parted.emplace_back(g, area, piece, feet);
    } else {
      std::vector<PartedLine> rest = parted;
      const PartedLine& whole = parted[part.line];
      rest[part.line] = PartedLine(whole, 0, part.from);
      rest.emplace_back(whole, part.to, whole.knots.size() - 1);
      // A part stays if no other line treats all of its places.
      if (!worth || surely_pressed(g, lines_of(rest), feet) != pressed) {
        std::fill(parted[part.line].stays.begin() + static_cast<std::ptrdiff_t>(part.from) + 1,
                  parted[part.line].stays.begin() + static_cast<std::ptrdiff_t>(part.to) + 1, 1);
        continue;
      }
      parted = std::move(rest);
    }
    dose = std::move(changed);
    u = std::move(after);
  }
  *lines = lines_of(parted);
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
