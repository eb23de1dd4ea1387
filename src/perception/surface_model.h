// The surface of a moving body, put together from what was seen of it, frame after frame, in the
// body's own frame K.
//
// Points about a voxel apart, found by a hash table of cubes, keep the weighted mean of the samples
// near them, with weights 1/deviation². What is hidden now stays as it was seen before; what comes
// into sight is added; more frames average the noise away.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "impedraw/common/pose.h"
#include "impedraw/perception/organised_points.h"

namespace impedraw {

class SurfaceModel {
 public:
  struct Point {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();  // K [m]
    Eigen::Vector3d n = Eigen::Vector3d::Zero();  // unit, K
    double weight = 0.0;                          // [1/m²]
    int samples = 0;
  };

  // voxel: side of the cubes [m]. most: points; beyond them nothing is added. Throws InputError.
  explicit SurfaceModel(double voxel = 0.006, std::size_t most = 200000);

  // Samples in W, of a body at X_WK. A sample that faces the other way than its cube's point is
  // ignored: a thin body has two sides. Allocates nothing.
  void add(std::span<const SeenPoint> samples, const Pose& X_WK) noexcept;

  // The point whose position is nearest to p_K among those of the 27 cubes about it that face as
  // n_K does, within 45°. Null: there is none. Allocates nothing.
  const Point* nearest(const Eigen::Vector3d& p_K, const Eigen::Vector3d& n_K) const noexcept;

  std::span<const Point> points() const noexcept { return points_; }
  bool full() const noexcept { return points_.size() == most_; }

 private:
  using Cube = Eigen::Matrix<std::int32_t, 3, 1>;
  Cube cube_of(const Eigen::Vector3d& p_K) const noexcept;
  std::size_t slot_of(const Cube& cube, std::size_t hash) const noexcept;
  template <typename F>
  void each_about(const Eigen::Vector3d& p_K, const Eigen::Vector3d& n_K, F&& f) const noexcept;
  std::size_t beside(const Eigen::Vector3d& p_K, const Eigen::Vector3d& n_K) const noexcept;

  double voxel_;
  std::size_t most_;
  std::vector<Point> points_;
  std::vector<Cube> cubes_;           // of points_
  std::vector<std::uint32_t> slots_;  // hash table: 1 + index into points_, 0: empty
};

}  // namespace impedraw
