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

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "impedraw/common/range_check.h"
#include "impedraw/common/seeded_normals.h"
#include "impedraw/control/arm_terms.h"
#include "impedraw/simulation/describe_world.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

struct JointReading {
  JointVector q, v;  // [rad], [rad/s]
};

class JointSensor {
 public:
  // dt: time between samples [s]. Throws InputError for a setting out of range.
  JointSensor(const JointSensorSettings& settings, int joints, double dt, std::uint64_t seed)
      : settings_((require_ranges("world.joint_sensor", settings), settings)),
        dt_(dt),
        smoothing_(settings.velocity_bandwidth > 0.0
                       ? 1.0 - std::exp(-settings.velocity_bandwidth * dt)
                       : 1.0),
        normals_(seed),
        last_q_(JointVector::Zero(joints)),
        filtered_v_(last_q_),
        now_{last_q_, last_q_},
        under_way_(static_cast<std::size_t>(std::lround(settings.delay / dt)), now_) {}

  // Returns the reading while the joints are at (q, v). Allocates nothing.
  const JointReading& sample(const JointVector& q, const JointVector& v) noexcept {
    now_.q = q;
    if (settings_.position_noise > 0.0)
      for (double& x : now_.q) x += settings_.position_noise * normals_.next();
    if (settings_.quantum > 0.0)
      for (double& x : now_.q) x = settings_.quantum * std::round(x / settings_.quantum);
    switch (settings_.velocity) {
      case VelocityReading::exact:
        now_.v = v;
        break;
      case VelocityReading::difference:
        if (started_) filtered_v_ += smoothing_ * ((now_.q - last_q_) / dt_ - filtered_v_);
        now_.v = filtered_v_;
        break;
      case VelocityReading::none:
        now_.v.setZero();
        break;
    }
    last_q_ = now_.q;
    if (settings_.velocity_noise > 0.0 && settings_.velocity != VelocityReading::none)
      for (double& x : now_.v) x += settings_.velocity_noise * normals_.next();
    if (!under_way_.empty()) {
      if (!started_) std::fill(under_way_.begin(), under_way_.end(), now_);
      std::swap(now_, under_way_[oldest_]);
      oldest_ = (oldest_ + 1) % under_way_.size();
    }
    started_ = true;
    return now_;
  }

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
