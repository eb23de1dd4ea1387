#include "impedraw/run/arm_monitors.h"

#include <fmt/format.h>

namespace impedraw {

namespace {

bool feels(const Experiment& e) { return e.control.impedance.wrench == WrenchFeedback::measured; }

}  // namespace

ArmMonitors::ArmMonitors(const Experiment& e, const Driver& driver, const RunHooks& hooks)
    : driver_(driver),
      hooks_(hooks),
      tare_(e.plan.path_settings.start_hold, e.control.estimator.tare_time),
      reading_(driver.info(), e.belief.arm.limits().speed, e.belief.arm.limits().torque,
               e.scenario.arm.wrench_delay, feels(e)),
      signs_(e.control.impedance, e.belief.arm.limits().torque),
      fences_(e.scenario.fence, feels(e)),
      speed_(e.belief.arm.limits().speed, e.belief.arm.joint_names()),
      rattle_(e.control.impedance.stability_check.contact_stiffness_max,
              e.belief.perception && feels(e)) {}

Verdict ArmMonitors::judge(const Cycle& cycle, const Reaction& reaction, bool blocked) {
  const Reaction::State state = reaction.state();
  Verdict worst = worse(state_.judge(cycle, driver_.fault()), tare_.judge(cycle));
  if (worst) return worst;
  worst = reading_.judge(cycle);
  if (worst || state == Reaction::State::damp) return worst;
  worst = signs_.judge(cycle);
  if (worst) return worst;
  if (state != Reaction::State::halt) worst = emergency(cycle);
  if (!worst) worst = fences_.judge(cycle);
  if (!worst && !reaction.brakes()) worst = speed_.judge(cycle);
  const Verdict rattle = rattle_.judge(cycle);
  if (!blocked) worst = worse(worst, rattle);
  return worse(worst, step_time_.judge(cycle));
}

Verdict ArmMonitors::emergency(const Cycle& cycle) const {
  if (!hooks_.emergency || !hooks_.emergency()) return {};
  return {Severity::halt,
          fmt::format("emergency stop at t = {:.3f} s, by a person", cycle.run_time)};
}

}  // namespace impedraw
