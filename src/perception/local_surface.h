// Local surface fitted to a few points, relative to a query point: equation (19) and a quadric
// refinement.
#pragma once

#include <Eigen/Core>

#include "impedraw/perception/neighbours.h"

namespace impedraw {

enum class SurfaceFit {
  plane,  // as in the paper: through the mean, normal to the smallest eigenvector
  // then z = a + b x + c y + d x² + e x y + f y² over that plane by least squares: removes the
  // plane's curvature bias, r²/4R
  quadric,
};

// n points relative to the query point, one array per coordinate, with weights ≥ 0 [m, m, m, 1].
struct Neighbourhood {
  int n = 0;
  double x[kMostNeighbours], y[kMostNeighbours], z[kMostNeighbours], w[kMostNeighbours];
};

// Weighted covariance C = Σ w (p − μ)(p − μ)ᵀ / Σ w with the weighted mean μ; normal = eigenvector
// of the smallest eigenvalue       (19)
struct LocalSurface {
  // false: the points lie along a line or fill a volume; the other members are then meaningless
  bool is_surface = false;
  // unit normal at the surface point closest to the query, on the side of `towards`
  Eigen::Vector3d n;
  // dn/dp [1/m], symmetric, within the tangent plane: the normal at p + dp is n + bend dp; zero for
  // a plane
  Eigen::Matrix3d bend;
  double distance = 0.0;  // from the surface to the query [m], > 0 on the side of the normal
  // One-sidedness of the points around the query: |μ_t| / sqrt(Σ w |p_t|² / Σ w), _t within the
  // plane. 0 in the middle of a patch, 0.58 to 0.60 on its straight edge, 0.8 at a square corner,
  // → 1 far outside.
  double one_sidedness = 1.0;
  // RMS distance of the points from the fit, weighted [m]: noise, and shape finer than the patch.
  double residual = 0.0;
};

// `towards`: the side to which the normal points, from the points to the camera that saw them.
// Allocates nothing.
LocalSurface fit_surface(const Neighbourhood& points, SurfaceFit fit,
                         const Eigen::Vector3d& towards) noexcept;

}  // namespace impedraw
