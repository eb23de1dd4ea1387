#include "impedraw/planning/cover/surface_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <numbers>

namespace impedraw {

namespace {

constexpr std::array<std::array<int, 2>, 8> kAround = {
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};

// An unknown height solves Laplace's equation between the known ones.
void continue_heights(SurfaceGrid* g) {
  constexpr int kSweeps = 300;
  std::vector<char> has = g->known;
  std::deque<std::size_t> front;
  for (std::size_t v = 0; v < g->size(); ++v)
    if (has[v]) front.push_back(v);
  std::vector<std::size_t> open;
  while (!front.empty()) {
    const std::size_t v = front.front();
    front.pop_front();
    const int i = g->i_of(v), j = g->j_of(v);
    for (const auto& [di, dj] : kAround) {
      if (i + di < 0 || i + di >= g->nx || j + dj < 0 || j + dj >= g->ny) continue;
      const std::size_t w = g->index(i + di, j + dj);
      if (has[w]) continue;
      has[w] = 1;
      g->z[w] = g->z[v];
      open.push_back(w);
      front.push_back(w);
    }
  }
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (const std::size_t v : open) {
      const int i = g->i_of(v), j = g->j_of(v);
      double sum = 0.0;
      int n = 0;
      for (std::size_t k = 0; k < kAround.size(); k += 2) {
        const int a = i + kAround[k][0], b = j + kAround[k][1];
        if (a < 0 || a >= g->nx || b < 0 || b >= g->ny) continue;
        sum += g->z[g->index(a, b)];
        ++n;
      }
      g->z[v] = sum / n;
    }
}

void ask_heights(const SurfaceHeight& surface, double max_slope_deg,
                 const std::function<void(double)>& progress, SurfaceGrid* g) {
  const std::size_t n = static_cast<std::size_t>(g->nx) * static_cast<std::size_t>(g->ny);
  g->z.assign(n, 0.0);
  g->known.assign(n, 0);
  g->area.assign(n, 0.0);
  const double least = std::cos(max_slope_deg * std::numbers::pi / 180.0);
  for (int j = 0; j < g->ny; ++j) {
    SurfaceHeight::Sample last;
    for (int i = 0; i < g->nx; ++i) {
      const std::size_t v = g->index(i, j);
      const Eigen::Vector2d p = g->plane(v);
      last = surface(p.x(), p.y(), last);
      if (!last) continue;
      g->z[v] = last->p_P.z();
      g->known[v] = last->n_P.z() >= least;
      g->area[v] = g->step * g->step / std::max(last->n_P.z(), 0.01);
    }
    if (progress) progress((j + 1.0) / g->ny);
  }
  continue_heights(g);
}

// The least of T over the segment from a (T_a) to b (T_b), plus the way from there to p.
double through(const Eigen::Vector3d& p, const Eigen::Vector3d& a, double T_a,
               const Eigen::Vector3d& b, double T_b) {
  const double from_a = T_a + (p - a).norm(), from_b = T_b + (p - b).norm();
  const double ends = std::min(from_a, from_b);
  if (!std::isfinite(T_a) || !std::isfinite(T_b)) return ends;
  const Eigen::Vector3d e = b - a, d = p - a;
  const double length = e.norm(), u = T_b - T_a;
  if (std::abs(u) >= length) return ends;
  const double foot = d.dot(e) / length, height2 = d.squaredNorm() - foot * foot;
  const double s = -std::sqrt(std::max(0.0, height2)) * u / std::sqrt(length * length - u * u);
  const double t = (foot + s) / length;
  if (t <= 0.0 || t >= 1.0) return ends;
  return std::min(ends, T_a + t * u + std::sqrt(height2 + s * s));
}

}  // namespace

Eigen::Vector2d SurfaceGrid::slope(std::size_t v) const {
  const int i = i_of(v), j = j_of(v);
  const int i0 = std::max(0, i - 1), i1 = std::min(nx - 1, i + 1);
  const int j0 = std::max(0, j - 1), j1 = std::min(ny - 1, j + 1);
  return {(z[index(i1, j)] - z[index(i0, j)]) / (step * (i1 - i0)),
          (z[index(i, j1)] - z[index(i, j0)]) / (step * (j1 - j0))};
}

double SurfaceGrid::sample(const std::vector<double>& field, const Eigen::Vector2d& p) const {
  const double x = std::clamp((p.x() - low.x()) / step, 0.0, nx - 1.0);
  const double y = std::clamp((p.y() - low.y()) / step, 0.0, ny - 1.0);
  const int i = std::min(nx - 2, static_cast<int>(x)), j = std::min(ny - 2, static_cast<int>(y));
  const double a = x - i, b = y - j;
  return (1 - b) * ((1 - a) * field[index(i, j)] + a * field[index(i + 1, j)]) +
         b * ((1 - a) * field[index(i, j + 1)] + a * field[index(i + 1, j + 1)]);
}

SurfaceGrid sample_surface(const SurfaceHeight& surface, const Eigen::AlignedBox2d& box,
                           double step, double max_slope_deg,
                           const std::function<void(double)>& progress) {
  SurfaceGrid g;
  g.step = step;
  g.low = box.min();
  g.nx = std::max(3, static_cast<int>(std::ceil(box.sizes().x() / step)) + 1);
  g.ny = std::max(3, static_cast<int>(std::ceil(box.sizes().y() / step)) + 1);
  ask_heights(surface, max_slope_deg, progress, &g);
  return g;
}

SurfaceGrid same_places(const SurfaceGrid& grid, const SurfaceHeight& surface,
                        double max_slope_deg) {
  SurfaceGrid g = grid;
  ask_heights(surface, max_slope_deg, {}, &g);
  return g;
}

std::vector<double> surface_distance(const SurfaceGrid& g, std::vector<double> T) {
  constexpr int kRounds = 60;
  constexpr double kStill = 1e-7;  // [m]
  const auto update = [&](int i, int j) {
    const std::size_t v = g.index(i, j);
    const Eigen::Vector3d p = g.point(v);
    double least = T[v];
    for (std::size_t k = 0; k < kAround.size(); ++k) {
      const auto& [ai, aj] = kAround[k];
      const auto& [bi, bj] = kAround[(k + 1) % kAround.size()];
      if (i + ai < 0 || i + ai >= g.nx || j + aj < 0 || j + aj >= g.ny) continue;
      if (i + bi < 0 || i + bi >= g.nx || j + bj < 0 || j + bj >= g.ny) continue;
      const std::size_t a = g.index(i + ai, j + aj), b = g.index(i + bi, j + bj);
      if (std::min(T[a], T[b]) >= least) continue;
      least = std::min(least, through(p, g.point(a), T[a], g.point(b), T[b]));
    }
    const double change = std::isfinite(T[v]) ? T[v] - least : (std::isfinite(least) ? 1.0 : 0.0);
    T[v] = least;
    return change;
  };
  for (int round = 0; round < kRounds; ++round) {
    double change = 0.0;
    for (int order = 0; order < 4; ++order)
      for (int b = 0; b < g.ny; ++b)
        for (int a = 0; a < g.nx; ++a)
          change =
              std::max(change, update(order & 1 ? g.nx - 1 - a : a, order & 2 ? g.ny - 1 - b : b));
    if (change < kStill) break;
  }
  return T;
}

std::vector<double> distance_to_edge(const SurfaceGrid& g, const std::vector<char>& inside) {
  std::vector<double> seeds(g.size(), kFar);
  for (std::size_t v = 0; v < g.size(); ++v) {
    if (!inside[v]) {
      seeds[v] = 0.0;
      continue;
    }
    const int i = g.i_of(v), j = g.j_of(v);
    bool edge = i == 0 || j == 0 || i == g.nx - 1 || j == g.ny - 1;
    for (std::size_t k = 0; k < kAround.size() && !edge; k += 2)
      edge = !inside[g.index(i + kAround[k][0], j + kAround[k][1])];
    if (edge) seeds[v] = 0.5 * g.step;
  }
  return surface_distance(g, std::move(seeds));
}

std::vector<double> distance_across(const SurfaceGrid& g, const Eigen::Vector2d& middle,
                                    const Eigen::Vector2d& direction) {
  const Eigen::Vector2d across(-direction.y(), direction.x());
  std::vector<double> seeds(g.size(), kFar), sign(g.size());
  for (std::size_t v = 0; v < g.size(); ++v) {
    const double o = across.dot(g.plane(v) - middle);
    sign[v] = o < 0.0 ? -1.0 : 1.0;
    if (std::abs(o) > 1.5 * g.step) continue;
    const Eigen::Vector2d s = g.slope(v);
    // |∇_S o| = √(aᵀ G⁻¹ a), G = 1 + ∇z ∇zᵀ
    const double along = s.dot(across), grad2 = 1.0 - along * along / (1.0 + s.squaredNorm());
    seeds[v] = std::abs(o) / std::sqrt(grad2);
  }
  std::vector<double> T = surface_distance(g, std::move(seeds));
  for (std::size_t v = 0; v < g.size(); ++v) T[v] *= sign[v];
  return T;
}

std::vector<std::vector<Eigen::Vector2d>> level_lines(const SurfaceGrid& g,
                                                      const std::vector<double>& field,
                                                      double level) {
  // Crossings have the number of their edge: 2 v of the edge to the right of v, 2 v + 1 of that
  // above it. Each square joins two of them, or four: then about b and d.
  std::map<std::size_t, std::vector<std::size_t>> joined;
  const auto above = [&](std::size_t v) { return field[v] >= level; };
  const auto place = [&](std::size_t edge) -> Eigen::Vector2d {
    const std::size_t a = edge / 2, b = edge % 2 == 0 ? a + 1 : a + static_cast<std::size_t>(g.nx);
    const double t = std::clamp((level - field[a]) / (field[b] - field[a]), 1e-6, 1.0 - 1e-6);
    return g.plane(a) + t * (g.plane(b) - g.plane(a));
  };
  for (int j = 0; j + 1 < g.ny; ++j)
    for (int i = 0; i + 1 < g.nx; ++i) {
      const std::size_t a = g.index(i, j), b = g.index(i + 1, j), c = g.index(i + 1, j + 1),
                        d = g.index(i, j + 1);
      std::vector<std::size_t> cut;
      if (above(a) != above(b)) cut.push_back(2 * a);
      if (above(b) != above(c)) cut.push_back(2 * b + 1);
      if (above(c) != above(d)) cut.push_back(2 * d);
      if (above(d) != above(a)) cut.push_back(2 * a + 1);
      for (std::size_t k = 0; k + 1 < cut.size(); k += 2) {
        joined[cut[k]].push_back(cut[k + 1]);
        joined[cut[k + 1]].push_back(cut[k]);
      }
    }
  std::vector<std::vector<Eigen::Vector2d>> lines;
  const auto follow = [&](std::size_t start) {
    std::vector<Eigen::Vector2d> line;
    for (std::size_t at = start;;) {
      line.push_back(place(at));
      auto& next = joined[at];
      if (next.empty()) break;
      const std::size_t to = next.back();
      next.pop_back();
      std::erase(joined[to], at);
      at = to;
    }
    if (line.size() > 1) lines.push_back(std::move(line));
  };
  std::vector<std::size_t> ends, all;
  for (const auto& [edge, to] : joined) {
    if (to.size() == 1) ends.push_back(edge);
    all.push_back(edge);
  }
  for (const std::size_t edge : ends)
    if (!joined[edge].empty()) follow(edge);
  for (const std::size_t edge : all)
    if (!joined[edge].empty()) follow(edge);
  return lines;
}

}  // namespace impedraw
