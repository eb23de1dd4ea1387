// Stage 4 of an experiment, Scene + Plan → ControlSetup: the controller's settings, completed from
// the arm, the plan and the wrench sensor.
#pragma once

#include <optional>

#include "impedraw/control/depth_hold.h"
#include "impedraw/control/impedance_settings.h"
#include "impedraw/experiment/belief.h"
#include "impedraw/experiment/plan.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/sensing/joint_state_estimator.h"
#include "impedraw/sensing/touch_settings.h"
#include "impedraw/sensing/wrench_estimator.h"
#include "impedraw/settings/setting_error.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

struct ControlSetup {
  ImpedanceSettings impedance;  // with rest posture, limits and wrench feedback
  WrenchSource source = WrenchSource::none;
  // Used only if the source is a sensor:
  WrenchSensorSettings sensor;        // the simulated sensor
  WrenchEstimatorSettings estimator;  // the estimator that reads it
  // Absent: the law uses the measured joint velocities.
  std::optional<JointStateEstimatorSettings> joint_estimator;
  struct Touch {
    TouchSettings settings;
    TouchModel model;
  };
  std::optional<Touch> touch;   // the surface is learned from touch
  std::optional<CutModel> cut;  // whose depth is held
};

// Throws InputError if the controller or the sensor rejects its settings.
ControlSetup make_control_setup(const Scenario& scenario, const Belief& belief, const Plan& plan,
                                const SettingErrors& setting_errors);

}  // namespace impedraw
