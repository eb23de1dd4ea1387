// The belief about the canvas's motion as of the last frame, and predictions from it.
//
// All that a prediction needs, as plain data: the thread that takes frames (canvas_tracker.h) hands
// it to the one that controls.
#pragma once

#include <array>
#include <string>

#include "impedraw/control/canvas_estimate.h"
#include "impedraw/perception/axis_motion.h"
#include "impedraw/perception/registration.h"

namespace impedraw {

// Shift of the canvas at the tip, beyond what is predicted (felt_motion.h), in W.
struct CanvasShift {
  Eigen::Vector3d d = Eigen::Vector3d::Zero();       // how far [m]
  Eigen::Vector3d v = Eigen::Vector3d::Zero();       // how fast [m/s]
  Eigen::Vector3d across = Eigen::Vector3d::Zero();  // of v, the part across the slip [m/s]
  double unfelt = 1.0;  // share of the prediction's mean squared error that it leaves
};

struct CanvasBelief {
  static constexpr int kAxes = 6;
  static constexpr int kPlain = 5, kFilters = kPlain + 8, kBands = 4;
  static constexpr int kRepeated = kFilters + kBands, kSwinging = kRepeated + 1;
  static constexpr int kModels = kSwinging + 1;
  static const std::array<AxisModel, kFilters> kBank;  // kPlain: without a rate
  static const std::array<double, kBands> kCutoffs;    // [Hz]

  // As a frame left it.
  struct Entry {
    double time = 0.0;
    Pose X_WK;                                  // measured
    std::array<double, kAxes> x{}, variance{};  // centre in W, then φ
    std::array<std::array<AxisFilter, kAxes>, kFilters> filters{};
    std::array<AxisWave, kAxes> waves{};
    // Bands, then what is repeated: its first coefficient is NaN where nothing is.
    std::array<std::array<AxisPolynomial, kAxes>, kBands + 1> polynomials{};
    std::array<bool, kAxes> fitted{};  // polynomials hold
  };
  struct Score {
    std::array<double, kModels> square{};  // mean squared error lately
    double blended = 0.0;                  // of the blend
    double noise = 0.0;                    // variance of what it is compared with
    double weight = 0.0;                   // of evidence
  };

  bool known = false;  // else nothing below holds
  long frames = 0;     // that told a pose so far
  Entry last;
  std::array<Score, kAxes> scores{};
  Eigen::Matrix3d R_0 = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centre_K = Eigen::Vector3d::Zero();
  int open = 0;  // directions that nothing tells
  std::array<OpenDirection, kAxes> open_directions{};
  bool prediction = true;                          // off: the pose at the last frame is taken
  double longest_age = 1.0, largest_error = 4e-3;  // of CanvasTrackerSettings

  // Motions of the canvas that nobody would have noticed: the directions that its shape leaves
  // open, where no marks tell them; empty where there are none.
  std::string open_text() const;

  // lateness: of the frames lately [s].
  CanvasEstimate predict(double time, double lateness) const noexcept;
  CanvasEstimate estimate(const std::array<AxisState, kAxes>& state, double time, double lateness,
                          double unfelt = 1.0) const noexcept;

  bool holds(const Entry& entry, int model, int axis) const noexcept;
  AxisState model_state(const Entry& from, int model, int axis, double time) const noexcept;
  // The weights of the models that hold in `from`.
  std::array<double, kModels> weights(const Entry& from, int axis) const noexcept;
  AxisState blend(const Entry& from, int axis, double time) const noexcept;
};

// The prediction for the present, smoothed, so that the arm sees no steps as frames arrive.
class SmoothedCanvas {
 public:
  static constexpr double kSmoothing = 30.0;  // of what is off by little [1/s]

  // At `time`, not before that of the last call. Once per control step.
  CanvasEstimate follow(const CanvasBelief& belief, double time,
                        const CanvasShift& felt = {}) noexcept;
  double lateness() const noexcept { return lateness_; }

 private:
  void refer_to(const Eigen::Matrix3d& R_0) noexcept;

  std::array<AxisState, CanvasBelief::kAxes> smooth_{};  // coordinates and their rates
  Eigen::Matrix3d R_0_ = Eigen::Matrix3d::Identity();
  double time_ = -1.0;
  double lateness_ = 0.06;  // smoothed [s]
};

}  // namespace impedraw
