// Model of a six-axis force-torque sensor: readings from the exact wrench F = [f; m] in the
// sensor's axes [N, Nm].
//
//   y = quantise(saturate(G F + bias + drift t + noise)), delayed by `delay`
//
// t = 0 at the first sample. The directions of bias and drift are drawn from the seed, separately
// for force and torque. G = I + E: the diagonal of E is ±gain_error, the rest of each row a vector
// of length cross_talk in a direction from the seed, in shares of range: 10 N weigh as 1 Nm.
// Range and quantum apply to each axis. The same seed, settings and wrenches give the same
// readings: the sensor does not use the standard library's distributions.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/common/range.h"
#include "impedraw/common/seeded_normals.h"

namespace impedraw {

struct WrenchSensorSettings {
  // white noise on each axis: standard deviation at 1 kHz; same density at other rates [N, Nm]
  double noise_force = 0.0, noise_torque = 0.0;
  double bias_force = 0.0, bias_torque = 0.0;        // length of the vector [N, Nm]
  double drift_force = 0.0, drift_torque = 0.0;      // length of the vector [N/min, Nm/min]
  double quantum_force = 0.0, quantum_torque = 0.0;  // 0: continuous [N, Nm]
  double range_force = 0.0, range_torque = 0.0;      // ±; 0: no limit [N, Nm]
  double gain_error = 0.0;                           // of each axis, up or down as the seed says
  double cross_talk = 0.0;                           // of the other axes in each
  // rounded to samples; the first sample is read without delay [s]
  double delay = 0.0;

  struct Limits {
    static constexpr Limit noise_force = {"noise_force", "N", {0.0, 100.0}};
    static constexpr Limit noise_torque = {"noise_torque", "Nm", {0.0, 10.0}};
    static constexpr Limit bias_force = {"bias_force", "N", {0.0, 1000.0}};
    static constexpr Limit bias_torque = {"bias_torque", "Nm", {0.0, 100.0}};
    static constexpr Limit drift_force = {"drift_force", "N/min", {0.0, 100.0}};
    static constexpr Limit drift_torque = {"drift_torque", "Nm/min", {0.0, 10.0}};
    static constexpr Limit quantum_force = {"quantum_force", "N", {0.0, 10.0}};
    static constexpr Limit quantum_torque = {"quantum_torque", "Nm", {0.0, 1.0}};
    static constexpr Limit range_force = {"range_force", "N", {0.0, 1e5}};
    static constexpr Limit range_torque = {"range_torque", "Nm", {0.0, 1e4}};
    static constexpr Limit gain_error = {"gain_error", "", {0.0, 0.5}};
    static constexpr Limit cross_talk = {"cross_talk", "", {0.0, 0.5}};
    static constexpr Limit delay = {"delay", "s", {0.0, 0.03}};
  };

  static WrenchSensorSettings realistic();
};

class WrenchSensor {
 public:
  // dt: time between samples [s]. Throws InputError for a setting out of range.
  WrenchSensor(const WrenchSensorSettings& settings, double dt, std::uint64_t seed);

  // Returns the reading while F acts. Allocates nothing.
  Vector6 sample(const Vector6& F) noexcept;

  // true if an axis of the last reading was at the end of its range
  bool saturated() const { return last_.saturated; }

 private:
  struct Reading {
    Vector6 F = Vector6::Zero();
    bool saturated = false;
  };
  Vector6 normals() noexcept;

  SeededNormals normals_;
  Vector6 noise_, bias_, drift_, quantum_, range_;  // per axis; drift per sample
  bool noisy_;
  std::optional<Eigen::Matrix<double, 6, 6>> gain_;  // G
  double samples_ = 0.0;
  std::vector<Reading> under_way_;  // ring buffer
  std::size_t oldest_ = 0;
  Reading last_;
};

}  // namespace impedraw
