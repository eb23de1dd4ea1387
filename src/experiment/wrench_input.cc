#include "impedraw/experiment/wrench_input.h"

namespace impedraw {

WrenchEstimatorSettings estimator_settings(const SensingSettings& sensing,
                                           const WrenchSensorSettings& sensor, double dt,
                                           double gravity) {
  WrenchEstimatorSettings s;
  s.dt = dt;
  s.tool = sensing.tool;
  s.X_ES.p = {0.0, 0.0, -sensing.tip_distance};
  s.gravity_W = {0.0, 0.0, -gravity};
  s.sensor_delay = sensing.sensor_delay.value_or(sensor.delay);
  s.tare_time = sensing.tare_time;
  // A reading at the end of the range is rounded to a whole quantum, which may lie below it.
  if (sensor.range_force > 0.0) s.range_force = sensor.range_force - sensor.quantum_force;
  if (sensor.range_torque > 0.0) s.range_torque = sensor.range_torque - sensor.quantum_torque;
  return s;
}

}  // namespace impedraw
