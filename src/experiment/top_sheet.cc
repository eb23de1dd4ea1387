#include "impedraw/experiment/top_sheet.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace impedraw {
namespace {

constexpr double kCell = 8e-3, kFineCell = 1e-3;  // [m]
constexpr double kMostCells = 1000.0;             // of the finer ones, along a side
constexpr double kAround = 6e-3, kBeyond = 1e-3;  // [m]
constexpr double kNone = -std::numeric_limits<double>::infinity();

Eigen::AlignedBox2d extent_of(const std::vector<Eigen::Vector3d>& points) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3d& p : points) box.extend(p.head<2>());
  return box;
}

double fine_side(const std::vector<Eigen::Vector3d>& points) {
  if (points.empty()) return kFineCell;
  return std::max(kFineCell, extent_of(points).sizes().maxCoeff() / kMostCells);
}

}  // namespace

TopSheet::Cells::Cells(const std::vector<Eigen::Vector3d>& points, double cell, double wider)
    : side(cell), lower(0.0, 0.0) {
  if (points.empty()) return;
  const Eigen::AlignedBox2d box = extent_of(points);
  lower = box.min().array() - wider;
  const Eigen::Vector2d sizes = box.sizes().array() + 2.0 * wider;
  nx = static_cast<int>(sizes.x() / side) + 1;
  ny = static_cast<int>(sizes.y() / side) + 1;
  highest.assign(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny), kNone);
  for (const Eigen::Vector3d& p : points)
    around(p.head<2>(), wider, [&](std::ptrdiff_t cell_of) {
      if (cell_of < 0) return;
      double& top = highest[static_cast<std::size_t>(cell_of)];
      top = std::max(top, p.z());
    });
}

template <class Visit>
void TopSheet::Cells::around(const Eigen::Vector2d& p, double reach, const Visit& visit) const {
  const Eigen::Vector2d at = (p - lower) / side;
  const auto i0 = static_cast<int>(std::floor(at.x())), j0 = static_cast<int>(std::floor(at.y()));
  const int n = static_cast<int>(reach / side);
  for (int b = -n; b <= n; ++b)
    for (int a = -n; a <= n; ++a) {
      if (a * a + b * b > n * n) continue;
      const int i = i0 + a, j = j0 + b;
      const bool inside = i >= 0 && j >= 0 && i < nx && j < ny;
      visit(inside ? static_cast<std::ptrdiff_t>(j) * nx + i : -1);
    }
}

TopSheet::TopSheet(const std::vector<Eigen::Vector3d>& points)
    : coarse_(points, kCell, 0.0), dilated_(points, fine_side(points), kAround) {}

double TopSheet::top(double x, double y) const {
  double top = kNone;
  coarse_.around({x, y}, 0.0, [&](std::ptrdiff_t cell) {
    if (cell >= 0) top = coarse_.highest[static_cast<std::size_t>(cell)];
  });
  return top;
}

double TopSheet::lid(double x, double y) const {
  double lid = std::numeric_limits<double>::infinity();
  dilated_.around({x, y}, kAround - kBeyond, [&](std::ptrdiff_t cell) {
    lid = std::min(lid, cell < 0 ? kNone : dilated_.highest[static_cast<std::size_t>(cell)]);
  });
  return lid;
}

double TopSheet::rise(const Eigen::Vector3d& n) {
  return kCell * n.head<2>().lpNorm<1>() / std::max(n.z(), 0.1);
}

}  // namespace impedraw
