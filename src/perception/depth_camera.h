// A pinhole depth camera, its image, and rendering.
//
// Camera frame C: origin at the pinhole, z forward, x to the right of the image, y down. The focal
// length in pixels, in both directions, is
//   f = (height / 2) / tan(fov_y / 2). The principal point is the middle of the image.
// The ray of pixel (i, j), column i and row j from 0 at the top left, passes through its middle:
//   d_C(i, j) = ((i + ½ − width/2)/f, (j + ½ − height/2)/f, 1),   point p_C = depth · d_C.
// Without the halves, every point is off by half a pixel (1 mm at 1 m). In a bowl this lifts the
// whole cloud off the surface.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/common/pose.h"
#include "impedraw/common/range.h"

namespace impedraw {

struct DepthCamera {
  int width = 640;          // [px]
  int height = 480;         // [px]
  double fov_y_deg = 60.0;  // full vertical field of view [deg]
  Pose X_WC = {};

  struct Limits {
    static constexpr Limit width = {"width", "px", {1, 8192}};
    static constexpr Limit height = {"height", "px", {1, 8192}};
    static constexpr Limit fov_y = {"fov_y", "deg", {1.0, 170.0}};
  };

  double focal_length() const;                      // f [px]
  Eigen::Vector3d direction_C(int i, int j) const;  // d_C of pixel (i, j): z is 1
};

// Throws InputError naming the value if the size or field of view is out of range, or if the pose
// is not finite.
void validate(const DepthCamera& camera);

// Returns the pose X_WC of a camera at eye with target in the middle of its image and W's z upward
// (W's x if it looks along z). Throws InputError if the two points coincide.
Pose look_at(const Eigen::Vector3d& eye_W, const Eigen::Vector3d& target_W);

// Three cameras 0.5 m from the standard bowl's axis at azimuths 0°, 120°, 240° from +x, z = 0.90 m,
// aimed at the bowl's lowest point.
std::vector<DepthCamera> standard_cameras();

struct DepthImage {
  int width = 0;
  int height = 0;
  std::vector<double> depth;  // row by row: along C's z, not along the ray [m]; NaN: no surface

  double at(int i, int j) const { return depth[static_cast<std::size_t>(j) * width + i]; }
};

// Noise of a stereo or structured-light camera. Such a camera measures disparity, 1/depth. A
// constant error of disparity gives an error of depth that grows as depth².
//   depth ← depth + sigma_at_1m · depth² · N(0, 1),   independent for each pixel.
// Depths in metres. The default, zero, is a perfect camera; a stereo camera's steps are those of
// stereo_faults.h.
struct DepthNoise {
  double sigma_at_1m = 0.0;  // [m]

  struct Limits {
    static constexpr Limit sigma_at_1m = {"sigma_at_1m", "m", {0.0, 0.1}};
  };
};

// 1 mm at 1 m.
DepthNoise realistic_depth_noise();

// Distance from the origin along the unit direction to the nearest object, canvas or arm [m];
// infinity if there is none. Called from several threads at once.
using CastRay =
    std::function<double(const Eigen::Vector3d& origin_W, const Eigen::Vector3d& direction_W)>;

// The same along many directions from one origin, those of neighbouring pixels.
using CastRays =
    std::function<void(const Eigen::Vector3d& origin_W,
                       std::span<const Eigen::Vector3d> directions_W, std::span<double> distances)>;

// Columns and rows of an image: from the first to before the end [px].
struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;
};

// The pixels whose rays may meet a box in W, and a few beside it. Only where all of it is before
// the camera; else all pixels.
PixelBox pixels_of(const DepthCamera& camera, const Eigen::AlignedBox3d& box, const Pose& X_WB);

// The same seed gives the same image for any number of threads (0: one per core), because a pixel's
// noise depends only on (seed, pixel). Use a different seed for each camera. Throws InputError
// naming a bad setting.
DepthImage render_depth(const DepthCamera& camera, const CastRay& cast_ray,
                        const DepthNoise& noise = {}, std::uint64_t seed = 0, int threads = 0);
DepthImage render_depth(const DepthCamera& camera, const CastRays& cast_rays,
                        const DepthNoise& noise = {}, std::uint64_t seed = 0, int threads = 0);
// The same into an image of the camera's size, in this thread; what is beside `part` sees nothing.
// Allocates nothing where the image was used before. The camera must be valid.
void render_depth(const DepthCamera& camera, const CastRays& cast_rays, const DepthNoise& noise,
                  std::uint64_t seed, const PixelBox& part, DepthImage* image);

}  // namespace impedraw
