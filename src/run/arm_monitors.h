// The monitors of a driven arm, whatever it does.
#pragma once

#include "impedraw/experiment/experiment.h"
#include "impedraw/run/driver.h"
#include "impedraw/run/monitors/fence_monitor.h"
#include "impedraw/run/monitors/rattle_monitor.h"
#include "impedraw/run/monitors/reading_monitor.h"
#include "impedraw/run/monitors/sign_monitor.h"
#include "impedraw/run/monitors/speed_monitor.h"
#include "impedraw/run/monitors/state_monitor.h"
#include "impedraw/run/monitors/step_time_monitor.h"
#include "impedraw/run/monitors/tare_monitor.h"
#include "impedraw/run/reaction.h"
#include "impedraw/run/run.h"

namespace impedraw {

class ArmMonitors {
 public:
  ArmMonitors(const Experiment& experiment, const Driver& driver, const RunHooks& hooks);

  // The worst verdict on a cycle. `blocked`: the pen is being lifted at a blocked place.
  Verdict judge(const Cycle& cycle, const Reaction& reaction, bool blocked);

  // The joints' speed, as far as the positions confirm it [rad/s].
  JointVector confirmed_speed(const ArmState& state) const { return reading_.confirmed(state); }
  TareMonitor& tare() { return tare_; }

 private:
  Verdict emergency(const Cycle& cycle) const;

  const Driver& driver_;
  const RunHooks& hooks_;
  StateMonitor state_;
  TareMonitor tare_;
  ReadingMonitor reading_;
  SignMonitor signs_;
  FenceMonitor fences_;
  SpeedMonitor speed_;
  RattleMonitor rattle_;
  StepTimeMonitor step_time_;
};

}  // namespace impedraw
