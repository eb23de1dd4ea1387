// Follows one path: where the plan is, in a time of its own that yields where the pen does not
// follow (plan_clock.h).
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/run/cycle.h"
#include "impedraw/run/drawing_task.h"
#include "impedraw/run/driven_arm.h"
#include "impedraw/run/plan_clock.h"
#include "impedraw/run/run.h"

namespace impedraw {

// Forecast of the joints' speeds along a planned path, as a limit on the plan's clock.
//
// The planner times strokes by the joints' limits (joint_rates.h), but the ways between strokes by
// tip speed and turning alone: near a singular posture a slow turn of the pen is a fast one of two
// joints. Before the path is followed, the postures along it are integrated with the least kinetic
// energy, as under the controller. Where a joint would exceed `share` of its speed limit, the clock
// may run at most so fast that it does not.
class JointForecast {
 public:
  JointForecast() = default;
  // From posture q at the beginning of the path. rest_q: the null space's.
  JointForecast(ArmModel arm, const TipPath& path, const JointVector& q, const JointVector& rest_q,
                double share);

  // Greatest rate of the clock at the plan's time t, 0 … 1: the least from t to kAhead later.
  double limit(double t) const noexcept;

 private:
  static constexpr double kStep = 0.02, kAhead = 0.3;  // [s]
  std::vector<float> limits_;
};

// Measures progress along a path: strokes begun and pen-down length drawn.
class Odometer {
 public:
  explicit Odometer(const TipPath& path) : path_(path), before_(1, 0.0) {
    for (const StrokeTimes& s : path.strokes()) before_.push_back(before_.back() + s.length);
  }
  void read(double t, RunProgress* progress) const {
    const auto& strokes = path_.strokes();
    const auto begun =
        std::upper_bound(strokes.begin(), strokes.end(), t,
                         [](double at, const StrokeTimes& s) { return at < s.approach; });
    const auto i = static_cast<std::size_t>(begun - strokes.begin());
    progress->stroke = static_cast<int>(i);
    progress->strokes = static_cast<int>(strokes.size());
    progress->length = before_.back();
    progress->drawn = before_[i];
    if (i == 0) return;
    const StrokeTimes& s = strokes[i - 1];
    const double share = s.end > s.start ? std::clamp((t - s.start) / (s.end - s.start), 0.0, 1.0)
                                         : (t >= s.end ? 1.0 : 0.0);
    progress->drawn -= (1.0 - share) * s.length;
  }

 private:
  const TipPath& path_;
  std::vector<double> before_;  // [m]
};

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
