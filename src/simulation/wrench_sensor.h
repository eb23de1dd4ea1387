// A six-axis force/torque sensor with its faults, from the exact wrench [f; m] in the sensor's axes
// [N, Nm].
//
//   y = quantise(saturate(F + bias + drift t + noise)), then late by `delay`
//
// t = 0 at the first sample. Directions of bias and drift are drawn from the seed, of force and of
// torque apart. Range and quantum hold for each axis. The same seed, settings and wrenches give the
// same readings: its random numbers are its own, not the standard library's.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "impedraw/common/pose.h"

namespace impedraw {

struct WrenchSensorSettings {
  // white, each axis: SD of a sample at 1 kHz; at other rates the same density [N, Nm]
  double noise_force = 0.0, noise_torque = 0.0;
  double bias_force = 0.0, bias_torque = 0.0;        // length of the vector [N, Nm]
  double drift_force = 0.0, drift_torque = 0.0;      // length of the vector [N/min, Nm/min]
  double quantum_force = 0.0, quantum_torque = 0.0;  // 0: none [N, Nm]
  double range_force = 0.0, range_torque = 0.0;      // ±; 0: no limit [N, Nm]
  // in samples, rounded; at most 1 s. Until the first has arrived it is read already [s]
  double delay = 0.0;

  static WrenchSensorSettings realistic();
};

class WrenchSensor {
 public:
  // dt between samples [s]. Throws InputError for a setting that is negative or not finite, or a
  // delay over 1 s.
  WrenchSensor(const WrenchSensorSettings& settings, double dt, std::uint64_t seed);

  // The reading when F acts. Allocates nothing.
  Vector6 sample(const Vector6& F) noexcept;

  // an axis of the last reading stood at the end of its range
  bool saturated() const { return last_.saturated; }

 private:
  struct Reading {
    Vector6 F = Vector6::Zero();
    bool saturated = false;
  };
  double uniform() noexcept;
  Eigen::Vector2d normal_pair() noexcept;
  Vector6 normals() noexcept;

  std::mt19937_64 bits_;
  Vector6 noise_, bias_, drift_, quantum_, range_;  // per axis; drift per sample
  bool noisy_;
  double samples_ = 0.0;
  std::vector<Reading> under_way_;  // a ring
  std::size_t oldest_ = 0;
  Reading last_;
};

}  // namespace impedraw
