#include "impedraw/planning/cover/pressed_foot.h"

#include <cmath>
#include <memory>
#include <utility>

#include <Eigen/Dense>

#include "impedraw/common/in_parallel.h"

namespace impedraw {

void PressedFoot::set_plane(const Eigen::Vector3d& plane) {
  plane_ = plane;
  along_normal_ = 1.0 / std::sqrt(1.0 + plane.tail<2>().squaredNorm());
}

PressedFoot::PressedFoot(const SurfaceGrid& g, const Eigen::Vector3d& centre, const Footprint& foot)
    : centre_(centre), compression_(foot.compression) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  around(g, centre, foot.radius, [&](std::size_t v) {
    const Eigen::Vector3d d = g.point(v) - centre, x(1.0, d.x(), d.y());
    A += x * x.transpose();
    b += d.z() * x;
  });
  set_plane(A.ldlt().solve(b));
  double sum = 0.0;
  around(g, centre, foot.radius, [&](std::size_t v) { sum += std::max(0.0, depth(g.point(v))); });
  if (sum > 0.0) mean_ = sum / A(0, 0);
}

PressedFeet::PressedFeet(const SurfaceGrid& g, const Footprint& foot) : foot_(foot) {
  for (auto* field : {&offset_, &slope_x_, &slope_y_, &mean_}) field->resize(g.size());
  in_parallel(g.ny, [&](int j) {
    for (int i = 0; i < g.nx; ++i) {
      const std::size_t v = g.index(i, j);
      const PressedFoot pressed(g, g.point(v), foot);
      offset_[v] = pressed.plane_[0];
      slope_x_[v] = pressed.plane_[1];
      slope_y_[v] = pressed.plane_[2];
      mean_[v] = pressed.mean_;
    }
  });
}

PressedFoot PressedFeet::at(const SurfaceGrid& g, const Eigen::Vector2d& p) const {
  PressedFoot pressed;
  pressed.centre_ = g.lifted(p);
  pressed.compression_ = foot_.compression;
  pressed.set_plane({g.sample(offset_, p), g.sample(slope_x_, p), g.sample(slope_y_, p)});
  pressed.mean_ = g.sample(mean_, p);
  return pressed;
}

SurfaceHeight with_normals_of(const PressedFeet& feet, const SurfaceGrid& grid,
                              SurfaceHeight surface) {
  return [surface = std::move(surface), feet = std::make_shared<const PressedFeet>(feet),
          grid = std::make_shared<const SurfaceGrid>(grid)](double x, double y,
                                                            SurfaceHeight::Sample& last) {
    SurfaceHeight::Sample sample = surface(x, y, last);
    if (sample) sample->n_P = feet->at(*grid, {x, y}).normal();
    return sample;
  };
}

}  // namespace impedraw
