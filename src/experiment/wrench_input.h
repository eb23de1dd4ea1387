// The wrench that the controller is given: the true one, or a simulated sensor's, cleaned of tool
// and bias by the library.
#pragma once

#include <optional>

#include "impedraw/sensing/wrench_estimator.h"
#include "impedraw/simulation/world.h"
#include "impedraw/simulation/wrench_sensor.h"

namespace impedraw {

enum class WrenchSource {
  none,       // not measured
  truth,      // the simulator's own, a step old
  sensor,     // a sensor with the faults that world.wrench_sensor lists, none by default
  realistic,  // the same with those of a real one: WrenchSensorSettings::realistic()
};

inline bool has_sensor(WrenchSource source) {
  return source == WrenchSource::sensor || source == WrenchSource::realistic;
}

// What the controller's side believes of the sensor and of the tool on it.
struct SensingSettings {
  Tool tool{0.05,
            {0.0, 0.0, 0.06},
            Eigen::Vector3d(6e-5, 6e-5, 6.25e-7).asDiagonal()};  // the pen of models/
  ToolRemoval removal;
  double tip_distance = 0.12;          // of the tip E from the sensor's origin, along the pen [m]
  std::optional<double> sensor_delay;  // absent: what it is [s]
  double filter_bandwidth = 0.0;       // [rad/s]; 0: none
  double tare_time = 0.4;              // [s]
};

// Estimator settings for a step of dt and a sensor as it is.
WrenchEstimatorSettings estimator_settings(const SensingSettings& sensing,
                                           const WrenchSensorSettings& sensor, double dt,
                                           double gravity);

class WrenchInput {
 public:
  // Throws InputError. `estimator` and `sensor` are looked at only if the source is a sensor.
  WrenchInput(WrenchSource source, const WrenchEstimatorSettings& estimator,
              const WrenchSensorSettings& sensor, double dt, std::uint64_t seed);

  // The simulator's side, once a step before the controller's: what the sensor gives out now.
  void sample(const World& world) noexcept;
  // The controller's side: F_ext at E in W, from that reading and the arm's own belief of where its
  // tip is.
  const Vector6& estimate(const Pose& X_WE, const Vector6& V_WE) noexcept;
  // After the world's step: the true wrench at E where the tip was.
  void set_true(const Vector6& F_ext) noexcept { true_ = F_ext; }

  bool tared() const noexcept { return !estimator_ || estimator_->tared(); }

 private:
  WrenchSource source_;
  std::optional<WrenchSensor> sensor_;
  std::optional<WrenchEstimator> estimator_;
  Vector6 reading_ = Vector6::Zero(), true_ = Vector6::Zero();
};

}  // namespace impedraw
