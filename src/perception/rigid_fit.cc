#include "impedraw/perception/rigid_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace impedraw {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

Vector3d centroid(std::span<const Vector3d> points) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

}  // namespace

RigidFit fit_rigid(std::span<const Vector3d> p_K, std::span<const Vector3d> p_W) noexcept {
  const Vector3d c_K = centroid(p_K), c_W = centroid(p_W);
  Matrix3d H = Matrix3d::Zero();
  for (std::size_t i = 0; i < p_K.size(); ++i) H += (p_W[i] - c_W) * (p_K[i] - c_K).transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // Marks in one plane leave a reflection open.
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  RigidFit fit;
  fit.X_WK.R = svd.matrixU() * Vector3d(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose();
  fit.X_WK.p = c_W - fit.X_WK.R * c_K;
  fit.centre_K = c_K;
  fit.position_variance = 1.0 / static_cast<double>(p_K.size());
  Matrix3d information = Matrix3d::Zero();
  for (const Vector3d& p : p_K) {
    const Vector3d r = fit.X_WK.R * (p - c_K);
    information += r.squaredNorm() * Matrix3d::Identity() - r * r.transpose();
  }
  fit.rotation_covariance = information.inverse();
  return fit;
}

double spread_beside_line(std::span<const Vector3d> points) noexcept {
  if (points.size() < 3) return 0.0;
  const Vector3d c = centroid(points);
  Matrix3d scatter = Matrix3d::Zero();
  for (const Vector3d& p : points) scatter += (p - c) * (p - c).transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(scatter, Eigen::EigenvaluesOnly);
  const double beside = eigen.eigenvalues()[0] + eigen.eigenvalues()[1];
  return std::sqrt(std::max(0.0, beside) / static_cast<double>(points.size()));
}

}  // namespace impedraw
