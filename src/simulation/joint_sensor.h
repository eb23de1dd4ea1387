// Model of the joints' position and velocity sensors: readings from the exact state (q, v).
//
//   q_read = round((q + noise) / quantum) quantum, delayed by `delay`
//   v_read   exact:       v + noise
//            difference:  (q_read − last q_read)/dt through 1/(1 + s/velocity_bandwidth), + noise
//            none:        zero; the controller estimates the velocity
//            delayed by `delay`
//
// Noise is white, of the given standard deviation at every sample. The same seed, settings and
// states give the same readings.
#pragma once

#include <cstdint>
#include <vector>

#include "impedraw/common/seeded_normals.h"
#include "impedraw/control/arm_terms.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

struct JointReading {
  JointVector q, v;  // [rad], [rad/s]
};

class JointSensor {
 public:
  // dt: time between samples [s]. Throws InputError for a setting out of range.
  JointSensor(const JointSensorSettings& settings, int joints, double dt, std::uint64_t seed);

  // Returns the reading while the joints are at (q, v). Allocates nothing.
  const JointReading& sample(const JointVector& q, const JointVector& v) noexcept;

 private:
  JointSensorSettings settings_;
  double dt_, smoothing_;  // share of a new difference that the filter takes
  SeededNormals normals_;
  bool started_ = false;
  JointVector last_q_, filtered_v_;
  JointReading now_;
  std::vector<JointReading> under_way_;  // ring buffer
  std::size_t oldest_ = 0;
};

}  // namespace impedraw
