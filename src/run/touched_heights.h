// Places where a drawing has touched its surface, so that the pen may come down fast elsewhere.
//
//   level(x, y) = min( top, min_i ( z_i + kMargin + kSteepest |p_i − (x, y)| ) )
//
// with the touched points i. It lies above a surface that is nowhere steeper than kSteepest from
// them on. Points are in the drawing frame P.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace impedraw {

class TouchedHeights {
 public:
  static constexpr double kMargin = 5e-3;   // [m]
  static constexpr double kSteepest = 1.0;  // rise over run: 45°
  static constexpr double kSpacing = 2e-3;  // between kept points along the path [m]
  static constexpr std::size_t kMost = 50000;

  // top: no part of the surface is higher [m].
  explicit TouchedHeights(double top) : top_(top) { points_.reserve(kMost); }

  // Allocates nothing. Ignores points that are too near to the last one, or one too many.
  void add(const Eigen::Vector3d& p_P) noexcept {
    if (points_.size() == kMost) return;
    if (!points_.empty() && (points_.back() - p_P).head<2>().norm() < kSpacing) return;
    points_.push_back(p_P);
  }
  double level(double x, double y) const noexcept;
  std::size_t size() const { return points_.size(); }

 private:
  double top_;
  std::vector<Eigen::Vector3d> points_;
};

}  // namespace impedraw
