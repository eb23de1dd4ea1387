#include "impedraw/simulation/posed_body.h"

#include <algorithm>
#include <cmath>

#include <mujoco/mujoco.h>

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr std::size_t kTogether = 16;  // rays for which a shape is ruled out at once
constexpr double kRoom = 1e-6;         // for rounding [m]

}  // namespace

void PosedBody::cover(const Vector3d& origin_W, std::span<const Vector3d> directions_W,
                      std::span<double> distances, Rays rays) const noexcept {
  for (std::size_t first = 0; first < directions_W.size(); first += kTogether) {
    const std::size_t end = std::min(first + kTogether, directions_W.size());
    const auto cast = [&](std::size_t k) {
      return rays == Rays::all || std::isfinite(distances[k]);
    };
    bool any = false;
    for (std::size_t k = first; k < end; ++k) any = any || cast(k);
    if (!any) continue;
    // A cone about all of these rays.
    const Vector3d& axis = directions_W[first + (end - first) / 2];
    double least = 1.0;
    for (std::size_t k = first; k < end; ++k) least = std::min(least, axis.dot(directions_W[k]));
    const bool wide = least < 0.5;
    const double slope = wide ? 0.0 : std::sqrt(std::max(0.0, 1.0 - least * least)) / least;
    for (const Shape& shape : shapes) {
      const Vector3d to = shape.p_W - origin_W;
      const double ball = shape.radius + kRoom, along = axis.dot(to);
      // Where a ray comes within the ball, it is within (along + ball) slope of the axis.
      const double reach = ball + std::max(0.0, along + ball) * slope;
      if (!wide && (along < -ball || (to - along * axis).squaredNorm() > reach * reach)) continue;
      for (std::size_t k = first; k < end; ++k) {
        if (!cast(k)) continue;
        const Vector3d& d = directions_W[k];
        const double depth = d.dot(to);
        if (to.squaredNorm() - depth * depth > ball * ball) continue;
        const double found =
            placed && shape.kind == mjGEOM_MESH
                ? mj_rayMesh(model, placed.get(), shape.geom, origin_W.data(), d.data(), nullptr)
                : mju_rayGeom(shape.p_W.data(), shape.R_WG.data(), shape.size.data(),
                              origin_W.data(), d.data(), shape.kind, nullptr);
        if (found >= 0.0) distances[k] = std::min(distances[k], found);
      }
    }
  }
}

}  // namespace impedraw
