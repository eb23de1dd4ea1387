// Converts depth images to one point cloud in the world frame: back-projection, removal of the arm,
// cropping, fusion, thinning.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/common/range.h"
#include "impedraw/perception/depth_camera.h"

namespace impedraw {

struct PointCloud {
  std::vector<Eigen::Vector3d> points;  // [m], W
  // Unit, W, towards the camera. Empty until a SurfaceEstimator fills them; NaN where it fails.
  std::vector<Eigen::Vector3d> normals;
  std::vector<double> weight;         // number of pixels averaged into each point; empty: one each
  std::vector<int> camera;            // index into eyes of a camera that saw the point
  std::vector<Eigen::Vector3d> eyes;  // p_WC of each camera [m]
  std::vector<std::uint8_t> rgb;      // three bytes a point; may be empty
};

// Appends point i with its camera, weight and colour; a normal is for an estimator to find.
void append(const PointCloud& from, std::size_t i, PointCloud* to);

// 0xRRGGBB of each point; empty without colours.
inline std::vector<int> packed_colours(const PointCloud& cloud) {
  std::vector<int> packed;
  for (std::size_t i = 0; i + 2 < cloud.rgb.size(); i += 3)
    packed.push_back(cloud.rgb[i] << 16 | cloud.rgb[i + 1] << 8 | cloud.rgb[i + 2]);
  return packed;
}

// All points within radius of the segment from a to b: the self filter's model of an arm link.
struct Capsule {
  Eigen::Vector3d a_W = Eigen::Vector3d::Zero();  // [m]
  Eigen::Vector3d b_W = Eigen::Vector3d::Zero();  // [m]; may equal a_W: a sphere
  double radius = 0.0;                            // [m], ≥ 0
};

// True if p is in it, or within `padding` of it [m].
bool inside(const Capsule& capsule, double padding, const Eigen::Vector3d& p) noexcept;

struct CloudSettings {
  // Side of the cubes in which points are averaged [m]; 0 keeps every point. On a surface with
  // radius of curvature R, a cube's mean is off by about voxel²/(12 R): 4 µm inside the standard
  // bowl for 4 mm.
  double voxel = 0.004;
  // Region of interest [m], W: only points inside are kept. Everywhere by default.
  Eigen::AlignedBox3d region{Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity()),
                             Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity())};
  // Points within this distance of an arm capsule are removed too [m]. Covers depth noise and
  // parts of the arm outside the capsules.
  double self_padding = 0.01;

  struct Limits {
    static constexpr Limit voxel = {"voxel", "m", {0.0, 0.1}};
    static constexpr Limit self_padding = {"self_padding", "m", {0.0, 0.2}};
  };
};

// Returns every image point inside the region and outside the arm, in the order of images and
// pixels. Throws InputError naming a bad setting, or the camera whose image size differs.
PointCloud back_project(const std::vector<DepthImage>& images,
                        const std::vector<DepthCamera>& cameras, const CloudSettings& settings,
                        const std::vector<Capsule>& arm = {});

// Returns one point for each occupied cube of the grid (corners at whole multiples of voxel): the
// mean of its points (weighted if they have weights), their total weight, and the camera that saw
// most of them. Ordered by cube, x outermost. voxel = 0 returns the cloud unchanged. With depth
// noise, a cube at the surface's fringe may hold one stray pixel while its neighbours hold ten.
// Fits must therefore use the weights. Throws InputError if voxel is negative or too small for the
// extent.
PointCloud thin(const PointCloud& cloud, double voxel);

// back_project, then thin.
PointCloud fuse(const std::vector<DepthImage>& images, const std::vector<DepthCamera>& cameras,
                const CloudSettings& settings = {}, const std::vector<Capsule>& arm = {});

}  // namespace impedraw
