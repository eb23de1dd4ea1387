// A weightless pen that stands at rest, point down: its sensor reads what the test says.
#pragma once

#include "impedraw/sensing/wrench_estimator.h"

namespace impedraw::still_pen {

inline const Vector6 kBias = (Vector6() << 3.0, -2.0, 5.0, 0.2, -0.1, 0.05).finished();

inline WrenchEstimatorSettings still_settings() {
  WrenchEstimatorSettings settings;
  settings.tare_time = 0.1;
  return settings;
}

struct Still {
  WrenchEstimator estimator;
  Pose X_WE{{0.5, 0.1, 0.3}, Eigen::Vector3d(1, -1, -1).asDiagonal()};
  explicit Still(const WrenchEstimatorSettings& settings) : estimator(settings) {}
  const Vector6& read(const Vector6& reading_S, const Vector6& V_WE = Vector6::Zero()) {
    return estimator.update(reading_S, X_WE, V_WE);
  }
  int steps_to_tare(const Vector6& reading_S) {
    for (int i = 1; i < 10000; ++i) {
      read(reading_S);
      if (!estimator.taring()) return i;
    }
    return -1;
  }
};

}  // namespace impedraw::still_pen
