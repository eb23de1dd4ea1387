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
      // A ray that comes within the ball is within (along + ball) slope of the axis.
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

void PosedBody::copy(const mjModel* m, const mjData* d) {
  const auto same = [m](int a, int b) {  // a URDF may list a body as visual and as collision
    return m->geom_type[a] == m->geom_type[b] && m->geom_bodyid[a] == m->geom_bodyid[b] &&
           m->geom_dataid[a] == m->geom_dataid[b] &&
           std::equal(m->geom_size + 3 * a, m->geom_size + 3 * a + 3, m->geom_size + 3 * b) &&
           std::equal(m->geom_pos + 3 * a, m->geom_pos + 3 * a + 3, m->geom_pos + 3 * b) &&
           std::equal(m->geom_quat + 4 * a, m->geom_quat + 4 * a + 4, m->geom_quat + 4 * b);
  };
  if (model != m) {
    *this = {};
    model = m;
    bool meshes = false;
    for (int g = 0; g < m->ngeom; ++g) {
      const bool invisible = m->geom_matid[g] < 0 && m->geom_rgba[4 * g + 3] == 0.0f;
      const bool known = std::any_of(shapes.begin(), shapes.end(),
                                     [&](const auto& shape) { return same(shape.geom, g); });
      if (invisible || known) continue;
      Shape shape;
      shape.kind = m->geom_type[g];
      shape.geom = g;
      shape.size = Eigen::Map<const Eigen::Vector3d>(m->geom_size + 3 * g);
      shape.radius = m->geom_rbound[g] > 0.0 ? m->geom_rbound[g] : 1e3;  // a plane has none
      meshes = meshes || shape.kind == mjGEOM_MESH;
      shapes.push_back(shape);
    }
    if (meshes) placed.reset(mj_makeData(m), mj_deleteData);
  }
  for (Shape& shape : shapes) {
    shape.p_W = Eigen::Map<const Eigen::Vector3d>(d->geom_xpos + 3 * shape.geom);
    shape.R_WG = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(d->geom_xmat +
                                                                                9 * shape.geom);
  }
  if (!placed) return;
  std::copy_n(d->geom_xpos, 3 * m->ngeom, placed->geom_xpos);
  std::copy_n(d->geom_xmat, 9 * m->ngeom, placed->geom_xmat);
}

}  // namespace impedraw
