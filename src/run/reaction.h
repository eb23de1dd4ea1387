// A run's reactions to verdicts (monitors/verdict.h): one state, one table.
//
//            hold    leave   lift    brake   halt   damp   lose
//   follow   follow  done    lift    brake   halt   damp   over
//   lift     lift    lift    lift    brake   halt   damp   over
//   brake    brake   brake   brake   brake   halt   damp   over
//   rise     rise    rise    rise    brake   halt   damp   over
//   halt     halt    halt    halt    halt    halt   damp   over
//   damp     damp    damp    damp    damp    damp   damp   over
//
//   follow   a move, by the control law
//   lift     the pen goes up by the control law     ──up──>           done
//   brake    the motion is damped                   ──calm──>         rise
//   rise     the pen goes up while it is damped     ──up, at rest──>  done
//   halt     the motion is damped                   ──calm──>         over
//   damp     the joints alone are damped            ──calm──>         over
//   done     the move has ended; the next one follows, unless the run has ended
//   over     nothing more is commanded
#pragma once

#include <algorithm>

#include "impedraw/control/joint_speed_shares.h"
#include "impedraw/metrics/ending.h"
#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"

namespace impedraw {

class Reaction {
 public:
  enum class State { follow, lift, brake, rise, halt, damp, done, over };
  static constexpr double kLongestBrake = 0.5;  // [s]

  static constexpr State next(State state, Severity severity) noexcept {
    switch (severity) {
      case Severity::none:
      case Severity::hold:
        return state;
      case Severity::leave:
        return state == State::follow ? State::done : state;
      case Severity::lift:
        return state == State::follow ? State::lift : state;
      case Severity::brake:
        return std::max(state, State::brake) <= State::rise ? State::brake : state;
      case Severity::halt:
        return std::max(state, State::halt);
      case Severity::damp:
        return std::max(state, State::damp);
      case Severity::lose:
        return State::over;
    }
    return state;
  }

  // The ending is the run's, and is kept here.
  explicit Reaction(Ending* ending) : ending_(ending) {}

  // A move begins.
  void begin() noexcept {
    if (state_ != State::over) state_ = State::follow;
    cause_.clear();
  }

  void take(const Verdict& verdict) {
    if (!verdict) return;
    if (verdict.severity >= Severity::halt && verdict.severity <= Severity::damp)
      halt(verdict.cause);
    else
      stop(verdict);
    const bool braked = brakes();
    state_ = next(state_, verdict.severity);
    if (!brakes() || verdict.severity < Severity::brake) return;
    calm_ = std::min(calm_, state_ == State::brake ? verdict.calm : JointSpeedShares::kStill);
    if (!braked) braked_ = 0.0;
  }

  // After a cycle that was damped. share: the fastest joint's, of its speed limit. True once the
  // motion is calm.
  bool calms(double share, double dt) noexcept {
    braked_ += dt;
    if (share >= calm_ && braked_ <= kLongestBrake) return false;
    state_ = state_ == State::brake ? State::rise : State::over;
    return true;
  }
  // The pen is up.
  void done() noexcept { state_ = State::done; }
  void end() noexcept { state_ = State::over; }

  State state() const noexcept { return state_; }
  bool brakes() const noexcept { return state_ == State::brake || state_ == State::halt; }
  bool lost_control() const noexcept { return brakes() || state_ == State::rise; }
  // The reason that the motion was damped, if the drawing goes on; else empty.
  std::string& cause() noexcept { return cause_; }

 private:
  void stop(const Verdict& verdict) {
    const bool runs = ending_->end == RunEnd::finished;
    if (verdict.severity == Severity::brake && verdict.end == RunEnd::finished)
      cause_ = verdict.cause;
    if (verdict.severity == Severity::lose && state_ >= State::brake && state_ <= State::rise)
      ending_->cause += "; before the tip was up, " + verdict.cause;
    if (!runs || verdict.end == RunEnd::finished || verdict.severity < Severity::lift) return;
    ending_->end = verdict.end;
    ending_->cause = verdict.cause;
  }
  // Also while the pen of a run that was stopped or interrupted is lifted.
  void halt(const std::string& cause) {
    const bool stopped = ending_->end == RunEnd::stopped;
    ending_->end = RunEnd::stopped;
    ending_->cause = stopped ? ending_->cause + "; then " + cause : cause;
  }

  Ending* ending_;
  State state_ = State::follow;
  std::string cause_;
  double calm_ = JointSpeedShares::kCalm;  // share below which braking ends
  double braked_ = 0.0;                    // [s]
};

// Decides if a drawing goes on after a motion that had to be damped. An arm that drew well before
// cannot pass this one place, a singular posture for instance. Otherwise the arm, its set-up or a
// hand is to blame, and the run ends.
class SecondChance {
 public:
  static constexpr int kMost = 3;        // in one run
  static constexpr double kDrawn = 2.0;  // with ink, since the last one [s]
  static constexpr double kAlone = 0.5;  // since a hand pushed [s]
  static constexpr double kHand = 20.0;  // force that the push of the pen does not explain [N]

  // possible: the surface is perceived, and ink is wanted.
  explicit SecondChance(bool possible) : possible_(possible) {}

  // After each cycle.
  void update(const Cycle& cycle) noexcept {
    if (cycle.inked && cycle.desired.stroke >= 0) drawn_ += cycle.dt;
    const Eigen::Vector3d unexplained = cycle.F_ext.head<3>() - cycle.out.push * cycle.out.n_WD;
    alone_ = unexplained.norm() < kHand ? alone_ + cycle.dt : 0.0;
    stands_ = !cycle.canvas.follows();
  }
  bool given() const noexcept {
    return possible_ && stands_ && taken_ < kMost && drawn_ > kDrawn && alone_ > kAlone;
  }
  // The motion was damped, and the drawing goes on.
  void take() noexcept {
    ++taken_;
    drawn_ = 0.0;
  }

 private:
  bool possible_, stands_ = false;
  int taken_ = 0;
  double drawn_ = 0.0, alone_ = 0.0;  // [s]
};

}  // namespace impedraw
