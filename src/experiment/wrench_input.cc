#include "impedraw/experiment/wrench_input.h"

namespace impedraw {

WrenchEstimatorSettings estimator_settings(const SensingSettings& sensing,
                                           const WrenchSensorSettings& sensor, double dt,
                                           double gravity) {
  WrenchEstimatorSettings s;
  s.dt = dt;
  s.tool = sensing.tool;
  s.removal = sensing.removal;
  s.X_ES.p = {0.0, 0.0, -sensing.tip_distance};
  s.gravity_W = {0.0, 0.0, -gravity};
  s.sensor_delay = sensing.sensor_delay.value_or(sensor.delay);
  s.filter_bandwidth = sensing.filter_bandwidth;
  s.tare_time = sensing.tare_time;
  // A reading at the end of the range is rounded to a whole quantum, which may lie below it.
  if (sensor.range_force > 0.0) s.range_force = sensor.range_force - sensor.quantum_force;
  if (sensor.range_torque > 0.0) s.range_torque = sensor.range_torque - sensor.quantum_torque;
  return s;
}

WrenchInput::WrenchInput(WrenchSource source, const WrenchEstimatorSettings& estimator,
                         const WrenchSensorSettings& sensor, double dt, std::uint64_t seed)
    : source_(source) {
  if (!has_sensor(source)) return;
  sensor_.emplace(sensor, dt, seed);
  estimator_.emplace(estimator);
}

void WrenchInput::sample(const World& world) noexcept {
  if (sensor_) reading_ = sensor_->sample(world.flange_wrench());
}

const Vector6& WrenchInput::estimate(const Pose& X_WE, const Vector6& V_WE) noexcept {
  return estimator_ ? estimator_->update(reading_, X_WE, V_WE) : true_;
}

}  // namespace impedraw
