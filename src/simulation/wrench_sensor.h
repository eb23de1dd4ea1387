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
#include "impedraw/common/seeded_normals.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

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
