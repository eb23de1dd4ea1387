#include "impedraw/perception/registration.h"

#include <cmath>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "impedraw/common/rotations.h"

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr double kSettled = 1e-7;      // step at which it ends [m]
constexpr double kMatchReach = 0.02;   // of a match [m]
constexpr double kLeastMatched = 0.3;  // share of the samples

// The normal equations at a pose, rotations in units of 1/radius.
struct Sums {
  Matrix6 H = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
  double weights = 0.0, squares = 0.0;
  int matches = 0;
};

Sums sums_at(const SurfaceModel& model, std::span<const SeenPoint> samples, const Pose& X_WK,
             const Vector3d& c, double radius) noexcept {
  Sums sums;
  const Pose X_KW = X_WK.inverse();
  for (const SeenPoint& s : samples) {
    const SurfaceModel::Point* const q = model.nearest(X_KW * s.p, X_KW.R * s.n);
    if (!q) continue;
    const Vector3d n = X_WK.R * q->n, at = X_WK * q->p;
    const double r = n.dot(s.p - at);
    if (!(std::abs(r) < kMatchReach)) continue;
    const double sigma = std::sqrt(s.deviation * s.deviation + 1.0 / q->weight),
                 off = std::abs(r) / sigma;
    const double w = (off > kHuber ? kHuber / off : 1.0) / (sigma * sigma);
    Vector6 J;
    J << n, (s.p - c).cross(n) / radius;
    sums.H.noalias() += Vector6(w * J) * J.transpose();  // its upper half is exact
    sums.g += w * r * J;
    sums.weights += w;
    sums.squares += r * r;
    ++sums.matches;
  }
  sums.H = sums.H.selfadjointView<Eigen::Upper>();
  return sums;
}

}  // namespace

OpenDirection open_direction(const Vector6& e, const Vector3d& c, double radius) noexcept {
  const Vector3d t = e.head<3>(), phi = e.tail<3>() / radius;
  OpenDirection open;
  if (e.tail<3>().norm() < 0.1) {
    open.axis_W = t.normalized();
    return open;
  }
  open.axis_W = phi.normalized();
  open.point_W = c + phi.cross(t) / phi.squaredNorm();
  open.pitch = open.axis_W.dot(t) / phi.norm();
  open.kind =
      std::abs(open.pitch) < 0.1 * radius ? OpenDirection::Kind::turn : OpenDirection::Kind::screw;
  return open;
}

std::string OpenDirection::text() const {
  const auto vector = [](const Vector3d& v) {
    return fmt::format("({:.2f}, {:.2f}, {:.2f})", v.x(), v.y(), v.z());
  };
  if (kind == Kind::slide) return fmt::format("slides along {}", vector(axis_W));
  const std::string turn =
      fmt::format("turns about {} through {} m", vector(axis_W), vector(point_W));
  return kind == Kind::turn ? turn : fmt::format("{} with a pitch of {:.3f} m/rad", turn, pitch);
}

ShapeRegistration register_samples(const SurfaceModel& model, std::span<const SeenPoint> samples,
                                   const Pose& X_WK_predicted, int iterations) noexcept {
  ShapeRegistration result;
  result.X_WK = X_WK_predicted;
  if (samples.empty()) return result;
  for (const SeenPoint& s : samples) result.c_W += s.p;
  result.c_W /= static_cast<double>(samples.size());
  double radius = 0.0;
  for (const SeenPoint& s : samples) radius += (s.p - result.c_W).squaredNorm();
  radius = std::max(1e-3, std::sqrt(radius / static_cast<double>(samples.size())));

  Sums sums;
  Eigen::SelfAdjointEigenSolver<Matrix6> eigen;
  for (int i = 0; i <= iterations; ++i) {
    sums = sums_at(model, samples, result.X_WK, result.c_W, radius);
    result.matches = sums.matches;
    if (sums.matches < kLeastMatches ||
        sums.matches < kLeastMatched * static_cast<double>(samples.size()))
      return result;
    eigen.compute(sums.H);
    result.open = 0;
    Vector6 step = Vector6::Zero();
    for (int k = 0; k < 6; ++k) {
      const double share = eigen.eigenvalues()[k] / sums.weights;
      result.eigenvalues[static_cast<std::size_t>(k)] = share;
      if (share < kLeastEigenvalue) {
        ++result.open;
      } else {
        const Vector6 e = eigen.eigenvectors().col(k);
        step += (e.dot(sums.g) / eigen.eigenvalues()[k]) * e;
      }
    }
    if (i == iterations || step.norm() < kSettled) break;
    const Eigen::Matrix3d turn = rotation(step.tail<3>() / radius);
    result.X_WK.p = turn * (result.X_WK.p - result.c_W) + result.c_W + step.head<3>();
    result.X_WK.R = Eigen::Quaterniond(turn * result.X_WK.R).normalized().toRotationMatrix();
  }
  result.rms = std::sqrt(sums.squares / sums.matches);
  Vector6 unscaled;
  unscaled << 1.0, 1.0, 1.0, radius, radius, radius;
  for (int k = 0; k < 6; ++k) {
    const Vector6 e = eigen.eigenvectors().col(k);
    if (k < result.open) {
      result.open_directions[static_cast<std::size_t>(k)] = open_direction(e, result.c_W, radius);
    } else {
      const Vector6 scaled = unscaled.cwiseProduct(e);
      result.information += eigen.eigenvalues()[k] * scaled * scaled.transpose();
    }
  }
  result.found = true;
  return result;
}

}  // namespace impedraw
