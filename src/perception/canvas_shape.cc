#include "impedraw/perception/canvas_shape.h"

#include <fmt/format.h>

#include "impedraw/common/errors.h"

namespace impedraw {

CanvasShape::CanvasShape(const PointCloud& seen, const CanvasShapeSettings& settings)
    : settings_(settings), points_(settings.points), model_(settings.voxel) {
  std::vector<SeenPoint> samples;
  const bool weighted = seen.weight.size() == seen.points.size();
  for (std::size_t i = 0; i < seen.points.size() && i < seen.normals.size(); ++i) {
    if (!seen.normals[i].allFinite()) continue;
    const double weight = weighted ? seen.weight[i] : 1.0;
    samples.push_back({seen.points[i], seen.normals[i],
                       settings.points.sigma_at_1m / std::sqrt(std::max(1.0, weight))});
    box_K_.extend(seen.points[i]);
  }
  if (samples.size() < static_cast<std::size_t>(kLeastMatches))
    throw InputError(fmt::format(
        "perception.frames.depth: the snapshot has {} points with normals; at least {} are needed "
        "to find the canvas's shape in later frames",
        samples.size(), kLeastMatches));
  model_.add(samples, {});
  centre_K_ = Eigen::Vector3d::Zero();
  for (const SeenPoint& s : samples) centre_K_ += s.p / static_cast<double>(samples.size());
  samples_.reserve(20000);
}

const ShapeRegistration& CanvasShape::look(const CanvasFrame& frame,
                                           const Pose& X_WK_predicted) noexcept {
  samples_.clear();
  last_ = {};
  if (!frame.depth || !frame.camera_model) return last_;
  Eigen::AlignedBox3d region;
  for (int k = 0; k < 8; ++k)
    region.extend(X_WK_predicted * box_K_.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k)));
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(settings_.margin);
  points_.find(*frame.depth, *frame.camera_model, {region.min() - margin, region.max() + margin},
               frame.arm, settings_.self_padding, &samples_, looks_++);
  constexpr int kIterations = 4;  // the prediction is close
  last_ = register_samples(model_, samples_, X_WK_predicted, kIterations);
  return last_;
}

}  // namespace impedraw
