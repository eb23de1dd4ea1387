// Points and normals of a depth image, from windows of its pixels.
//
// A plane n·p = d in the camera's frame has, on the ray (u, v, 1), the inverse depth
//   1/z = (n_x u + n_y v + n_z) / d,
// linear in u and v. A camera that measures disparity has the same noise of 1/z in every pixel
// (DepthNoise). So 1/z is fitted by a quadric in u and v over a window, by least squares: neither
// slope nor curvature of the surface biases the fit at the window's middle, and no weights are
// needed. The gradient there gives the normal, n ∝ (a, b, c − a u − b v).
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "impedraw/common/range.h"
#include "impedraw/perception/cloud.h"
#include "impedraw/perception/depth_camera.h"

namespace impedraw {

// A point of a surface that was seen.
struct SeenPoint {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();  // [m]
  Eigen::Vector3d n = Eigen::Vector3d::Zero();  // unit, towards the camera
  double deviation = 0.0;                       // standard deviation of p along n [m]
};

struct OrganisedSettings {
  int stride = 4;       // from one window's middle to the next one's [px]
  int half_window = 4;  // a window has (2 half_window + 1)² pixels
  // Pixels of a window whose depth differs by more from its middle's are another surface's [m].
  double jump = 0.04;
  double sigma_at_1m = 1e-3;  // noise of the depth at 1 m [m]
  // Pixels that a window must have, of all.
  double least_share = 0.5;
};

// Keeps what it needs from image to image.
class OrganisedPoints {
 public:
  // Throws InputError naming the setting.
  explicit OrganisedPoints(const OrganisedSettings& settings = {});

  // Appends the image's samples to `out`, in W, by the camera's pose. Samples outside of `region`
  // and those within `padding` of the arm [m] are left out. Where it changes from image to image,
  // `phase` shifts the windows, through all pixels in stride² images: a standing camera then sees
  // more than the points of one grid. Allocates only where `out` grows.
  void find(const DepthImage& image, const DepthCamera& camera, const Eigen::AlignedBox3d& region,
            std::span<const Capsule> arm, double padding, std::vector<SeenPoint>* out,
            unsigned phase = 0) const;

 private:
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  using Matrix6d = Eigen::Matrix<double, 6, 6>;
  struct Pixel {
    Vector6d basis;  // 1 x y x² xy y², in pixels over the half window
    int i, j;        // from the middle
  };

  OrganisedSettings settings_;
  std::vector<Pixel> window_;
  Matrix6d whole_inverse_;  // of the whole window's Σ basis basisᵀ
};

}  // namespace impedraw
