// The source of the controller's wrench, and the assumed properties of its sensor.
#pragma once

#include <optional>

#include "impedraw/sensing/wrench_estimator.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

enum class WrenchSource {
  none,       // not measured
  truth,      // the simulator's true wrench, one step old
  sensor,     // a sensor with the errors of world.wrench_sensor, none by default
  realistic,  // a sensor with the errors of a real one: WrenchSensorSettings::realistic()
};

inline bool has_sensor(WrenchSource source) {
  return source == WrenchSource::sensor || source == WrenchSource::realistic;
}

// The controller's assumptions about the sensor and its tool.
struct SensingSettings {
  Tool tool{0.05,
            {0.0, 0.0, 0.06},
            Eigen::Vector3d(6e-5, 6e-5, 6.25e-7).asDiagonal()};  // the pen of models/
  static constexpr double tip_distance =
      0.12;                            // of the tip E from the sensor's origin, along the pen [m]
  std::optional<double> sensor_delay;  // absent: the true delay [s]
  static constexpr double tare_time = 0.4;  // [s]
};

// Estimator settings for the time step dt [s] and the given sensor.
WrenchEstimatorSettings estimator_settings(const SensingSettings& sensing,
                                           const WrenchSensorSettings& sensor, double dt,
                                           double gravity);

}  // namespace impedraw
