// The part of the canvas's motion that no forecast has, as the pen on it feels it.
//
// Frames are late by some hundredths of a second; contact tells at once. Two components of the
// canvas's velocity v_C at the tip are the tip's own, v_E: along n, as the canvas carries the pen,
// and along c, across the slip, as friction acts against the slip:
//
//   n · v_C = n · v_E,    c · v_C = c · v_E,    c ∝ n × f_t
//
// f_t: the measured force without its part along n. While the pen sticks, both hold as well. What
// they have beyond the forecast v_F of the last frame, of time t_0, adds up to a shift of the
// canvas:
//
//   d_n = ∫ n nᵀ (v_E − v_F) dt,    d_c = ∫ c cᵀ (v_E − v_F) dt    from t_0 to now
//
// Each counts by how far the canvas was lately off its forecast as frames came in, without and with
// d, beyond the frames' own noise σ², at least (0.1 mm)²:
//
//   share = E_F² / (E_F² + E_d²),    E_F = ⟨off²⟩ − 1.5 σ² ≥ 0,    E_d = ⟨(off − d)²⟩ − σ² ≥ σ²
//
// A canvas that stands, or moves as forecast, has E_F = 0: nothing that is felt shifts it. A wrong
// normal, for instance, turns f_t.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "impedraw/perception/canvas_belief.h"
#include "impedraw/perception/stamp_lag.h"

namespace impedraw {

// The pen's tip in one control step, in W.
struct PenTouch {
  bool touches = false;                             // else nothing below is used
  Eigen::Vector3d p = Eigen::Vector3d::Zero();      // [m]
  Eigen::Vector3d v = Eigen::Vector3d::Zero();      // [m/s]
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();     // of the surface, outward
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // on the tip [N]
  Pose X_WK;                                        // of the canvas, as the law has it
  double height = 0.0;                              // over its surface there [m]
};

class FeltMotion {
 public:
  enum Direction { along_normal, across_slip, kDirections };

  FeltMotion();

  // Once per control step. Allocates nothing.
  void update(const CanvasBelief& belief, const PenTouch& pen, double time) noexcept;

  // Shift of the canvas beyond the belief's prediction [m], and its speed across the slip and as a
  // whole [m/s], in W, at a time not before that of the last update.
  CanvasShift shift(double time) const noexcept;
  // Between 0 and 1.
  double share(Direction k) const noexcept { return share_[k]; }
  const StampLag& stamps() const noexcept { return stamps_; }

 private:
  static constexpr std::size_t kMost = 512;  // steps that are kept
  using Shifts = std::array<Eigen::Vector3d, kDirections>;
  struct Step {
    double time = 0.0, dt = 0.0;
    Pose X_WK;  // as forecast then
    Eigen::Vector3d p, v;
    double height;  // over the surface as forecast
    Shifts axes;    // n and c; zero where nothing is felt
    Shifts d;       // as of then
  };

  const Step& step(std::size_t back) const noexcept {
    return steps_[(next_ + kMost - 1 - back) % kMost];
  }
  void expect(const CanvasBelief& belief) noexcept;
  void judge(const CanvasBelief& belief) noexcept;
  void weigh(int k, double noise) noexcept;
  void add_up_anew(const CanvasBelief& belief) noexcept;

  std::vector<Step> steps_;  // a ring
  std::size_t next_ = 0, count_ = 0;
  long frames_ = -1;  // of the belief
  double judged_at_ = -1e9;
  struct Score {
    double without = 0.0, with = 0.0;  // ⟨off²⟩, ⟨(off − d)²⟩ [m²]
    bool begun = false;
  };
  std::array<Score, kDirections> scores_{};
  std::array<double, kDirections> share_{};
  StampLag stamps_;
  Shifts d_, rate_;
  double time_ = 0.0;
};

}  // namespace impedraw
