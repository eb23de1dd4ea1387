// From an arm's first status to the last zero torque: the states of a session with a torque-driven
// arm, and what may be sent in each. Pure: no sockets, no clock of its own. Every driver of a real
// arm uses it.
//
//   state     sent in answer to a status                           leaves it
//   waiting   nothing                                              first status
//   quiet     nothing: the arm refuses commands at first           quiet_time, arm's clock and wall
//   start     r τ, r from 0 to 1 over ramp_time                    ramp over
//   run       τ as wanted
//   hold      0: the arm carries its own weight
//   fault     damping, then 0                                      0 sent after damp_time
//   stop      damping, then 0                                      0 sent after damp_time
//   ended     nothing; the last command was 0 (or none was sent)
//
// Any state but ended goes to fault on a fault and to stop on a request; a fault during a stop
// stays a stop with a named cause. In every state |τ_j| ≤ torque_limit_j and
// |Δτ_j| ≤ torque_rate Δt, with Δt from the arm's clock, at most longest_step. The speed that
// is damped is the measured one as far as positions confirm it.
//
// Faults besides speed, external torque, silence and numbers that are not finite: positions that
// contradict speed or torque (motion_check.h); a clock that jumps by more than max_gap while the
// arm is driven, by more than ArmSession::kLongestJump ever, that stands still, or that goes back.
//
// τ is without gravity: the arm compensates its own weight.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/control/arm_terms.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/run/driver.h"
#include "impedraw/run/motion_check.h"

namespace impedraw {

struct ArmStatus {
  std::int64_t utime = 0;  // the arm's clock [µs]
  JointVector q, v;        // [rad], [rad/s]
  JointVector external;    // external joint torque as the arm estimates it [Nm]

  explicit ArmStatus(int joints) : q(JointVector::Zero(joints)), v(q), external(q) {}
};

struct SessionSettings {
  // One entry per joint, all positive.
  JointVector torque_limit;    // without gravity [Nm]
  JointVector rated_speed;     // of MotionCheck [rad/s]
  JointVector speed_limit;     // a faster joint is a fault [rad/s]
  JointVector external_limit;  // a larger external torque is a fault [Nm]
  // The torque [Nm] that damps v [rad/s] at the posture q, as damping_torque(); must not throw or
  // allocate.
  std::function<JointVector(const JointVector& q, const JointVector& v)> damping;
  JointMatrix inertia{};         // of MotionCheck, where the drawing starts; empty: none [kg m²]
  double torque_rate = 900.0;    // [Nm/s]
  double longest_step = 2e-3;    // of the torque rate's Δt [s]
  double quiet_time = 0.25;      // [s]
  double ramp_time = 0.2;        // [s]
  double damp_time = kDampTime;  // longest [s]
  double max_silence = 0.05;     // without a new status, by the wall clock [s]
  double max_gap = 0.02;         // between two statuses, by the arm's clock [s]
};

enum class SessionState { waiting, quiet, start, run, hold, fault, stop, ended };
const char* name_of(SessionState state);

class ArmSession {
 public:
  static constexpr int kMostOld = 20;           // statuses in a row that are older than the last
  static constexpr double kLongestJump = 10.0;  // between two statuses, in any state [s]

  // Throws std::invalid_argument if a limit is not positive or the sizes differ.
  explicit ArmSession(const SessionSettings& settings);

  // The following do not throw and do not allocate, but for the text of a fault.

  // A status that arrived at `now` [s of the wall clock]. Returns true if it is to be answered: it
  // is newer than the last, and the state allows sending.
  bool receive(const ArmStatus& status, double now) noexcept;
  // Notices silence.
  void tick(double now) noexcept;

  void hold() noexcept;
  void run() noexcept;  // after hold()
  void stop() noexcept;
  void fail(const std::string& cause) noexcept;  // the first cause stays

  // The torque that answers the last status; `wanted` counts in start and run alone. Call once for
  // each status that receive() asks to answer. Without a new status (`stale`), in stop and fault:
  // lowers the torque to zero at torque_rate.
  const JointVector& answer(const JointVector& wanted, bool stale = false) noexcept;

  SessionState state() const noexcept { return state_; }
  const std::string& cause() const noexcept { return cause_; }  // of a fault; empty: none
  bool may_send() const noexcept;
  bool sent_any() const noexcept { return sent_any_; }
  const ArmStatus& last() const noexcept { return last_; }
  const JointVector& sent() const noexcept { return sent_; }
  // Mean time between two statuses by the arm's clock [s]; NaN before the second.
  double mean_step() const noexcept;
  long missed() const noexcept { return missed_; }  // statuses, by the gaps in the arm's clock

 private:
  enum class Event { status, quiet_over, ramped, hold, run, stop, fail, at_rest };
  void apply(Event event) noexcept;
  void check(const ArmStatus& status, double step) noexcept;

  SessionSettings settings_;
  SessionState state_ = SessionState::waiting;
  ArmStatus last_;
  double first_arrival_ = 0.0, last_arrival_ = 0.0;  // [s]
  std::int64_t first_utime_ = 0, entered_ = 0;       // [µs]
  std::int64_t answered_ = 0;                        // utime [µs]
  double usual_ = 0.0;                               // step [s]
  MotionCheck motion_;
  double damped_ = 0.0;  // time in fault or stop [s]
  int old_ = 0;
  long missed_ = 0, received_ = 0;
  bool sent_any_ = false, damping_over_ = false;
  JointVector sent_;
  std::string cause_;
};

// b − a of the arm's clock [µs], whatever the two are [s].
inline double seconds_between(std::int64_t a, std::int64_t b) noexcept {
  const auto from = static_cast<std::uint64_t>(a), to = static_cast<std::uint64_t>(b);
  return 1e-6 * (b < a ? -static_cast<double>(from - to) : static_cast<double>(to - from));
}

// An arm that is not simulated here: what `arm check` and `arm hold` need of its driver.

// The wall clock [s].
inline double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

class ForeignArm : public Driver {
 public:
  static constexpr double kStartTolerance = 0.02;  // of each joint [rad]
  static constexpr double kPatience = 2.0;         // for the first state, at start() [s]

  struct Counts {
    long statuses = 0, answered = 0;  // received; answered by a command
    long missed = 0;                  // never received, by the arm's clock
  };
  // Called with each status and when it arrived [s of the wall clock].
  using Seen = std::function<void(const ArmStatus&, double now)>;

  const std::string& fault() const noexcept override { return fault_; }
  // From now on zero torque: the arm carries itself.
  virtual void hold() noexcept = 0;
  Counts counts() const noexcept {
    return {statuses_, answered_, session_ ? session_->missed() : 0};
  }
  // Connects and receives statuses for `seconds`, and sends no torque. Throws as start() does.
  virtual void observe(double seconds, const Seen& seen) = 0;

 protected:
  ForeignArm(const ArmSettings& settings, int joints, double period,
             std::optional<JointVector> start_q)
      : settings_(settings),
        period_(period),
        start_q_(std::move(start_q)),
        state_(joints),
        wanted_(JointVector::Zero(joints)),
        zero_(wanted_) {}

  // Receives until a status is to be answered or `until` [s]; true if there is one.
  virtual bool receive(double until) noexcept = 0;
  // Answers the newest status, or commands without one if that is stale.
  virtual void send(const JointVector& wanted, bool stale) noexcept = 0;
  virtual bool reachable() const noexcept = 0;
  // Damps and lowers the torque to zero, in answer to statuses; without them, by itself.
  void wind_down() noexcept;
  void note_session_fault() noexcept;

  ArmSettings settings_;
  double period_;
  std::optional<JointVector> start_q_;
  std::unique_ptr<ArmSession> session_;
  bool answerable_ = false;
  long statuses_ = 0, answered_ = 0;
  std::int64_t first_utime_ = 0;
  double read_at_ = 0.0, last_step_ = 0.0;  // [s]
  ArmState state_;
  JointVector wanted_, zero_;
  std::string fault_;
};

// Limits of a session with the arm: the model's torques; somewhat more than its speeds, since the
// arm's own limit comes first, with a reflex that can be recovered from; nine tenths of the
// `external` torques at which the arm ends a session itself [Nm]. The inertia is that at
// the posture.
SessionSettings session_settings(const ArmSettings& settings, ArmModel arm,
                                 const JointVector& posture, std::span<const double> external);

// Throws std::runtime_error that names the joint, unless all joints are within their range and,
// where start_q is given, within ForeignArm::kStartTolerance of it.
void require_posture(const JointVector& q, const ArmLimits& limits,
                     const std::vector<std::string>& joint_names,
                     const std::optional<JointVector>& start_q);

}  // namespace impedraw
