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

#include "impedraw/common/range.h"
#include "impedraw/common/seeded_normals.h"
#include "impedraw/control/arm_terms.h"

namespace impedraw {

enum class VelocityReading { exact, difference, none };

struct JointSensorSettings {
  double quantum = 0.0;         // resolution of the position; 0: continuous [rad]
  double position_noise = 0.0;  // standard deviation [rad]
  double velocity_noise = 0.0;  // standard deviation [rad/s]
  double delay = 0.0;  // rounded to samples, at most 30 ms; the first is read without delay [s]
  VelocityReading velocity = VelocityReading::exact;
  double velocity_bandwidth = 250.0;  // of the difference's low-pass; 0: no filter [rad/s]

  struct Limits {
    static constexpr Limit quantum = {"quantum", "rad", {0.0, 0.1}};
    static constexpr Limit position_noise = {"position_noise", "rad", {0.0, 0.1}};
    static constexpr Limit velocity_noise = {"velocity_noise", "rad/s", {0.0, 10.0}};
    static constexpr Limit delay = {"delay", "s", {0.0, 0.03}};
    static constexpr Limit velocity_bandwidth = {"velocity_bandwidth", "rad/s", {0.0, 1e4}};
  };

  bool exact() const {  // reads the state itself
    return quantum == 0.0 && position_noise == 0.0 && velocity_noise == 0.0 && delay == 0.0 &&
           velocity == VelocityReading::exact;
  }
  // Age of the velocity reading at low frequency, for samples dt apart [s].
  double velocity_age(double dt) const;
};

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
