#include "impedraw/planning/wrap/flat_chart.h"

#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "impedraw/common/cross.h"

namespace impedraw {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
constexpr double kBucket = 1.5;    // [spacings]
constexpr double kOnEdge = 1e-9;   // barycentric coordinates ≥ −kOnEdge count as inside
constexpr double kSolved = 1e-12;  // [m]
constexpr int kNewtonSteps = 12;

struct Weights {
  std::array<double, 4> value, slope;
};

// Catmull-Rom's weights of the four nodes at −1, 0, 1, 2 for the value and the derivative at t.
Weights catmull_rom(double t) {
  return {
      {0.5 * t * (-1 + t * (2 - t)), 1 + t * t * (-2.5 + 1.5 * t), 0.5 * t * (1 + t * (4 - 3 * t)),
       0.5 * t * t * (t - 1)},
      {-0.5 + t * (2 - 1.5 * t), t * (-5 + 4.5 * t), 0.5 + t * (4 - 4.5 * t), t * (1.5 * t - 1)}};
}

// Rotation part of a differential with positive determinant (polar decomposition in the plane).
Matrix2d turn_of(const Matrix2d& J) {
  return Eigen::Rotation2Dd(std::atan2(J(1, 0) - J(0, 1), J(0, 0) + J(1, 1))).toRotationMatrix();
}

}  // namespace

FlatChart::FlatChart(SurfacePatch patch, std::vector<Vector2d> flat, const Vector2d& centre)
    : patch_(std::move(patch)), flat_(std::move(flat)) {
  fill_nodes(flat_);
  const Value at = value(place(centre, 1));
  const Matrix2d back = turn_of(at.differential).transpose();
  for (Vector2d& f : flat_) f = centre + back * (f - at.flat);
  fill_nodes(flat_);
  fill_buckets();
}

// Extrapolates to nodes next to the patch that have no vertex, so that its last cells are bicubic
// too.
void FlatChart::fill_nodes(const std::vector<Vector2d>& flat) {
  const int columns = patch_.columns + 2, rows = patch_.rows + 2;
  node_.assign(static_cast<std::size_t>(columns) * rows,
               Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  for (int j = 0; j < patch_.rows; ++j) {
    for (int i = 0; i < patch_.columns; ++i) {
      const int v = patch_.vertex[patch_.node(i, j)];
      if (v >= 0) node_[i + 1 + columns * (j + 1)] = flat[v];
    }
  }
  const std::vector<Vector2d> known = node_;
  const auto at = [&](int i, int j) -> const Vector2d* {
    if (i < 0 || j < 0 || i >= columns || j >= rows) return nullptr;
    const Vector2d& f = known[i + columns * j];
    return f.allFinite() ? &f : nullptr;
  };
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      if (at(i, j)) continue;
      Vector2d sum[2] = {Vector2d::Zero(), Vector2d::Zero()};  // by straight lines, by parabolas
      int count[2] = {0, 0};
      for (int b = -1; b <= 1; ++b) {
        for (int a = -1; a <= 1; ++a) {
          const Vector2d *f1 = at(i + a, j + b), *f2 = at(i + 2 * a, j + 2 * b),
                         *f3 = at(i + 3 * a, j + 3 * b);
          if (!f1 || !f2) continue;
          sum[f3 ? 1 : 0] += f3 ? Vector2d(3 * *f1 - 3 * *f2 + *f3) : Vector2d(2 * *f1 - *f2);
          ++count[f3 ? 1 : 0];
        }
      }
      const int kind = count[1] > 0 ? 1 : 0;
      if (count[kind] > 0) node_[i + columns * j] = sum[kind] / count[kind];
    }
  }
}

void FlatChart::fill_buckets() {
  low_ = flat_.front();
  Vector2d high = low_;
  for (const Vector2d& f : flat_) {
    low_ = low_.cwiseMin(f);
    high = high.cwiseMax(f);
  }
  const double size = kBucket * patch_.spacing;
  bucket_columns_ = static_cast<int>((high.x() - low_.x()) / size) + 1;
  bucket_rows_ = static_cast<int>((high.y() - low_.y()) / size) + 1;
  buckets_.resize(static_cast<std::size_t>(bucket_columns_) * bucket_rows_);
  for (std::size_t t = 0; t < patch_.triangles.size(); ++t) {
    const Eigen::Vector3i& v = patch_.triangles[t];
    const Vector2d from = flat_[v[0]].cwiseMin(flat_[v[1]]).cwiseMin(flat_[v[2]]);
    const Vector2d to = flat_[v[0]].cwiseMax(flat_[v[1]]).cwiseMax(flat_[v[2]]);
    const Eigen::Vector2i first = ((from - low_) / size).cast<int>(),
                          last = ((to - low_) / size).cast<int>();
    for (int b = first.y(); b <= last.y(); ++b) {
      for (int a = first.x(); a <= last.x(); ++a)
        buckets_[a + bucket_columns_ * b].push_back(static_cast<int>(t));
    }
  }
}

int FlatChart::bucket(const Vector2d& flat) const {
  const Vector2d at = (flat - low_) / (kBucket * patch_.spacing);
  if (!(at.minCoeff() >= 0) || at.x() >= bucket_columns_ || at.y() >= bucket_rows_) return -1;
  return static_cast<int>(at.x()) + bucket_columns_ * static_cast<int>(at.y());
}

// The patch's cell that contains p, else the nearest one up to `beyond` cells away.
FlatChart::Place FlatChart::place(const Vector2d& plane, int beyond) const {
  const Vector2d at = (plane - patch_.corner) / patch_.spacing;
  Place best;
  if (!(at.array().abs().maxCoeff() < 1e6)) return best;
  const int i = static_cast<int>(std::floor(at.x())), j = static_cast<int>(std::floor(at.y()));
  double nearest = std::numeric_limits<double>::infinity();
  for (int b = std::max(0, j - beyond); b <= std::min(j + beyond, patch_.rows - 2); ++b) {
    for (int a = std::max(0, i - beyond); a <= std::min(i + beyond, patch_.columns - 2); ++a) {
      if (!patch_.cell[patch_.node(a, b)]) continue;
      const Vector2d share = at - Vector2d(a, b);
      const double off = (share - share.cwiseMax(0).cwiseMin(1)).norm();
      if (off >= nearest) continue;
      nearest = off;
      best = {patch_.node(a, b), share};
    }
  }
  return best;
}

FlatChart::Value FlatChart::value(const Place& place) const {
  const int i = place.cell % patch_.columns, j = place.cell / patch_.columns;
  const Weights u = catmull_rom(place.share.x()), v = catmull_rom(place.share.y());
  Value result{Vector2d::Zero(), Matrix2d::Zero()};
  for (int b = 0; b < 4; ++b) {
    for (int a = 0; a < 4; ++a) {
      const Vector2d& f = node_[i + a + (patch_.columns + 2) * (j + b)];
      result.flat += u.value[a] * v.value[b] * f;
      result.differential.col(0) += u.slope[a] * v.value[b] / patch_.spacing * f;
      result.differential.col(1) += u.value[a] * v.slope[b] / patch_.spacing * f;
    }
  }
  return result;
}

std::optional<Vector2d> FlatChart::to_flat(const Vector2d& plane, bool beyond) const {
  const Place at = place(plane, beyond ? 2 : 0);
  if (at.cell < 0) return std::nullopt;
  return value(at).flat;
}

Matrix2d FlatChart::differential(const Vector2d& plane) const {
  Place at = place(plane, 2);
  if (at.cell < 0) return Matrix2d::Constant(std::numeric_limits<double>::quiet_NaN());
  at.share = at.share.cwiseMax(0).cwiseMin(1);
  return value(at).differential;
}

std::optional<Vector2d> FlatChart::to_plane(const Vector2d& flat) const {
  const int where = bucket(flat);
  if (where < 0) return std::nullopt;
  for (const int t : buckets_[where]) {
    const Eigen::Vector3i& v = patch_.triangles[t];
    const Vector2d a = flat_[v[1]] - flat_[v[0]], b = flat_[v[2]] - flat_[v[0]],
                   c = flat - flat_[v[0]];
    const double area = cross(a, b), s = cross(c, b) / area, r = cross(a, c) / area;
    if (s < -kOnEdge || r < -kOnEdge || s + r > 1 + kOnEdge) continue;
    const auto plane_of = [&](int k) -> Vector2d { return patch_.samples[v[k]].p_P.head<2>(); };
    Vector2d plane =
        plane_of(0) + s * (plane_of(1) - plane_of(0)) + r * (plane_of(2) - plane_of(0));
    const Vector2d start = plane;
    for (int k = 0; k < kNewtonSteps; ++k) {
      const Place at = place(plane, 1);
      if (at.cell < 0) return std::nullopt;
      const Value now = value(at);
      const Vector2d off = flat - now.flat;
      if (off.norm() < kSolved) return plane;
      plane += now.differential.inverse() * off;
      if (!((plane - start).norm() < patch_.spacing)) break;
    }
    return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace impedraw
