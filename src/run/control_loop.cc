#include "impedraw/run/control_loop.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "impedraw/common/errors.h"

namespace impedraw {

namespace {

const char* name_of(WrenchReading wrench) {
  switch (wrench) {
    case WrenchReading::none:
      return "no wrench";
    case WrenchReading::sensor:
      return "a sensor's reading";
    case WrenchReading::tip:
      return "the wrench at the tip";
  }
  return "?";
}

void require_fit(const ControlSetup& setup, int joints, const DriverInfo& driver) {
  if (driver.joints != joints)
    throw InputError(
        fmt::format("driver: its arm has {} joints, the model {}", driver.joints, joints));
  if (!(std::abs(driver.period - setup.impedance.timing.dt) <= 1e-9))
    throw InputError(fmt::format("driver: its period is {} s, the controller's step {} s",
                                 driver.period, setup.impedance.timing.dt));
  const WrenchReading needed = setup.source == WrenchSource::none ? WrenchReading::none
                               : has_sensor(setup.source)         ? WrenchReading::sensor
                                                                  : WrenchReading::tip;
  if (needed != WrenchReading::none && driver.wrench != needed)
    throw InputError(fmt::format("driver: it gives {}, control.wrench needs {}",
                                 name_of(driver.wrench), name_of(needed)));
}

}  // namespace

ControlLoop::ControlLoop(const ControlSetup& setup, ArmModel& arm, const DriverInfo& driver,
                         SurfaceSource surface)
    : arm_(arm),
      surface_source_(std::move(surface)),
      controller_(setup.impedance, arm.joints()),
      coupled_(setup.impedance.inertia != InertiaShaping::shaped),
      terms_(arm.joints()) {
  require_fit(setup, arm.joints(), driver);
  if (has_sensor(setup.source)) estimator_.emplace(setup.estimator);
}

const ImpedanceTorque& ControlLoop::step(const ArmState& state,
                                         const TipReference& reference) noexcept {
  arm_.compute(state.q, state.v, &terms_);
  if (surface_source_) {
    const Eigen::Vector3d& p_WE = terms_.X_WE.p;
    const bool ahead = coupled_ && on_surface_;
    surface_ = surface_source_(ahead ? surface_query(p_WE, reference.p_WD, n_) : p_WE, state.time);
  }
  update_wrench(state);
  const InputAges ages{state.time - state.state_time, state.time - wrench_time_};
  const ImpedanceTorque& out = controller_.step(terms_, reference, surface_, F_ext_, ages);
  on_surface_ = out.mode == ContactMode::approach || out.mode == ContactMode::contact;
  n_ = out.n_WD;
  return out;
}

const ImpedanceTorque& ControlLoop::brake(const ArmState& state) noexcept {
  arm_.compute(state.q, state.v, &terms_);
  update_wrench(state);
  on_surface_ = false;
  return controller_.brake(terms_);
}

// Each reading is used once: a repeated one would look as if nothing moved.
void ControlLoop::update_wrench(const ArmState& state) noexcept {
  if (state.wrench_time != wrench_time_) {
    F_ext_ = estimator_ ? estimator_->update(state.wrench, terms_.X_WE, terms_.V_WE) : state.wrench;
    wrench_time_ = state.wrench_time;
  }
  // The estimator ignores a reading that is not finite, but the controller must see it.
  if (!state.wrench.allFinite()) F_ext_.setConstant(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace impedraw
