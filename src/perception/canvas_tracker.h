// Place and motion of the canvas, from frames that are late.
//
// Each frame tells a pose of the canvas at the time of its exposure, by the marks that were found,
// by the canvas's shape in its depths (canvas_shape.h), or by both, each as far as it is sure. The
// six coordinates, the position of a centre in W and the rotation vector φ, R_WK = exp(φ) R_0, are
// each followed by a bank of models (axis_motion.h). The centre is that of the marks, or of the
// shape. A model counts by how well it predicted lately what came later, across as long a time as
// frames are late (canvas_belief.h).
//
// The status says when not to rely on it: `stale` if the frames are too old, or if the error to be
// expected at the age of the last frame, from the errors of the predictions before, is too large;
// `undetermined` if there are directions in which neither marks nor shape tell where it is.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "impedraw/control/canvas_estimate.h"
#include "impedraw/perception/axis_motion.h"
#include "impedraw/perception/canvas_belief.h"
#include "impedraw/perception/canvas_frame.h"
#include "impedraw/perception/canvas_shape.h"
#include "impedraw/perception/frame_settings.h"

namespace impedraw {

struct CanvasTrackerSettings {
  FiducialSettings fiducials;
  bool prediction = true;       // off: the pose at the last frame is taken for the present one
  double longest_age = 1.0;     // of the last frame [s]
  double largest_error = 4e-3;  // to be expected of the position [m]
  Pose X_WK{};                  // about where a shape without marks is looked for at first
};

class CanvasTracker {
 public:
  static constexpr double kWindow = 6.0;  // over which swings are fitted [s]

  // Throws InputError that names the setting: fewer than three marks, collinear ones, too many.
  // With a shape there need be no marks; what it leaves open then stays as predicted.
  explicit CanvasTracker(const CanvasTrackerSettings& settings,
                         std::unique_ptr<CanvasShape> shape = nullptr);

  // In any order; one that is older than kWindow, and one that tells no pose, is ignored.
  void add(const CanvasFrame& frame) noexcept;

  // Moves the times of all frames so far by `by` [s].
  void restamp(double by) noexcept;

  // At `time`, not before that of the last call. Without smoothing: what the bank
  // predicts.
  CanvasEstimate predict(double time) const noexcept {
    return belief_.predict(time, smoothed_.lateness());
  }
  // The same, smoothed. Once per control step, or before each frame: it also tells how late frames
  // are.
  CanvasEstimate follow(double time, const CanvasShift& felt = {}) noexcept {
    return smoothed_.follow(belief_, time, felt);
  }

  // As of the last frame, for a SmoothedCanvas in another thread.
  const CanvasBelief& belief() const noexcept { return belief_; }

  // Standard deviation of the errors of the predictions lately, of the position, across the frames'
  // lateness [m]. Includes the measurements' own noise.
  double position_error() const noexcept;
  // The model that counts most for a coordinate, 0 to 5: "steady", "drifting", "smooth",
  // "band", "repeated" or "swinging".
  const char* model(int axis) const noexcept;
  // Null without one.
  const CanvasShape* shape() const noexcept { return shape_.get(); }

 private:
  static constexpr int kAxes = CanvasBelief::kAxes, kFilters = CanvasBelief::kFilters,
                       kBands = CanvasBelief::kBands, kSwinging = CanvasBelief::kSwinging,
                       kModels = CanvasBelief::kModels;
  using Entry = CanvasBelief::Entry;
  using Score = CanvasBelief::Score;

  bool measure(const CanvasFrame& frame, Entry* entry) noexcept;
  bool measure_marks(const CanvasFrame& frame, Entry* entry, Matrix6* information) const noexcept;
  void express(Entry* entry, const Eigen::Vector3d& near) const noexcept;
  void update_from(std::size_t first) noexcept;
  void judge(const Entry& entry) noexcept;
  void refer_anew() noexcept;
  void collect() noexcept;
  void fit_bands() noexcept;
  void fit_repeated() noexcept;
  void fit_waves() noexcept;

  CanvasTrackerSettings settings_;
  std::unique_ptr<CanvasShape> shape_;
  std::vector<Eigen::Vector3d> marks_K_;
  std::vector<Entry> entries_;                          // in order of time
  std::array<std::vector<AxisSample>, kAxes> samples_;  // frames of one time as one
  BandLimited band_;
  double searched_at_ = 0.0;
  int search_axis_ = 0;
  CanvasBelief belief_;
  SmoothedCanvas smoothed_;
};

}  // namespace impedraw
