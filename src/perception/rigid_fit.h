// The rigid motion that takes marks from their places on a body to where they were found.
#pragma once

#include <span>

#include <Eigen/Core>

#include "impedraw/common/pose.h"

namespace impedraw {

struct RigidFit {
  Pose X_WK;
  Eigen::Vector3d centre_K = Eigen::Vector3d::Zero();  // the marks' centroid [m]
  // Per unit variance of each axis of each mark. Of the centroid's position 1/n; of the rotation
  // vector about it, in W: (Σ |r|² I − r rᵀ)⁻¹ [rad²/m²]. Both are independent of each other.
  double position_variance = 0.0;
  Eigen::Matrix3d rotation_covariance = Eigen::Matrix3d::Zero();
};

// Least squares, min Σ |R p_K + p − p_W|². Exact for noise that is small against the marks' spread.
// Requires spans of the same length, ≥ 3, that are not collinear. Allocates nothing.
// Source: S. Umeyama, "Least-squares estimation of transformation parameters between two point
// patterns", PAMI 1991.
RigidFit fit_rigid(std::span<const Eigen::Vector3d> p_K,
                   std::span<const Eigen::Vector3d> p_W) noexcept;

// Root-mean-square distance of points from the straight line that fits them best [m]: what is left
// to tell a turn about that line. 0 for fewer than three points.
double spread_beside_line(std::span<const Eigen::Vector3d> points) noexcept;

}  // namespace impedraw
