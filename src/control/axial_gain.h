// Gains in the surface frame S (z = n), equal along both tangents, rotated to W:
//
//   R_WS diag(k_t, k_t, k_n) R_WSᵀ = k_t (I − n nᵀ) + k_n n nᵀ
//
// The heading of S about n cancels, so no frame has to be transported across the surface.
// n must be a unit vector.
#pragma once

#include "impedraw/common/pose.h"

namespace impedraw {

struct AxialGain {
  double tangent = 0.0;  // along both tangents, or about them
  double normal = 0.0;   // along n, or about it

  Eigen::Vector3d apply(const Eigen::Vector3d& n_W, const Eigen::Vector3d& x_W) const {
    return tangent * x_W + ((normal - tangent) * n_W.dot(x_W)) * n_W;
  }
  Eigen::Matrix3d matrix(const Eigen::Vector3d& n_W) const {
    return tangent * Eigen::Matrix3d::Identity() + (normal - tangent) * n_W * n_W.transpose();
  }
};

// A 6×6 gain, block-diagonal in its linear and angular parts.
struct TipGain {
  AxialGain linear;   // N/m, N s/m or kg
  AxialGain angular;  // Nm/rad, Nm s/rad or kg m²

  Vector6 apply(const Eigen::Vector3d& n_W, const Vector6& x) const {
    Vector6 y;
    y << linear.apply(n_W, x.head<3>()), angular.apply(n_W, x.tail<3>());
    return y;
  }
  // Along an axis without gain it has none either: where nothing damps, nothing is stiff.
  TipGain inverse() const {
    const auto each = [](double gain) { return gain > 0.0 ? 1.0 / gain : 0.0; };
    return {{each(linear.tangent), each(linear.normal)},
            {each(angular.tangent), each(angular.normal)}};
  }
};

}  // namespace impedraw
