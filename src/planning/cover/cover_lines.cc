#include "impedraw/planning/cover/cover_lines.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include <Eigen/Dense>

namespace impedraw {

namespace {

using Line = std::vector<Eigen::Vector2d>;

constexpr double kKnots = 3e-3;  // between the points of a line [m]
// Distances of a row's end, and of the row beside it, from where rows are even, in radii; the
// length that a bend takes off a row's end, in spacings; the share by which rows may be spread; the
// width in radii that the lines along a border cannot treat: docs/decisions/0045.
constexpr double kRowEnd = 0.1, kFirstRow = 0.25, kBendWay = 0.65, kSpread = 0.05, kRim = 0.48;

double length_of(const SurfaceGrid& g, const Line& line) {
  double sum = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i)
    sum += (g.lifted(line[i]) - g.lifted(line[i - 1])).norm();
  return sum;
}

// Points evenly spread along the line.
Line resampled(const Line& line, double spacing) {
  double length = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  const int n = std::max(1, static_cast<int>(std::lround(length / spacing)));
  Line out = {line.front()};
  double done = 0.0;
  int next = 1;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double piece = (line[i] - line[i - 1]).norm();
    while (next < n && done + piece >= next * length / n) {
      const double t = (next * length / n - done) / piece;
      out.push_back(line[i - 1] + t * (line[i] - line[i - 1]));
      ++next;
    }
    done += piece;
  }
  out.push_back(line.back());
  return out;
}

// Takes the grid's steps out of a level line.
Line smoothed(Line line) {
  constexpr int kSmoothings = 3;
  if (line.size() < 3) return line;
  const bool closed = is_closed(line);
  line = resampled(line, kKnots);
  for (int k = 0; k < kSmoothings; ++k) {
    Line next = line;
    const std::size_t n = line.size();
    for (std::size_t i = 1; i + 1 < n; ++i)
      next[i] = 0.25 * line[i - 1] + 0.5 * line[i] + 0.25 * line[i + 1];
    if (closed && n > 3)
      next.front() = next.back() = 0.25 * line[n - 2] + 0.5 * line[0] + 0.25 * line[1];
    line = std::move(next);
  }
  return line;
}

// Share of the footprint's places that touch.
double touching(const SurfaceGrid& g, std::size_t centre, const PressedFeet& feet) {
  const PressedFoot pressed = feet.at(g, g.plane(centre));
  const Footprint& foot = feet.foot();
  int all = 0, touch = 0;
  around(g, g.point(centre), foot.radius, [&](std::size_t v) {
    const double depth = pressed.depth(g.point(v));
    ++all;
    touch += depth > 0.0 && depth < foot.thickness;
  });
  return all > 0 ? static_cast<double>(touch) / all : 0.0;
}

// The parts of a line on which the field is at least `least`.
std::vector<Line> parts_above(const SurfaceGrid& g, const std::vector<double>& field, double least,
                              const Line& line) {
  std::vector<Line> parts;
  Line part;
  const auto close = [&] {
    if (part.size() > 1) parts.push_back(part);
    part.clear();
  };
  for (const Eigen::Vector2d& p : resampled(line, 1e-3)) {
    if (g.sample(field, p) >= least)
      part.push_back(p);
    else
      close();
  }
  close();
  return parts;
}

// Without `cut` at both ends, if enough remains.
Line shortened(const Line& line, double cut) {
  Line fine = resampled(line, 1e-3);
  const auto n = static_cast<std::size_t>(std::lround(cut / 1e-3));
  if (fine.size() <= 2 * n + 4) return line;
  return Line(fine.begin() + static_cast<std::ptrdiff_t>(n),
              fine.end() - static_cast<std::ptrdiff_t>(n));
}

// A bend that leaves a along u and meets b against w, unit; `width`: 1 for half a circle where both
// are parallel, 0 for a straight line.
Line bend(const Eigen::Vector2d& a, const Eigen::Vector2d& u, const Eigen::Vector2d& b,
          const Eigen::Vector2d& w, double width) {
  const double reach = width * 2.0 / 3.0 * (b - a).norm();
  Line line;
  for (int i = 1; i < 12; ++i) {
    const double t = i / 12.0, s = 1.0 - t;
    line.push_back(s * s * s * a + 3 * s * s * t * (a + reach * u) +
                   3 * s * t * t * (b + reach * w) + t * t * t * b);
  }
  return line;
}

struct Row {
  int level;
  Line line;
};

// The bend from a line's end to another's start, as wide as the centres allow; nothing where not
// even a straight way stays on them, or it is longer than `most`.
std::optional<Line> join(const SurfaceGrid& g, const std::vector<double>& clearance,
                         const Line& from, const Line& to, double most) {
  const Eigen::Vector2d a = from.back(), b = to.front();
  if ((g.lifted(b) - g.lifted(a)).norm() > most) return std::nullopt;
  const Eigen::Vector2d u = (a - from[from.size() - 2]).normalized(), w = (b - to[1]).normalized();
  for (const double width : {1.0, 0.5, 0.2}) {
    Line way = bend(a, u, b, w, width);
    if (std::ranges::all_of(way, [&](const auto& p) { return g.sample(clearance, p) >= 0.0; }))
      return way;
  }
  return std::nullopt;
}

// Rows one after the other, each reversed where that is nearer.
std::vector<Line> joined_rows(const SurfaceGrid& g, const std::vector<double>& clearance,
                              std::vector<Row> rows, double spacing) {
  constexpr double kJoin = 3.0;  // times the spacing, at most
  std::vector<Line> passes;
  int level = 0;
  while (!rows.empty()) {
    std::size_t best = 0;
    bool turn = false;
    std::optional<Line> way;
    double nearest = kFar;
    for (std::size_t i = 0; i < rows.size() && !passes.empty(); ++i)
      for (const bool reversed : {false, true}) {
        Line line = rows[i].line;
        if (reversed) std::reverse(line.begin(), line.end());
        const double far = (g.lifted(line.front()) - g.lifted(passes.back().back())).norm();
        std::optional<Line> found;
        if (std::abs(rows[i].level - level) <= 1)
          found = join(g, clearance, passes.back(), line, kJoin * spacing);
        // A row that can be joined comes first; else the nearest of those that are left.
        if (found.has_value() != way.has_value() ? !found : far >= nearest) continue;
        best = i;
        turn = reversed;
        way = std::move(found);
        nearest = far;
      }
    Row row = std::move(rows[best]);
    rows.erase(rows.begin() + static_cast<std::ptrdiff_t>(best));
    if (turn) std::reverse(row.line.begin(), row.line.end());
    if (way) {
      passes.back().insert(passes.back().end(), way->begin(), way->end());
      passes.back().insert(passes.back().end(), row.line.begin(), row.line.end());
    } else {
      passes.push_back(std::move(row.line));
    }
    level = row.level;
  }
  return passes;
}

// A closed line starts where the field is greatest: where the arm comes and leaves again.
void start_within(const SurfaceGrid& g, const std::vector<double>& field, Line* line) {
  if (field.empty() || !is_closed(*line)) return;
  line->pop_back();
  const auto best = std::ranges::max_element(
      *line, {}, [&](const Eigen::Vector2d& p) { return g.sample(field, p); });
  std::rotate(line->begin(), best, line->end());
  line->push_back(line->front());
}

// Distances of rings from the border, of lines that are `spacing` apart further in, in radii.
// The most even density of way has gaps of kGap behind the line on the border and a radius from it,
// and grows towards the next gap (setup/cover_floor.py).
std::vector<double> ring_distances(double spacing) {
  constexpr double kGap = 0.3, kWays = 0.95, kGrowth = 1.7;
  std::vector<double> at;
  const auto fill = [&](double from, double n) {
    for (double k = 0.5; k < n; ++k)
      at.push_back(from + kGap + (1.0 - kGap) * (1.0 - std::pow(1.0 - k / n, kGrowth)));
  };
  fill(0.0, std::ceil(kWays / spacing));
  fill(1.0, std::floor(kWays / spacing));
  return at;
}

}  // namespace

Centres footprint_centres(const SurfaceGrid& g, const CoverWish& wish) {
  Centres c;
  c.feet = PressedFeet(g, wish.footprint);
  std::vector<char> inside(g.size());
  for (std::size_t v = 0; v < g.size(); ++v) {
    inside[v] = g.known[v] && (wish.region.empty() || wish.region[v]);
    if (inside[v]) c.wanted += g.area[v];
  }
  const double keep = wish.footprint.radius + wish.margin;
  c.clearance = distance_to_edge(g, inside);
  std::vector<char> even(g.size(), 1);
  for (std::size_t v = 0; v < g.size(); ++v) {
    c.clearance[v] -= keep;
    c.on_edge += inside[v] && c.clearance[v] < 0.0;
    if (c.clearance[v] < -g.step || touching(g, v, c.feet) >= kTouching) continue;
    even[v] = 0;
    c.uneven += c.clearance[v] >= 0.0;
  }
  if (c.uneven > 0) {
    const std::vector<double> off = distance_to_edge(g, even);
    for (std::size_t v = 0; v < g.size(); ++v)
      c.clearance[v] = std::min(c.clearance[v], even[v] ? off[v] : -g.step);
  }
  c.allowed.resize(g.size());
  for (std::size_t v = 0; v < g.size(); ++v) c.allowed[v] = c.clearance[v] >= 0.0;
  return c;
}

CoverLines cover_lines(const SurfaceGrid& g, const Centres& centres, const CoverWish& wish,
                       Layout layout) {
  CoverLines found;
  const double radius = wish.footprint.radius, spacing_r = wish.spacing / radius;
  const auto along_border = [&](double distance, long rounds) {
    for (const Line& line : level_lines(g, centres.clearance, distance)) {
      if (length_of(g, line) <= radius) continue;
      Line once = smoothed(line);
      start_within(g, centres.within_reach, &once);
      Line& pass = found.passes.emplace_back(once);
      for (long k = 1; k < rounds && is_closed(once); ++k)
        pass.insert(pass.end(), once.begin() + 1, once.end());
    }
  };
  // A place on the border lacks half of the rows that others have: denser rows, more rounds.
  const long rounds = std::max(1L, std::lround(0.62 / spacing_r));
  along_border(0.0, rounds);
  found.edges = found.passes.size();
  std::vector<double> rings;
  if (layout == Layout::rings) rings = ring_distances(spacing_r);
  for (const double distance : rings) along_border(distance * radius, 1);

  // Rows that go on beyond are even as far in as the lines before them treat, less the rim.
  const double even = static_cast<double>(rounds + std::ssize(rings)) * spacing_r - kRim;
  const double inner = (even + kFirstRow) * radius;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double n = 0.0;
  for (std::size_t v = 0; v < g.size(); ++v)
    if (centres.clearance[v] >= inner) middle += g.plane(v), n += 1.0;
  if (n == 0.0) return found;
  middle /= n;
  const double angle = wish.direction_deg * std::numbers::pi / 180.0;
  const std::vector<double> across = distance_across(g, middle, {std::cos(angle), std::sin(angle)});
  double low = kFar, high = -kFar;
  for (std::size_t v = 0; v < g.size(); ++v) {
    if (centres.clearance[v] < inner) continue;
    low = std::min(low, across[v]);
    high = std::max(high, across[v]);
  }
  const int count =
      1 + std::max(0, static_cast<int>(std::ceil((high - low) / wish.spacing - kSpread)));
  const double spacing = count > 1 ? (high - low) / (count - 1) : 0.0;
  const double first = count > 1 ? low : 0.5 * (low + high);
  std::vector<Row> rows;
  for (int k = 0; k < count; ++k)
    for (const Line& whole : level_lines(g, across, first + k * spacing))
      for (Line& part :
           parts_above(g, centres.clearance, (even + kRowEnd) * radius, smoothed(whole)))
        if (length_of(g, part) > 0.2 * radius)
          rows.push_back({k, resampled(shortened(part, kBendWay * wish.spacing), kKnots)});
  found.rows = rows.size();
  for (Line& pass : joined_rows(g, centres.clearance, std::move(rows), wish.spacing))
    found.passes.push_back(resampled(pass, kKnots));
  return found;
}

std::vector<Eigen::Vector2d> rounded(const Line& line, double step) {
  if (line.size() < 4) return line;
  const auto n = static_cast<std::ptrdiff_t>(line.size());
  const bool closed = is_closed(line);
  const auto control = [&](std::ptrdiff_t i) -> Eigen::Vector2d {
    if (i >= 0 && i < n) return line[static_cast<std::size_t>(i)];
    if (closed) return i < 0 ? line[line.size() - 2] : line[1];
    return i < 0 ? 2.0 * line[0] - line[1] : 2.0 * line[line.size() - 1] - line[line.size() - 2];
  };
  Line out;
  for (std::ptrdiff_t i = 0; i + 1 < n; ++i) {
    const Eigen::Vector2d a = control(i - 1), b = control(i), c = control(i + 1),
                          d = control(i + 2);
    const int pieces = std::max(1, static_cast<int>(std::ceil((c - b).norm() / step)));
    for (int k = 0; k < pieces; ++k) {
      const double t = static_cast<double>(k) / pieces, s = 1.0 - t;
      out.push_back((s * s * s * a + (3.0 * t * t * t - 6.0 * t * t + 4.0) * b +
                     (3.0 * s * s * s - 6.0 * s * s + 4.0) * c + t * t * t * d) /
                    6.0);
    }
  }
  out.push_back(closed ? out.front() : line.back());
  return out;
}

namespace {

void at_each_millimetre(const std::vector<Line>& lines,
                        const std::function<void(const Eigen::Vector2d&)>& visit) {
  for (const Line& line : lines)
    for (const Eigen::Vector2d& p : line.size() > 1 ? resampled(line, 1e-3) : line) visit(p);
}

// Over the radius: the ball about a footprint's centre that holds all of the places under it.
constexpr double kWider = 1.3;

}  // namespace

std::vector<char> swept(const SurfaceGrid& g, const std::vector<Line>& lines, double radius) {
  std::vector<char> places(g.size(), 0);
  at_each_millimetre(lines, [&](const Eigen::Vector2d& p) {
    around(g, g.lifted(p), radius, [&](std::size_t v) { places[v] = 1; });
  });
  return places;
}

std::vector<char> surely_pressed(const SurfaceGrid& g, const std::vector<Line>& lines,
                                 const PressedFeet& feet) {
  std::vector<char> places(g.size(), 0);
  at_each_millimetre(lines, [&](const Eigen::Vector2d& p) {
    const PressedFoot pressed = feet.at(g, p);
    const double radius = feet.foot().radius;
    around(g, g.lifted(p), kWider * radius, [&](std::size_t v) {
      if (!places[v] && g.known[v])
        places[v] = wherever_it_lies(g, v, [&](const Eigen::Vector3d& at) {
          const double off = pressed.off_axis(at);
          return off <= radius - kAstray && pressed.depth(at) > kLean * off;
        });
    });
  });
  return places;
}

std::vector<char> swept(const SurfaceGrid& g, const Centres& centres, double radius) {
  std::vector<char> places(g.size(), 0);
  for (std::size_t c = 0; c < g.size(); ++c)
    if (centres.allowed[c]) around(g, g.point(c), radius, [&](std::size_t v) { places[v] = 1; });
  return places;
}

std::vector<char> inside_by(const SurfaceGrid& g, const std::vector<char>& places,
                            double distance) {
  const std::vector<double> edge = distance_to_edge(g, places);
  std::vector<char> inside(places.size());
  for (std::size_t v = 0; v < places.size(); ++v) inside[v] = edge[v] >= distance;
  return inside;
}

double area_of(const SurfaceGrid& g, const std::vector<char>& places) {
  double sum = 0.0;
  for (std::size_t v = 0; v < g.size(); ++v)
    if (places[v]) sum += g.area[v];
  return sum;
}

}  // namespace impedraw
