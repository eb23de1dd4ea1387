// Stage 4 of an experiment, Scene + Plan → ControlSetup: the controller's settings, completed by
// what follows from the arm, the plan and the wrench sensor.
#pragma once

#include "impedraw/control/impedance_settings.h"
#include "impedraw/experiment/plan.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/experiment/scene.h"
#include "impedraw/sensing/wrench_estimator.h"
#include "impedraw/settings/setting_error.h"
#include "impedraw/simulation/wrench_sensor.h"

namespace impedraw {

struct ControlSetup {
  ImpedanceSettings impedance;  // with rest posture, limits, and how the wrench is known
  WrenchSource source = WrenchSource::none;
  // Where that is a sensor:
  WrenchSensorSettings sensor;        // as it is,
  WrenchEstimatorSettings estimator;  // as the library reads it
};

// Throws InputError where the controller or the sensor cannot work so.
ControlSetup make_control_setup(const Scenario& scenario, const Scene& scene, const Plan& plan,
                                const SettingErrors& setting_errors);

}  // namespace impedraw
