#include "impedraw/report/relief.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "impedraw/canvas/mesh_topology.h"

namespace impedraw {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

// Joins segments whose ends have the same key into lines.
class Chains {
 public:
  void add(long key_a, const Eigen::Vector2d& a, long key_b, const Eigen::Vector2d& b) {
    const int id = static_cast<int>(segments_.size());
    segments_.push_back({key_a, key_b});
    points_[key_a] = a;
    points_[key_b] = b;
    at_[key_a].push_back(id);
    at_[key_b].push_back(id);
  }

  std::vector<Relief::Line> lines() {
    std::vector<Relief::Line> out;
    std::vector<bool> used(segments_.size(), false);
    const auto follow = [&](int id, long from) {
      Relief::Line line{points_[from]};
      for (long key = from; id >= 0;) {
        used[id] = true;
        key = segments_[id].first == key ? segments_[id].second : segments_[id].first;
        line.push_back(points_[key]);
        id = -1;
        for (const int next : at_[key]) {
          if (!used[next]) id = next;
        }
      }
      out.push_back(std::move(line));
    };
    for (const auto& [key, ids] : at_) {  // open lines first, from their ends
      if (ids.size() == 1 && !used[ids[0]]) follow(ids[0], key);
    }
    for (std::size_t id = 0; id < segments_.size(); ++id) {
      if (!used[id]) follow(static_cast<int>(id), segments_[id].first);
    }
    return out;
  }

 private:
  std::vector<std::pair<long, long>> segments_;
  std::map<long, Eigen::Vector2d> points_;
  std::map<long, std::vector<int>> at_;
};

void rasterise(Relief& r, const std::vector<Eigen::Vector3d>& seen,
               const std::vector<Eigen::Vector3i>& triangles) {
  const double du = r.area.sizes().x() / r.columns, dv = r.area.sizes().y() / r.rows;
  r.height = Eigen::MatrixXd::Constant(r.rows, r.columns, kNothing);
  r.inside.setConstant(r.rows, r.columns, false);
  for (const Eigen::Vector3i& t : triangles) {
    const Eigen::Vector3d &a = seen[t[0]], &b = seen[t[1]], &c = seen[t[2]];
    const double area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (area == 0.0) continue;
    const auto column = [&](double u) {
      return static_cast<int>(std::floor((u - r.area.min().x()) / du));
    };
    const auto row = [&](double v) {
      return static_cast<int>(std::floor((v - r.area.min().y()) / dv));
    };
    const auto [u_min, u_max] = std::minmax({a.x(), b.x(), c.x()});
    const auto [v_min, v_max] = std::minmax({a.y(), b.y(), c.y()});
    for (int i = std::max(0, row(v_min)); i <= std::min(r.rows - 1, row(v_max)); ++i) {
      for (int j = std::max(0, column(u_min)); j <= std::min(r.columns - 1, column(u_max)); ++j) {
        const double u = r.area.min().x() + (j + 0.5) * du, v = r.area.min().y() + (i + 0.5) * dv;
        const double wb = ((u - a.x()) * (c.y() - a.y()) - (v - a.y()) * (c.x() - a.x())) / area;
        const double wc = ((b.x() - a.x()) * (v - a.y()) - (b.y() - a.y()) * (u - a.x())) / area;
        if (wb < -1e-9 || wc < -1e-9 || wb + wc > 1.0 + 1e-9) continue;
        const double h = a.z() + wb * (b.z() - a.z()) + wc * (c.z() - a.z());
        if (r.height(i, j) >= h) continue;
        r.height(i, j) = h;
        r.inside(i, j) = area > 0.0;  // v points down: an outside turns clockwise here
      }
    }
  }
}

// Marching squares on the grid of cell centres.
std::vector<Relief::Line> contours_at(const Relief& r, double level) {
  Chains chains;
  const double du = r.area.sizes().x() / r.columns, dv = r.area.sizes().y() / r.rows;
  for (int i = 0; i + 1 < r.rows; ++i) {
    for (int j = 0; j + 1 < r.columns; ++j) {
      const int di[] = {0, 0, 1, 1}, dj[] = {0, 1, 1, 0};  // corners in a ring
      long keys[4];
      Eigen::Vector2d points[4];
      int crossings = 0, below = 0;
      for (int k = 0; k < 4; ++k) below += r.height(i + di[k], j + dj[k]) < level;
      for (int k = 0; k < 4 && below % 4 != 0; ++k) {
        const int i0 = i + di[k], j0 = j + dj[k], i1 = i + di[(k + 1) % 4],
                  j1 = j + dj[(k + 1) % 4];
        const double h0 = r.height(i0, j0) - level, h1 = r.height(i1, j1) - level;
        if (!std::isfinite(h0 + h1) || (h0 < 0.0) == (h1 < 0.0)) continue;
        const double t = h0 / (h0 - h1);
        const double row = i0 + 0.5 + t * (i1 - i0), column = j0 + 0.5 + t * (j1 - j0);
        points[crossings] = r.area.min() + Eigen::Vector2d(column * du, row * dv);
        // Key of an edge: its upper left corner and its direction (right or down).
        keys[crossings++] =
            2L * (static_cast<long>(std::min(i0, i1)) * r.columns + std::min(j0, j1)) + (i0 != i1);
      }
      for (int k = 0; k + 1 < crossings; k += 2)
        chains.add(keys[k], points[k], keys[k + 1], points[k + 1]);
    }
  }
  return chains.lines();
}

// Something lies more than kAbove above p on all sides.
bool is_hidden(const Relief& r, const Eigen::Vector3d& p) {
  constexpr double kAbove = 1.0;  // [mm]
  const Eigen::Vector2d at = (p.head<2>() - r.area.min())
                                 .cwiseQuotient(r.area.sizes())
                                 .cwiseProduct(Eigen::Vector2d(r.columns, r.rows));
  const int column = static_cast<int>(at.x()), row = static_cast<int>(at.y());
  for (int i = row - 1; i <= row + 1; ++i)
    for (int j = column - 1; j <= column + 1; ++j)
      if (i < 0 || j < 0 || i >= r.rows || j >= r.columns || !(r.height(i, j) > p.z() + kAbove))
        return false;
  return true;
}

}  // namespace

double Relief::shade(int row, int column) const {
  if (!std::isfinite(height(row, column))) return kNothing;
  const auto slope = [&](int di, int dj, double step) {
    const double here = height(row, column);
    const int i0 = std::max(row - di, 0), i1 = std::min(row + di, rows - 1);
    const int j0 = std::max(column - dj, 0), j1 = std::min(column + dj, columns - 1);
    const double before = height(i0, j0), after = height(i1, j1);
    if (std::isfinite(before) && std::isfinite(after))
      return (after - before) / (step * ((i1 - i0) + (j1 - j0)));
    if (std::isfinite(after))
      return (after - here) / (step * std::max(1, (i1 - row) + (j1 - column)));
    if (std::isfinite(before))
      return (here - before) / (step * std::max(1, (row - i0) + (column - j0)));
    return 0.0;
  };
  const Eigen::Vector3d normal = Eigen::Vector3d(-slope(0, 1, area.sizes().x() / columns),
                                                 -slope(1, 0, area.sizes().y() / rows), 1.0)
                                     .normalized();
  return std::max(0.0, normal.dot(Eigen::Vector3d(-0.45, -0.6, 0.66).normalized()));
}

namespace {

constexpr double kInside = 0.8;  // brightness of what is seen through a hole

Raster shading_of(const Relief& r) {
  Raster image = raster(r.rows, r.columns, [&r](int i, int j) -> std::optional<Colour> {
    const double light = r.shade(i, j), whole = r.inside(i, j) ? kInside : 1.0;
    if (!std::isfinite(light)) return std::nullopt;
    const Colour c = between({0.80, 0.77, 0.71}, {0.995, 0.985, 0.96}, std::min(light, 1.0));
    return Colour{whole * c.r, whole * c.g, whole * c.b};
  });
  keep_deflated(image);
  return image;
}

}  // namespace

Relief make_relief(const std::vector<Eigen::Vector3d>& vertices,
                   const std::vector<Eigen::Vector3i>& triangles,
                   const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& view, int cells) {
  Relief r;
  std::vector<Eigen::Vector3d> seen;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Eigen::Vector3d& vertex : vertices) {
    seen.push_back(view(vertex));
    r.area.extend(seen.back().head<2>().eval());
    low = std::min(low, seen.back().z());
    high = std::max(high, seen.back().z());
  }
  if (seen.empty() || r.area.sizes().minCoeff() <= 0.0) return r;
  const double cell = r.area.sizes().maxCoeff() / cells;
  r.columns = std::max(1, static_cast<int>(std::lround(r.area.sizes().x() / cell)));
  r.rows = std::max(1, static_cast<int>(std::lround(r.area.sizes().y() / cell)));
  rasterise(r, seen, triangles);

  for (const double step : {1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0}) {
    r.contour_step = step;
    if ((high - low) / step <= 9.0) break;
  }
  for (double level = std::ceil((low + 1e-3) / r.contour_step) * r.contour_step; level < high;
       level += r.contour_step) {
    for (Relief::Line& line : contours_at(r, level)) r.contours.push_back(std::move(line));
  }

  Chains all, bare;
  const std::vector<HalfEdge> edges = half_edges(triangles, static_cast<int>(seen.size()));
  for_each_edge(edges, [&](const HalfEdge* edge, const HalfEdge* last) {
    if (last - edge != 1) return;
    const Eigen::Vector3d &a = seen[edge->low], &b = seen[edge->high];
    all.add(edge->low, a.head<2>(), edge->high, b.head<2>());
    if (!is_hidden(r, 0.5 * (a + b))) bare.add(edge->low, a.head<2>(), edge->high, b.head<2>());
  });
  r.outline = all.lines();
  r.seen_outline = bare.lines();
  // Seen from above, the triangles of a sheet cover it once; those of a body, there and back.
  constexpr double kSheet = 0.9;
  double covered = 0.0;  // twice
  for (const Eigen::Vector3i& t : triangles) {
    const Eigen::Vector3d ab = seen[t[1]] - seen[t[0]], ac = seen[t[2]] - seen[t[0]];
    covered += ab.x() * ac.y() - ab.y() * ac.x();
  }
  const auto shown = r.height.array().isFinite().count();
  r.is_sheet = std::abs(covered) > 2.0 * kSheet * r.area.sizes().prod() *
                                       static_cast<double>(shown) / (r.columns * r.rows);
  if (r.is_sheet || 2 * r.inside.count() > shown) r.inside.setConstant(false);
  r.shading = shading_of(r);
  return r;
}

namespace {
using Line = std::vector<Eigen::Vector2d>;
constexpr std::size_t kMostCorners = 20000;  // of an outline that is drawn
}  // namespace

void extend(Line& line, const Eigen::Vector2d& p, double step, bool always) {
  if (line.empty() || always || (p - line.back()).norm() >= step) line.push_back(p);
}

void draw_relief(cairo_t* cr, const Relief& r) {
  if (r.columns == 0) return;
  cairo_save(cr);
  // A sheet's outline is exact, the cells are not. Cairo's time grows with the square of a ragged
  // one.
  std::size_t corners = 0;
  for (const Line& line : r.outline) corners += line.size();
  const bool outlined = corners > 0 && corners <= kMostCorners, clipped = outlined && r.is_sheet;
  if (clipped) {
    for (const Line& line : r.outline) trace(cr, line);
    cairo_clip(cr);
  }
  cairo_translate(cr, r.area.min().x(), r.area.min().y());
  cairo_scale(cr, r.area.sizes().x() / r.columns, r.area.sizes().y() / r.rows);
  paint(cr, r.shading, CAIRO_FILTER_BILINEAR, clipped ? CAIRO_EXTEND_PAD : CAIRO_EXTEND_NONE);
  cairo_restore(cr);
  cairo_set_line_width(cr, 0.3);
  set_colour(cr, kContour, 0.55);
  for (const Line& line : r.contours) {
    Line thin;
    for (std::size_t i = 0; i < line.size(); ++i) extend(thin, line[i], 1.0, i + 1 == line.size());
    trace(cr, thin);
  }
  cairo_stroke(cr);
  cairo_set_line_width(cr, 0.7);
  if (outlined && !r.is_sheet) {  // what the body hides is dashed
    set_colour(cr, kOutline, 0.6);
    set_dash(cr, 1.5, 2.0);
    for (const Line& line : r.outline) trace(cr, line);
    cairo_stroke(cr);
    set_dash(cr);
  }
  set_colour(cr, kOutline);
  if (outlined) {
    for (const Line& line : r.seen_outline) trace(cr, line);
  }
  cairo_stroke(cr);
}

Eigen::AlignedBox2d with_margin(Eigen::AlignedBox2d box, double share) {
  const double margin = std::max(1.0, share * box.sizes().maxCoeff());
  box.min().array() -= margin;
  box.max().array() += margin;
  return box;
}

}  // namespace impedraw
