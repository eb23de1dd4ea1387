#include "impedraw/planning/wrap/surface_patch.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>

#include <fmt/core.h>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
const double kSteepest = std::tan(80 * std::numbers::pi / 180);

using Samples = std::vector<std::optional<SurfaceSample>>;  // by node

std::array<int, 4> corners(const SurfacePatch& patch, int cell) {
  return {cell, cell + 1, cell + 1 + patch.columns, cell + patch.columns};
}

Samples sample(const SurfacePatch& patch, const SurfaceHeight& surface,
               const std::function<bool(const Vector2d&)>& desired) {
  Samples samples(static_cast<std::size_t>(patch.columns) * patch.rows);
  SurfaceHeight::Sample last;
  for (int j = 0; j < patch.rows; ++j) {
    for (int k = 0; k < patch.columns; ++k) {
      const int i = j % 2 == 0 ? k : patch.columns - 1 - k;
      const Vector2d p = patch.corner + patch.spacing * Vector2d(i, j);
      if (desired(p)) samples[patch.node(i, j)] = surface(p.x(), p.y(), last);
    }
  }
  return samples;
}

bool passable(const SurfacePatch& patch, const Samples& samples, int cell) {
  const std::array<int, 4> c = corners(patch, cell);
  for (const int node : c) {
    if (!samples[node] || !samples[node]->p_P.allFinite()) return false;
  }
  for (int k = 0; k < 4; ++k) {
    const double rise = samples[c[k]]->p_P.z() - samples[c[(k + 1) % 4]]->p_P.z();
    if (std::abs(rise) > kSteepest * patch.spacing) return false;
  }
  return true;
}

// Length of the shortest path from `start` to every node along edges and diagonals of cells
// (Dijkstra).
std::vector<double> ways(const SurfacePatch& patch, const Samples& samples, int start) {
  std::vector<double> way(samples.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  way[start] = 0;
  open.push({0, start});
  while (!open.empty()) {
    const auto [length, node] = open.top();
    open.pop();
    if (length > way[node]) continue;
    const int i = node % patch.columns, j = node / patch.columns;
    for (int b = std::max(0, j - 1); b <= std::min(j, patch.rows - 2); ++b) {
      for (int a = std::max(0, i - 1); a <= std::min(i, patch.columns - 2); ++a) {
        if (!patch.cell[patch.node(a, b)]) continue;
        for (const int next : corners(patch, patch.node(a, b))) {
          const double other = length + (samples[next]->p_P - samples[node]->p_P).norm();
          if (other >= way[next]) continue;
          way[next] = other;
          open.push({other, next});
        }
      }
    }
  }
  return way;
}

// Keeps only the cells connected across edges to the four around `start`. Pieces joined only at a
// corner could rotate about it.
void keep_connected(SurfacePatch& patch, int start) {
  std::vector<char> kept(patch.cell.size(), false);
  std::vector<int> open;
  const auto visit = [&](int cell) {
    if (!patch.cell[cell] || kept[cell]) return;
    kept[cell] = true;
    open.push_back(cell);
  };
  for (const int cell : {start, start - 1, start - patch.columns, start - 1 - patch.columns}) {
    if (!open.empty()) break;
    visit(cell);
  }
  while (!open.empty()) {
    const int cell = open.back();
    open.pop_back();
    const int i = cell % patch.columns, j = cell / patch.columns;
    if (i > 0) visit(cell - 1);
    if (i + 1 < patch.columns) visit(cell + 1);
    if (j > 0) visit(cell - patch.columns);
    if (j + 1 < patch.rows) visit(cell + patch.columns);
  }
  patch.cell = std::move(kept);
}

void triangulate(SurfacePatch& patch, const Samples& samples) {
  patch.vertex.assign(samples.size(), -1);
  for (std::size_t c = 0; c < patch.cell.size(); ++c) {
    if (!patch.cell[c]) continue;
    for (const int node : corners(patch, static_cast<int>(c))) patch.vertex[node] = 0;
  }
  for (std::size_t n = 0; n < samples.size(); ++n) {
    if (patch.vertex[n] < 0) continue;
    patch.vertex[n] = static_cast<int>(patch.samples.size());
    patch.samples.push_back(*samples[n]);
  }
  for (std::size_t n = 0; n < patch.cell.size(); ++n) {
    if (!patch.cell[n]) continue;
    const int cell = static_cast<int>(n);
    std::array<int, 4> v = corners(patch, cell);
    for (int& corner : v) corner = patch.vertex[corner];
    if ((cell % patch.columns + cell / patch.columns) % 2 == 0) {
      patch.triangles.insert(patch.triangles.end(), {{v[0], v[1], v[2]}, {v[0], v[2], v[3]}});
    } else {
      patch.triangles.insert(patch.triangles.end(), {{v[0], v[1], v[3]}, {v[1], v[2], v[3]}});
    }
  }
}

}  // namespace

SurfacePatch make_patch(const SurfaceHeight& surface, const Vector2d& centre, double spacing,
                        double half_width, double reach,
                        const std::function<bool(const Vector2d&)>& desired) {
  if (!surface(centre.x(), centre.y())) {
    throw InputError(
        fmt::format("wrap: the surface has no point above the drawing's centre, ({:.4f}, {:.4f}) m "
                    "in the drawing plane, "
                    "to lay the page on",
                    centre.x(), centre.y()));
  }
  const int half = std::max(1, static_cast<int>(std::ceil(half_width / spacing)));
  SurfacePatch patch;
  patch.corner = centre - Vector2d::Constant(half * spacing);
  patch.spacing = spacing;
  patch.columns = patch.rows = 2 * half + 1;
  const int start = patch.node(half, half);

  const Samples samples = sample(patch, surface, desired);
  patch.cell.assign(samples.size(), false);
  for (int j = 0; j + 1 < patch.rows; ++j) {
    for (int i = 0; i + 1 < patch.columns; ++i)
      patch.cell[patch.node(i, j)] = passable(patch, samples, patch.node(i, j));
  }
  const std::vector<double> way = ways(patch, samples, start);
  for (std::size_t c = 0; c < patch.cell.size(); ++c) {
    if (!patch.cell[c]) continue;
    for (const int node : corners(patch, static_cast<int>(c)))
      patch.cell[c] = patch.cell[c] && way[node] <= reach;
  }
  keep_connected(patch, start);
  triangulate(patch, samples);
  patch.centre = patch.vertex[start];
  if (patch.centre < 0) {
    throw InputError(
        fmt::format("wrap: at the drawing's centre, ({:.4f}, {:.4f}) m in the drawing plane, the "
                    "surface ends or "
                    "is steeper than 80° within {:g} mm: the page cannot be laid on it there",
                    centre.x(), centre.y(), 1e3 * spacing));
  }
  return patch;
}

std::optional<SurfacePatch> without_triangles(const SurfacePatch& patch,
                                              const std::vector<int>& triangles) {
  SurfacePatch rest = patch;
  Samples samples(patch.vertex.size());
  int start = -1;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    if (patch.vertex[n] < 0) continue;
    samples[n] = patch.samples[patch.vertex[n]];
    if (patch.vertex[n] == patch.centre) start = static_cast<int>(n);
  }
  // Triangles stand two by two in the order of their cells.
  std::vector<int> cells;
  for (std::size_t c = 0; c < patch.cell.size(); ++c)
    if (patch.cell[c]) cells.push_back(static_cast<int>(c));
  std::vector<char> touched(samples.size(), false);
  for (const int t : triangles)
    for (const int node : corners(patch, cells[t / 2])) touched[node] = true;
  for (const int cell : cells)
    for (const int node : corners(patch, cell))
      if (touched[node]) rest.cell[cell] = false;
  keep_connected(rest, start);
  rest.samples.clear();
  rest.triangles.clear();
  triangulate(rest, samples);
  rest.centre = rest.vertex[start];
  if (rest.centre < 0) return std::nullopt;
  return rest;
}

}  // namespace impedraw
