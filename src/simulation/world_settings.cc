#include "impedraw/simulation/world_settings.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"

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
  using Limits = WorldSettings::Limits;
  using Tip = TipMaterial::Limits;
  require_in_range("world", Limits::joint_friction, s.joint_friction);
  require_in_range("world", Limits::gravity, s.gravity);
  require_in_range("world", Limits::substeps, s.substeps);
  require_in_range("world.tip", Tip::radius, s.tip.radius);
  require_in_range("world.tip", Tip::stiffness, s.tip.stiffness);
  require_in_range("world.tip", Tip::damping, s.tip.damping);
  require_in_range("world.tip", Tip::friction, s.tip.friction);
  require_in_range("world.tip", Tip::friction_change, s.tip.friction_change);
  require_in_range("world.tip", Tip::friction_length, s.tip.friction_length);
  require_in_range("world.tip", Tip::wear, s.tip.wear);
  if (!s.pad) return;
  using Pad = PadSettings::Limits;
  require_in_range("tool", Pad::radius, s.pad->radius);
  require_in_range("tool", Pad::thickness, s.pad->thickness);
  if (s.pad->face != PadFace::disc) return;
  require_in_range("tool", Pad::stiffness, s.pad->stiffness);
  require_in_range("tool", Pad::damping, s.pad->damping);
}

void require_valid(const WrenchSensorSettings& s, double dt) {
  using Limits = WrenchSensorSettings::Limits;
  require_in_range("wrench_sensor", Limits::noise_force, s.noise_force);
  require_in_range("wrench_sensor", Limits::noise_torque, s.noise_torque);
  require_in_range("wrench_sensor", Limits::bias_force, s.bias_force);
  require_in_range("wrench_sensor", Limits::bias_torque, s.bias_torque);
  require_in_range("wrench_sensor", Limits::drift_force, s.drift_force);
  require_in_range("wrench_sensor", Limits::drift_torque, s.drift_torque);
  require_in_range("wrench_sensor", Limits::quantum_force, s.quantum_force);
  require_in_range("wrench_sensor", Limits::quantum_torque, s.quantum_torque);
  require_in_range("wrench_sensor", Limits::range_force, s.range_force);
  require_in_range("wrench_sensor", Limits::range_torque, s.range_torque);
  require_in_range("wrench_sensor", Limits::gain_error, s.gain_error);
  require_in_range("wrench_sensor", Limits::cross_talk, s.cross_talk);
  require_in_range("wrench_sensor", Limits::delay, s.delay);
  if (!(dt >= 1e-6 && std::isfinite(dt)))
    throw InputError(fmt::format("wrench sensor: dt is {} s, allowed is 1e-6 s or more", dt));
}

}  // namespace impedraw
