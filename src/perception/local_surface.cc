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
  double s10 = 0, s01 = 0, s20 = 0, s11 = 0, s02 = 0, s30 = 0, s21 = 0, s12 = 0, s03 = 0, s40 = 0,
         s31 = 0, s22 = 0, s13 = 0, s04 = 0;
  double s00 = 0, t00 = 0, t10 = 0, t01 = 0, t20 = 0, t11 = 0, t02 = 0, zz = 0;
  for (int i = 0; i < p.n; ++i) {
    const double x = A(0, 0) * p.x[i] + A(0, 1) * p.y[i] + A(0, 2) * p.z[i];
    const double y = A(1, 0) * p.x[i] + A(1, 1) * p.y[i] + A(1, 2) * p.z[i];
    const double z = A(2, 0) * p.x[i] + A(2, 1) * p.y[i] + A(2, 2) * p.z[i];
    const double w = p.w[i];
    const double wx = w * x, wy = w * y, xx = x * x, xy = x * y, yy = y * y;
    s00 += w, s10 += wx, s01 += wy;
    t00 += w * z, t10 += wx * z, t01 += wy * z, zz += w * z * z;
    const double wxx = w * xx, wxy = w * xy, wyy = w * yy;
    s20 += wxx, s11 += wxy, s02 += wyy;
    t20 += wxx * z, t11 += wxy * z, t02 += wyy * z;
    s30 += wxx * x, s21 += wxx * y, s12 += wyy * x, s03 += wyy * y;
    s40 += wxx * xx, s31 += wxx * xy, s22 += wxx * yy, s13 += wyy * xy, s04 += wyy * yy;
  }
  Eigen::Matrix<double, 6, 6> N;
  N << s00, s10, s01, s20, s11, s02,  //
      s10, s20, s11, s30, s21, s12,   //
      s01, s11, s02, s21, s12, s03,   //
      s20, s30, s21, s40, s31, s22,   //
      s11, s21, s12, s31, s22, s13,   //
      s02, s12, s03, s22, s13, s04;
  N /= s00;
  q << t00, t10, t01, t20, t11, t02;
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
  double s = 0, sx = 0, sy = 0, sz = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (int i = 0; i < p.n; ++i) {
    const double wx = p.w[i] * p.x[i], wy = p.w[i] * p.y[i], wz = p.w[i] * p.z[i];
    s += p.w[i], sx += wx, sy += wy, sz += wz;
    xx += wx * p.x[i], xy += wx * p.y[i], xz += wx * p.z[i], yy += wy * p.y[i], yz += wy * p.z[i],
        zz += wz * p.z[i];
  }
  if (!(s > 0.0)) return surface;
  const Vector3d mean = Vector3d(sx, sy, sz) / s;
  Matrix3d second;
  second << xx, xy, xz, xy, yy, yz, xz, yz, zz;
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
