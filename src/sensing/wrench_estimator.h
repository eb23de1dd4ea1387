// Estimates the wrench of the environment on the pen tip from the readings of a force-torque sensor
// between flange and pen.
//
// Reading   [f; m]_S = wrench of the environment on the tool + tool_wrench (tool.h) + bias,
//           in the axes of S, m about S's origin, mean over the step that ended `sensor_delay` ago
// Law       u_S   = filter( reading_S − tool_wrench_S − bias_S )
//           F_ext = [ R_WS f_u ; R_WS (m_u − p_SE × f_u) ]
//           at the origin of E, in the axes of W [N, Nm]
// Motion    The tool's motion over the reading's step: A_WS = ΔV_WS/Δt, with pose and velocity the
//           mean of both ends. The error is of second order in Δt. R_WS is from the same step, so
//           that a force constant in W does not rotate with the tool.
// Filter    1/(1 + s/ω)², critically damped, ω = `filter_bandwidth`, discretised by the trapezoidal
//           rule. At frequency f: phase −2 atan(2πf/ω), gain 1/(1 + (2πf/ω)²), which is one half
//           at ω and −3 dB at 0.64 ω. The low-frequency delay is exactly 2/ω. White noise is
//           reduced to √(ωΔt/4) of its standard deviation (ωΔt ≪ 1).
// Tare      bias_S = mean(reading_S − tool_wrench_S) over `tare_time` of uninterrupted rest: of a
//           velocity whose mean, by a low-pass of tare_time/2, is small. Its noise is no motion.
//           Nothing may touch the tool meanwhile; the estimator cannot detect this.
// Requires  one update() per step, from the first step on; R_WE a rotation; readings that are
//           `sensor_delay` old.
#pragma once

#include <array>
#include <limits>

#include "impedraw/sensing/tool.h"

namespace impedraw {

struct WrenchEstimatorSettings {
  double dt = 1e-3;  // step [s]
  Tool tool;
  Pose X_ES;                                   // sensor frame in the tip's frame
  Eigen::Vector3d gravity_W{0.0, 0.0, -9.81};  // [m/s²]
  double sensor_delay = 0.0;      // age of a reading when passed in, rounded to whole steps [s]
  double filter_bandwidth = 0.0;  // ω, below 2/Δt; 0: no filter [rad/s]
  double tare_time = 0.4;         // [s]
  // The tool is at rest below both, in the mean: speed of the tip [m/s], angular speed [rad/s].
  // An arm that settles against its joints' friction creeps at 3 mm/s, and adds nothing to a bias.
  double tare_speed = 5.0e-3, tare_turn_rate = 3.0e-2;
  // of the sensor, ± on each axis [N]
  double range_force = std::numeric_limits<double>::infinity();
  double range_torque = std::numeric_limits<double>::infinity();  // [Nm]
};

class WrenchEstimator {
 public:
  static constexpr int kMaxDelaySteps = 32;

  // Throws InputError naming the setting, its value and what would be valid.
  explicit WrenchEstimator(const WrenchEstimatorSettings& settings);

  // Updates one step with the newest reading and the tip's current pose and velocity [v; ω].
  // Returns F_ext: zero until tared, and the previous value after a fault. Allocates nothing.
  const Vector6& update(const Vector6& reading_S, const Pose& X_WE, const Vector6& V_WE) noexcept;

  // Starts a tare; the constructor also starts one. The old bias is used until the new one is
  // complete.
  void start_tare() noexcept;

  // Moves the tip along its z, as a pen of another length does [m]. The motion is learned anew.
  void lengthen_pen(double by) noexcept;

  const Vector6& F_ext() const { return F_ext_; }
  bool tared() const { return tared_; }            // a bias is available
  bool taring() const { return taring_; }          // a tare is in progress
  const Vector6& bias() const { return bias_S_; }  // [N, Nm]

  // The last update rejected its reading: it was not finite or at the sensor's range, or a motion
  // less than sensor_delay and two steps ago was not finite. A tare in progress restarts.
  bool fault() const { return fault_; }

  // Age of F_ext at low frequency: sensor_delay + 2/ω [s]. Add half a step if readings are means
  // over a step.
  double group_delay() const;

 private:
  struct Motion {
    Pose X_WS;
    Vector6 V_WS;
  };

  void remember(const Pose& X_WE, const Vector6& V_WE) noexcept;
  ToolMotion motion_of_reading() const noexcept;
  bool reading_valid(const Vector6& reading_S) const noexcept;
  void tare(const Vector6& residue_S, const ToolMotion& motion) noexcept;
  const Vector6& filter(const Vector6& u_S) noexcept;

  WrenchEstimatorSettings settings_;
  Eigen::Vector3d p_SE_;
  double filter_gain_;  // ωΔt/(2 + ωΔt)
  int tare_length_;     // [steps]
  double rest_gain_;    // of the low-pass of the motion

  // ring buffer of motions_kept_ entries, from the start of the reading's step until now
  std::array<Motion, kMaxDelaySteps + 2> motions_;
  int motions_kept_, newest_ = 0, known_ = 0;

  Vector6 tare_sum_ = Vector6::Zero(), bias_S_ = Vector6::Zero();
  Vector6 mean_motion_ = Vector6::Zero();  // while taring: v_WE, ω [m/s, rad/s]
  int tare_steps_ = 0;
  bool taring_ = true, tared_ = false, fault_ = false;
  Vector6 filter_in_ = Vector6::Zero(), filter_middle_ = Vector6::Zero(),
          filter_out_ = Vector6::Zero();
  Vector6 F_ext_ = Vector6::Zero();
};

}  // namespace impedraw
