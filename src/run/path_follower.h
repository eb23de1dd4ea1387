// Follows one path: where the plan is, in a time of its own that yields where the pen does not
// follow (plan_clock.h).
#pragma once

#include <cstddef>
#include <functional>

#include "impedraw/experiment/experiment.h"
#include "impedraw/run/cycle.h"
#include "impedraw/run/drawing_task.h"
#include "impedraw/run/driven_arm.h"
#include "impedraw/run/joint_forecast.h"
#include "impedraw/run/odometer.h"
#include "impedraw/run/plan_clock.h"
#include "impedraw/run/run.h"

namespace impedraw {

class PathFollower {
 public:
  // From now on, by the arm's clock. `move` must outlive this.
  PathFollower(const Experiment& experiment, const DrivenArm& arm, const Move& move);

  // Returns true if the plan has not come to its end after so many cycles.
  bool goes_on(long cycles) const;
  // The plan's sample for now; nothing: the path ends here. `up`: the pen is being lifted, and has
  // left the plan. holds: asks Move::holds.
  std::optional<PathSample> sample(bool up, const std::function<bool()>& holds);
  // After a cycle of a perceived surface that followed the plan: its clock. held: it stands.
  void advance(const Cycle& cycle, bool held);
  // The same for a surface that is found by touch. False: it is not where it may be.
  bool advance_by_touch(const Cycle& cycle, const ControlLoop& loop, bool paused);
  // True once: in the first cycle in which the last stroke is behind and the pen off a canvas that
  // it moves with.
  bool passes_last_stroke(const Cycle& cycle);

  // True once at each of the path's pauses.
  bool comes_to_pause() {
    const std::vector<double>& pauses = path().pauses();
    return pauses_ < pauses.size() && planned_ >= pauses[pauses_] && ++pauses_ > 0;
  }

  RunProgress progress(double run_time) const;
  double planned() const noexcept { return planned_; }  // the plan's time at the last sample [s]
  double rate() const noexcept { return clock_.rate(); }
  const TipPath& path() const noexcept { return move_.path; }
  bool by_touch() const noexcept { return move_.touch.has_value(); }
  std::size_t strokes_followed() const noexcept { return followed_; }  // to their ends

 private:
  PenDeviation deviation(const Cycle& cycle) const;

  const Experiment& e_;
  const DrivenArm& arm_;
  const Move& move_;
  double begin_;  // by the arm's clock [s]
  PlanClock clock_;
  JointForecast forecast_;
  Odometer odometer_;
  double planned_ = 0.0;                   // [s]
  std::size_t followed_ = 0, pauses_ = 0;  // strokes; pauses that were come to
  Phase last_phase_ = Phase::travel;
  bool down_ = false, past_ = false;
};

}  // namespace impedraw
