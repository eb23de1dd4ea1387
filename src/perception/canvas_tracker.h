// Where the canvas is and how it moves, from frames that are late.
//
// Each frame tells a pose of the canvas at the time of its exposure, by the marks that were found,
// by the canvas's shape in its depths (canvas_shape.h), or by both, each as far as it is sure. The
// six coordinates, the position of a centre in W and the rotation vector φ, R_WK = exp(φ) R_0, are
// each followed by a bank of models (axis_motion.h). The centre is that of the marks, or of the
// shape. A model counts by how well it predicted lately what came later, across as long a time as
// frames are late. The prediction for the present is smoothed: it follows the bank with kSmoothing,
// so that the arm sees no steps as frames arrive.
//
// The status says when not to rely on it: `stale` if the frames are too old, or if the error to be
// expected at the age of the last frame, from the errors of the predictions before, is too large;
// `undetermined` if there are directions in which neither marks nor shape tell where it is.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "impedraw/control/canvas_estimate.h"
#include "impedraw/perception/axis_motion.h"
#include "impedraw/perception/canvas_frame.h"
#include "impedraw/perception/canvas_shape.h"
#include "impedraw/perception/frame_settings.h"

namespace impedraw {

struct CanvasTrackerSettings {
  FiducialSettings fiducials;
  bool prediction = true;       // off: the pose at the last frame is taken for the present one
  double longest_age = 1.0;     // of the last frame [s]
  double largest_error = 4e-3;  // to be expected of the position [m]
  Pose X_WK;                    // about where a shape without marks is looked for at first
};

class CanvasTracker {
 public:
  static constexpr double kWindow = 6.0;      // over which swings are fitted [s]
  static constexpr double kSmoothing = 30.0;  // [1/s]

  // Throws InputError that names the setting: fewer than three marks, collinear ones, too many.
  // With a shape there need be no marks; what it leaves open then stays as predicted.
  explicit CanvasTracker(const CanvasTrackerSettings& settings,
                         std::unique_ptr<CanvasShape> shape = nullptr);

  // In any order; one that is older than kWindow, and one that tells no pose, is ignored.
  void add(const CanvasFrame& frame) noexcept;

  // At `time`, not before that of the last call. Without smoothing: what the bank
  // predicts.
  CanvasEstimate predict(double time) const noexcept;
  // The same, smoothed. Once per control step.
  CanvasEstimate follow(double time) noexcept;

  // Standard deviation of the errors of the predictions lately, of the position, across the frames'
  // lateness [m]. Includes the measurements' own noise.
  double position_error() const noexcept;
  // The model that counts most for a coordinate, 0 to 5: "steady", "drifting" or "swinging".
  const char* model(int axis) const noexcept;
  // How the canvas might have moved without being noticed: the directions that its shape leaves
  // open, where no marks tell them; empty where there are none.
  std::string open_directions() const;
  // Null without one.
  const CanvasShape* shape() const noexcept { return shape_.get(); }

 private:
  static constexpr int kAxes = 6;
  static constexpr int kFilters = 5, kBands = 5;
  static constexpr int kSwinging = kFilters + kBands, kModels = kSwinging + 1;
  struct Model {
    int order;
    double noise;  // q
  };
  static const std::array<Model, kFilters> kBank;
  static const std::array<double, kBands> kCutoffs;  // [Hz]

  // As a frame left it.
  struct Entry {
    double time = 0.0;
    Pose X_WK;                                  // measured
    std::array<double, kAxes> x{}, variance{};  // centre in W, then φ
    std::array<std::array<AxisFilter, kAxes>, kFilters> filters{};
    std::array<AxisWave, kAxes> waves{};
    std::array<std::array<AxisPolynomial, kAxes>, kBands> bands{};
    std::array<bool, kAxes> banded{};  // bands hold
  };
  struct Score {
    std::array<double, kModels> square{};  // mean squared error lately
    double blended = 0.0;                  // of the blend
    double noise = 0.0;                    // variance of what it is compared with
    double weight = 0.0;                   // of evidence
  };

  bool measure(const CanvasFrame& frame, Entry* entry) noexcept;
  bool measure_marks(const CanvasFrame& frame, Entry* entry, Matrix6* information) const noexcept;
  void express(Entry* entry, const Eigen::Vector3d& near) const noexcept;
  void update_from(std::size_t first) noexcept;
  void judge(const Entry& entry) noexcept;
  void refer_anew() noexcept;
  void collect() noexcept;
  void fit_bands() noexcept;
  void fit_waves() noexcept;
  bool holds(const Entry& entry, int model, int axis) const noexcept;
  AxisState model_state(const Entry& from, int model, int axis, double time) const noexcept;
  std::array<double, kModels> weights(int axis) const noexcept;
  AxisState blend(const Entry& from, int axis, double time) const noexcept;
  CanvasEstimate estimate(const std::array<AxisState, kAxes>& state, double time) const noexcept;

  CanvasTrackerSettings settings_;
  std::unique_ptr<CanvasShape> shape_;
  std::vector<Eigen::Vector3d> marks_K_;
  Eigen::Vector3d centre_K_;
  std::vector<Entry> entries_;  // in order of time
  std::array<Score, kAxes> scores_{};
  std::array<std::vector<AxisSample>, kAxes> samples_;  // frames of one time as one
  BandLimited band_;
  Eigen::Matrix3d R_0_ = Eigen::Matrix3d::Identity();
  int open_ = 0;            // directions that nothing tells
  double lateness_ = 0.06;  // smoothed [s]
  double now_ = 0.0, searched_at_ = 0.0;
  int search_axis_ = 0;
  // Of follow(): smoothed coordinates, their rate, and when.
  std::array<AxisState, kAxes> smooth_{};
  double smooth_time_ = -1.0;
};

}  // namespace impedraw
