#include "impedraw/judge/workpiece.h"

#include <cmath>
#include <numbers>

#include "impedraw/canvas/built_in.h"

namespace impedraw {

namespace {

constexpr double kRadius = 0.30, kHalf = 0.18;  // of the bowl's sphere; of the sheets [m]
constexpr double kRound = 2e-3;                 // of the believed edge [m]
const double kFall = std::tan(10.0 * std::numbers::pi / 180.0);

// A sheet that falls from x = 0 to either side. Its strips beside the edge keep the other normals
// from being smoothed across it.
TriangleMesh strips(const Eigen::Vector3d& p_W, double fall) {
  constexpr double kStrip = 5e-4;  // [m]
  TriangleMesh mesh;
  for (const double x : {-kHalf, -kStrip, 0.0, kStrip, kHalf})
    for (const double y : {-kHalf, kHalf})
      mesh.vertices.push_back(p_W + Eigen::Vector3d(x, y, -fall * std::abs(x)));
  for (int i = 0; i < 8; i += 2) {
    mesh.triangles.emplace_back(i, i + 2, i + 3);
    mesh.triangles.emplace_back(i, i + 3, i + 1);
  }
  return mesh;
}

// Height over the middle and slope, of the believed sheet.
struct Height {
  double z, slope;
};

Height height(Workpiece::Shape shape, double x) {
  if (shape == Workpiece::Shape::flat) return {0.0, 0.0};
  const double round = std::sqrt(x * x + kRound * kRound);
  return {-kFall * (round - kRound), -kFall * x / round};
}

}  // namespace

TriangleMesh Workpiece::mesh() const {
  if (shape != Shape::bowl) return strips(p_W, shape == Shape::roof ? kFall : 0.0);
  CapSettings cap;
  cap.radius = kRadius;
  cap.centre = p_W + kRadius * Eigen::Vector3d::UnitZ();
  cap.opening_radius = kHalf;
  return make_bowl(cap);
}

Workpiece::Place Workpiece::at(double x, double y) const noexcept {
  Place place;
  if (shape == Shape::bowl) {
    place.p_W = {x, y, kRadius - std::sqrt(kRadius * kRadius - x * x - y * y)};
    place.n_W = (kRadius * Eigen::Vector3d::UnitZ() - place.p_W) / kRadius;
  } else {
    const Height h = height(shape, x);
    place.p_W = {x, y, h.z};
    place.n_W = Eigen::Vector3d(-h.slope, 0.0, 1.0).normalized();
  }
  return {p_W + X_WB * place.p_W, X_WB.R * place.n_W};
}

SurfaceEstimate Workpiece::estimate(const Eigen::Vector3d& q_W) const noexcept {
  const Eigen::Vector3d q = X_WB.inverse() * (q_W - p_W);
  SurfaceEstimate found;
  found.status = SurfaceStatus::ok;
  if (shape == Shape::bowl) {
    const Eigen::Vector3d inward = kRadius * Eigen::Vector3d::UnitZ() - q;
    found.distance = kRadius - inward.norm();
    found.n_W = X_WB.R * inward.normalized();
  } else {
    const Height h = height(shape, q.x());
    const Eigen::Vector3d n = Eigen::Vector3d(-h.slope, 0.0, 1.0).normalized();
    found.distance = (q.z() - h.z) * n.z();
    found.n_W = X_WB.R * n;
  }
  return found;
}

}  // namespace impedraw
