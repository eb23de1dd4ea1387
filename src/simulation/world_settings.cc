#include "impedraw/simulation/world_settings.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/simulation/describe_world.h"

namespace impedraw {

double PadSettings::area() const {
  return face == PadFace::disc ? std::numbers::pi * radius * radius : 2.0 * radius;
}

double JointSensorSettings::velocity_age(double dt) const {
  if (velocity != VelocityReading::difference) return delay;
  return delay + 0.5 * dt + (velocity_bandwidth > 0.0 ? 1.0 / velocity_bandwidth : 0.0);
}

WrenchSensorSettings WrenchSensorSettings::realistic() {
  WrenchSensorSettings s;
  s.noise_force = 0.1;
  s.noise_torque = 0.005;
  s.bias_force = 1.5;
  s.bias_torque = 0.05;
  s.drift_force = 0.02;
  s.drift_torque = 0.001;
  s.quantum_force = 0.02;
  s.quantum_torque = 0.001;
  s.range_force = 100.0;
  s.range_torque = 10.0;
  s.delay = 2e-3;
  return s;
}

void require_valid(const WorldSettings& s) {
  require_ranges("world", s);
  if (!s.pad) return;
  require_in_range("tool.radius", s.pad->radius, kPadRadiusRange, "m");
  require_in_range("tool.thickness", s.pad->thickness, {1e-3, 0.1}, "m");
  if (s.pad->face != PadFace::disc) return;
  require_in_range("tool.stiffness", s.pad->stiffness, kFoamStiffnessRange, "N/m³");
  require_in_range("tool.damping", s.pad->damping, {0.0, 1e6}, "N s/m³");
}

void require_valid(const WrenchSensorSettings& s, double dt) {
  require_ranges("wrench_sensor", s);
  if (!(dt >= 1e-6 && std::isfinite(dt)))
    throw InputError(fmt::format("wrench sensor: dt is {} s, allowed is 1e-6 s or more", dt));
}

}  // namespace impedraw
