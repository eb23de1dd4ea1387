// A calibrated camera's depths as a pinhole camera in the same place would have them: without
// distortion, with one focal length, and the principal point in the middle.
//
// A pixel of the pinhole is the ray d_C = (x, y, 1). It meets the image where Lens::direction_C(u,
// v) is d_C, found once for each pixel. There 1/z is interpolated between the four pixels about (u,
// v): a plane's inverse depth is linear in the image. Where these lie on two surfaces, nothing is
// seen.
#pragma once

#include <vector>

#include "impedraw/capture/lens.h"
#include "impedraw/perception/depth_camera.h"

namespace impedraw {

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
