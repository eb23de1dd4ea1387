// Depth images → one point cloud in the world frame: back-projected, the arm taken out, cropped,
// fused, thinned.
#pragma once

#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/common/range.h"
#include "impedraw/perception/depth_camera.h"

namespace impedraw {

struct PointCloud {
  std::vector<Eigen::Vector3d> points;  // [m], W
  std::vector<Eigen::Vector3d>
      // unit, W, towards the camera; empty until a SurfaceEstimator fills them; NaN where it could
      // not
      normals;
  std::vector<double> weight;  // of each point: how many pixels it is the mean of; empty: one each
  std::vector<int> camera;     // of each point: a camera that saw it, into eyes
  std::vector<Eigen::Vector3d> eyes;  // p_WC of each camera [m]
};

// All that is within radius of the segment from a to b: a link of the arm, as the self filter sees
// it.
struct Capsule {
  Eigen::Vector3d a_W = Eigen::Vector3d::Zero();  // [m]
  Eigen::Vector3d b_W = Eigen::Vector3d::Zero();  // [m]; may equal a_W: a sphere
  double radius = 0.0;                            // [m], ≥ 0
};

struct CloudSettings {
  // Side of the cubes in which points are averaged [m]; 0 keeps every point. On a surface of
  // curvature radius R the mean of a cube lies off by about voxel²/(12 R): 4 µm inside the standard
  // bowl for 4 mm.
  double voxel = 0.004;
  // Region of interest [m], W: only points inside are kept. Everywhere by default.
  Eigen::AlignedBox3d region{Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity()),
                             Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity())};
  // Points nearer than this to a capsule of the arm go with it [m]: covers depth noise, and
  // what the capsules leave of the arm.
  double self_padding = 0.01;

  struct Limits {
    static constexpr Range voxel = {0.0, 0.1};
    static constexpr Range self_padding = {0.0, 0.2};
  };
};

// Every point of every image that is inside the region and outside the arm, in the order of images
// and pixels. Throws InputError naming a bad setting, or the camera whose image has another size.
PointCloud back_project(const std::vector<DepthImage>& images,
                        const std::vector<DepthCamera>& cameras, const CloudSettings& settings,
                        const std::vector<Capsule>& arm = {});

// One point for each cube of the grid (corners at whole multiples of voxel) that holds any: their
// mean (weighted where they have weights), their weight, and the camera that saw most of them. With
// depth noise a cube on the fringe of the surface may hold one stray pixel, beside cubes that hold
// ten: fits must go by weight. Ordered by cube, x outermost. voxel = 0 returns the cloud as it is.
// Throws InputError where voxel is negative, or too small for the extent.
PointCloud thin(const PointCloud& cloud, double voxel);

// back_project, then thin.
PointCloud fuse(const std::vector<DepthImage>& images, const std::vector<DepthCamera>& cameras,
                const CloudSettings& settings = {}, const std::vector<Capsule>& arm = {});

}  // namespace impedraw
