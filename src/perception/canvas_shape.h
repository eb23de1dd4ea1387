// The canvas's own shape in frames: where it is, by registration to what was seen of it before, and
// a surface that grows with each frame.
//
// Starts from what a snapshot saw, in the canvas's frame K. A frame's depths become samples
// (organised_points.h), which are registered from the predicted pose (registration.h). fuse() adds
// them where they belong.
#pragma once

#include <vector>

#include "impedraw/perception/canvas_frame.h"
#include "impedraw/perception/organised_points.h"
#include "impedraw/perception/registration.h"
#include "impedraw/perception/surface_model.h"

namespace impedraw {

struct CanvasShapeSettings {
  double voxel = 0.006;  // of the model [m]
  OrganisedSettings points;
  // Samples beyond this from the model's box, moved with the canvas, are not of it [m].
  double margin = 0.02;
  double self_padding = 0.01;  // to the arm [m]
};

class CanvasShape {
 public:
  // `seen`: with normals. Throws InputError naming a setting, or that there are too few points.
  CanvasShape(const PointCloud& seen, const CanvasShapeSettings& settings);

  // The canvas's pose by the frame's depths; not found without depths. Allocates only while the
  // samples' number grows.
  const ShapeRegistration& look(const CanvasFrame& frame, const Pose& X_WK_predicted) noexcept;
  // Adds the samples of the last look(), with the canvas at X_WK.
  void fuse(const Pose& X_WK) noexcept { model_.add(samples_, X_WK); }

  const SurfaceModel& model() const noexcept { return model_; }
  const ShapeRegistration& last() const noexcept { return last_; }
  const Eigen::Vector3d& centre_K() const noexcept { return centre_K_; }  // of what was seen first

 private:
  CanvasShapeSettings settings_;
  OrganisedPoints points_;
  SurfaceModel model_;
  Eigen::AlignedBox3d box_K_;
  Eigen::Vector3d centre_K_;
  unsigned looks_ = 0;
  std::vector<SeenPoint> samples_;
  ShapeRegistration last_;
};

}  // namespace impedraw
