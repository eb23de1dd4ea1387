// Faults of a stereo depth camera, beyond those of its pose and noise that is independent in each
// pixel. Each has a published value, and all grow with one factor.
//
// A pixel that is believed to look along d_C = (x, y, 1) looks along
//   (c_x + x (1 + ε + k r²), c_y + y (1 + ε + k r²), 1),   r² = x² + y²
// and where the surface is at depth z along C's z axis, it measures
//   z' = (1 + b) z + σ₁ z² c,   then 1/z' is rounded to whole multiples of q = δ / (f B)
// σ₁ = σ_d / (f B) is DepthNoise::sigma_at_1m, the error of a disparity over focal length and
// baseline. c is Gaussian of unit variance that hangs together over some pixels, since a matcher
// compares windows. The camera's own ε, c_x, c_y, k and b come from its seed. Beside a step in
// depth pixels measure something between both sides; steep surfaces, and a few pixels anywhere, are
// not measured.
//
// Values at factor 1:
//   ε, c, k  SD 0.17 %, 0.71 px of 640, 0.0037: what five views of a board leave of a calibration
//            (Z. Zhang, "A flexible new technique for camera calibration", PAMI 2000, table 1)
//   b        SD 0.25 %, an eighth of what the data sheet of Intel's D400 series allows at 2 m
//            (337029-013): calibrate-camera refuses depths that are 1 % off
//   δ, f B   1/32 px, and 421 px × 50 mm of a D435 (A. Grunnet-Jepsen et al., "Subpixel linearity
//            improvement for RealSense D400", 2019); smaller images are thinned from these
//   c        smoothed with a standard deviation of 1.5 px: windows of 7 × 7 px (L. Keselman et al.,
//            "RealSense stereoscopic depth cameras", CVPR workshops 2017)
//   dropout  70 % beyond 75° between ray and normal (C. Nguyen et al., "Modeling Kinect sensor
//            noise", 3DIMPVT 2012: little is measured beyond 70° to 80°), and 1 % of all pixels
//   flying   70 % of the pixels beside a step of 20 mm and more (A. Handa et al., "A benchmark for
//            RGB-D visual odometry", ICRA 2014, displaces pixels by about as much)
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "impedraw/perception/depth_camera.h"

namespace impedraw {

class StereoFaults {
 public:
  StereoFaults() = default;  // none
  // The faults of the camera with this seed.
  StereoFaults(double factor, std::uint64_t seed);

  bool any() const { return factor_ > 0.0; }
  // The true direction of a pixel that is believed to look along d_C, whose z is 1.
  Eigen::Vector3d seen_along(const Eigen::Vector3d& d_C) const;
  // Rays of `camera`'s pixels as they are believed, cast along what they see. The result refers to
  // `cast_rays`.
  CastRays bent(const DepthCamera& camera, const CastRays& cast_rays) const;
  // The place at which a mark at p_C is found [m].
  Eigen::Vector3d found_at(const Eigen::Vector3d& p_C) const;
  // Makes exact depths, of the bent rays, what is measured. Pixels beside `part` see nothing. The
  // same for the same seed.
  void disturb(double sigma_at_1m, std::uint64_t seed, const PixelBox& part,
               const DepthCamera& camera, DepthImage* image) const;

 private:
  double factor_ = 0.0;
  double focal_ = 0.0, radial_ = 0.0, bias_ = 0.0;  // ε, k, b
  Eigen::Vector2d principal_ = Eigen::Vector2d::Zero();
};

}  // namespace impedraw
