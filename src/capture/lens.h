// A calibrated camera: focal lengths, principal point and distortion.
//
// Pixel (i, j), column and row from 0 at the top left, has its centre at (i, j) in the units of cx
// and cy (OpenCV, RealSense). With x' = (i − cx)/fx and y' = (j − cy)/fy, the ray of a pixel is
// d_C = (x, y, 1), where (x', y') and (x, y) are the distorted and the ideal point:
//   D(a) = a (1 + k1 r² + k2 r⁴ + k3 r⁶) + (2 p1 a_x a_y + p2 (r² + 2 a_x²),
//                                           p1 (r² + 2 a_y²) + 2 p2 a_x a_y),   r = |a|
//   brown_conrady          (x', y') = D(x, y)      as OpenCV; inverted by Newton's method
//   inverse_brown_conrady  (x, y) = D(x', y')      as RealSense's depth streams
// Source: D. Brown, "Decentering distortion of lenses", 1966.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "impedraw/common/range.h"
#include "impedraw/perception/depth_camera.h"

namespace impedraw {

struct Lens {
  enum class Model { none, brown_conrady, inverse_brown_conrady };

  int width = 0, height = 0;  // [px]
  double fx = 0, fy = 0;      // focal lengths [px]
  double cx = 0, cy = 0;      // principal point [px]
  Model model = Model::none;
  std::array<double, 5> k{};  // k1, k2, p1, p2, k3

  struct Limits {
    static constexpr Limit size = {"size", "px", {1, 8192}};
    static constexpr Limit focal_length = {"focal_length", "px", Range::positive_to(1e5)};
  };

  // d_C of a place on the image, z is 1; absent where the distortion cannot be inverted.
  std::optional<Eigen::Vector3d> direction_C(double i, double j) const;
};

// A calibrated camera's depths as a pinhole camera in the same place would have them: without
// distortion, with one focal length, and the principal point in the middle.
//
// A pixel of the pinhole is the ray d_C = (x, y, 1). It meets the image where Lens::direction_C(u,
// v) is d_C, found once for each pixel. There 1/z is interpolated between the four pixels about (u,
// v): a plane's inverse depth is linear in the image. Where these lie on two surfaces, nothing is
// seen.
class Rectified {
 public:
  // Images of `width` × `height`, which see as high as the lens does, from a camera at X_WC.
  Rectified(const Lens& lens, const Pose& X_WC, int width, int height);

  const DepthCamera& camera() const { return camera_; }
  // Allocates nothing where the image was used before.
  void depths(const DepthImage& seen, DepthImage* rectified) const;

 private:
  DepthCamera camera_;
  int seen_width_, seen_height_;
  std::vector<Eigen::Vector2f> places_;  // (u, v) of each pixel; NaN: not in the image
};

}  // namespace impedraw
