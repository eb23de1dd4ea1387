#include "impedraw/capture/lens.h"

#include <Eigen/LU>

namespace impedraw {

namespace {

using Eigen::Vector2d;

struct Distorted {
  Vector2d value;
  Eigen::Matrix2d derivative;
};

// D(a) and ∂D/∂a.
Distorted distort(const std::array<double, 5>& c, const Vector2d& a) {
  const auto& [k1, k2, p1, p2, k3] = c;
  const double x = a.x(), y = a.y(), r2 = a.squaredNorm();
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = k1 + r2 * (2 * k2 + 3 * r2 * k3);  // of `radial` by r²
  Distorted d;
  d.value = {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
             y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  d.derivative(0, 0) = radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x;
  d.derivative(1, 1) = radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x;
  d.derivative(0, 1) = d.derivative(1, 0) = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;
  return d;
}

}  // namespace

std::optional<Eigen::Vector3d> Lens::direction_C(double i, double j) const {
  constexpr int kIterations = 30;
  constexpr double kTolerance = 1e-12;
  const Vector2d seen((i - cx) / fx, (j - cy) / fy);
  if (model == Model::none) return Eigen::Vector3d(seen.x(), seen.y(), 1);
  if (model == Model::inverse_brown_conrady) {
    const Vector2d ideal = distort(k, seen).value;
    return Eigen::Vector3d(ideal.x(), ideal.y(), 1);
  }
  Vector2d ideal = seen;
  for (int step = 0; step < kIterations; ++step) {
    const Distorted d = distort(k, ideal);
    const Vector2d error = d.value - seen;
    // Beyond the fold of the polynomial, a point of the image belongs to no ray.
    if (!error.allFinite() || d.derivative.determinant() <= 0) return std::nullopt;
    if (error.norm() < kTolerance) return Eigen::Vector3d(ideal.x(), ideal.y(), 1);
    ideal -= d.derivative.inverse() * error;
  }
  return std::nullopt;
}

}  // namespace impedraw
