#include "impedraw/perception/local_surface.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace impedraw {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Pair = Eigen::Array2d;

// Ratios of the variances along the eigenvectors for points that define a plane: not a line (middle
// to largest), not a ball (smallest to middle).
constexpr double kLeastWidth = 0.01;
constexpr double kMostThickness = 0.3;

// Coefficients a … f of z = a + b x + c y + d x² + e x y + f y². Lengths are in units of `scale`,
// so that all coefficients have similar magnitude.
using Quadric = Eigen::Matrix<double, 6, 1>;

// The normal equations need Σ w x^i y^j for i + j ≤ 4 and Σ w z x^i y^j for i + j ≤ 2.
// residual2: mean squared residual, Σ w (z − q(x, y))² / Σ w = Σ w z²/Σ w − q · t for the least
// squares solution.
bool fit_quadric(const Neighbourhood& p, const Matrix3d& axes, double scale, Quadric& q,
                 double& residual2) {
  const Matrix3d A = axes.transpose() / scale;
  const Pair ax = A.col(0).head<2>(), ay = A.col(1).head<2>(), az = A.col(2).head<2>();
  // The sums that x and y exchange, side by side: s1 is s10 and s01, s21 is s21 and s12.
  Pair s1 = Pair::Zero(), s2 = s1, s3 = s1, s21 = s1, s4 = s1, s31 = s1, t1 = s1, t2 = s1;
  double s00 = 0, s11 = 0, s22 = 0, t00 = 0, t11 = 0, zz = 0;
  for (int i = 0; i < p.n; ++i) {
    const Pair u = ax * p.x[i] + ay * p.y[i] + az * p.z[i];  // x and y
    const double z = A(2, 0) * p.x[i] + A(2, 1) * p.y[i] + A(2, 2) * p.z[i];
    const double w = p.w[i], xy = u[0] * u[1], wxy = w * xy;
    const Pair wu = w * u, uu = u * u, wuu = w * uu;
    s00 += w, t00 += w * z, zz += w * z * z, s11 += wxy, t11 += wxy * z;
    s1 += wu, t1 += wu * z, s2 += wuu, t2 += wuu * z;
    s3 += wuu * u, s21 += wuu * Pair(u[1], u[0]);
    s4 += wuu * uu, s31 += wuu * xy, s22 += wuu[0] * uu[1];
  }
  Eigen::Matrix<double, 6, 6> N;
  N << s00, s1[0], s1[1], s2[0], s11, s2[1],     //
      s1[0], s2[0], s11, s3[0], s21[0], s21[1],  //
      s1[1], s11, s2[1], s21[0], s21[1], s3[1],  //
      s2[0], s3[0], s21[0], s4[0], s31[0], s22,  //
      s11, s21[0], s21[1], s31[0], s22, s31[1],  //
      s2[1], s21[1], s3[1], s22, s31[1], s4[1];
  N /= s00;
  q << t00, t1[0], t1[1], t2[0], t11, t2[1];
  q /= s00;
  const Eigen::LLT<Eigen::Matrix<double, 6, 6>> llt(N);
  if (llt.info() != Eigen::Success || llt.matrixLLT().diagonal().minCoeff() < 1e-3) return false;
  const Quadric t = q;
  llt.solveInPlace(q);
  residual2 = std::max(0.0, zz / s00 - q.dot(t));
  return true;
}

// Foot of the perpendicular from the origin (the query) to the quadric: one Newton step starting
// above the query. One step suffices because the slope relative to the fitted plane is small.
Vector2d foot(const Quadric& q) {
  Matrix2d H;
  H << 1.0 + 2.0 * q[0] * q[3], q[0] * q[4], q[0] * q[4], 1.0 + 2.0 * q[0] * q[5];
  const Vector2d slope(q[1], q[2]);
  H += slope * slope.transpose();
  if (!(H.determinant() > 0.1 && H.trace() > 0.0))
    return Vector2d::Zero();  // near or beyond the centre of curvature
  return -q[0] * (H.inverse() * slope);
}

}  // namespace

LocalSurface fit_surface(const Neighbourhood& p, SurfaceFit fit, const Vector3d& towards) noexcept {
  LocalSurface surface;
  Pair s1 = Pair::Zero(), s2 = s1, sz = s1;  // of x and y: alone, squared, times z
  double s = 0, z = 0, xy = 0, zz = 0;
  for (int i = 0; i < p.n; ++i) {
    const Pair u(p.x[i], p.y[i]), wu = p.w[i] * u;
    const double wz = p.w[i] * p.z[i];
    s += p.w[i], z += wz, xy += wu[0] * u[1], zz += wz * p.z[i];
    s1 += wu, s2 += wu * u, sz += wu * p.z[i];
  }
  if (!(s > 0.0)) return surface;
  const Vector3d mean = Vector3d(s1[0], s1[1], z) / s;
  Matrix3d second;
  second << s2[0], xy, sz[0], xy, s2[1], sz[1], sz[0], sz[1], zz;
  second /= s;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen = [&] {
    Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
    solver.computeDirect(second - mean * mean.transpose());
    return solver;
  }();
  const Vector3d& variance = eigen.eigenvalues();
  if (!(variance[1] > kLeastWidth * variance[2] && variance[0] < kMostThickness * variance[1]))
    return surface;

  Matrix3d axes;  // columns x, y, z of the plane's frame, in W
  axes.col(2) = eigen.eigenvectors().col(0);
  if (axes.col(2).dot(towards) < 0.0) axes.col(2) = -axes.col(2);
  axes.col(0) = eigen.eigenvectors().col(2);
  axes.col(1) = axes.col(2).cross(axes.col(0));
  const Vector3d mean_in = axes.transpose() * mean;
  const double reach =
      std::sqrt(axes.col(0).dot(second * axes.col(0)) + axes.col(1).dot(second * axes.col(1)));
  surface.is_surface = reach > 0.0;
  surface.one_sidedness = mean_in.head<2>().norm() / reach;
  surface.n = axes.col(2);
  surface.bend.setZero();
  surface.distance = -mean_in.z();
  surface.residual = std::sqrt(std::max(0.0, variance[0]));
  Quadric q;
  double residual2 = 0.0;
  if (fit == SurfaceFit::plane || !fit_quadric(p, axes, reach, q, residual2)) return surface;
  surface.residual = reach * std::sqrt(residual2);

  const Vector2d at = foot(q);
  const double x = at.x(), y = at.y();
  const Vector3d on(x, y, q[0] + q[1] * x + q[2] * y + q[3] * x * x + q[4] * x * y + q[5] * y * y);
  const Vector3d n =
      Vector3d(-q[1] - 2.0 * q[3] * x - q[4] * y, -q[2] - q[4] * x - 2.0 * q[5] * y, 1.0)
          .normalized();
  Matrix2d second_derivative;
  second_derivative << 2.0 * q[3], q[4], q[4], 2.0 * q[5];
  surface.n = axes * n;
  surface.bend = axes.leftCols<2>() * (-second_derivative / reach) * axes.leftCols<2>().transpose();
  surface.distance = -n.dot(on) * reach;
  return surface;
}

}  // namespace impedraw
