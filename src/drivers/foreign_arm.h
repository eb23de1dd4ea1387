// An arm that is not simulated here: what `arm check` and `arm hold` need of its driver.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/drivers/arm_session.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/run/driver.h"

namespace impedraw {

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

  // From now on zero torque: the arm carries itself.
  virtual void hold() noexcept = 0;
  virtual Counts counts() const noexcept = 0;
  // Connects and receives statuses for `seconds`, and sends no torque. Throws as start() does.
  virtual void observe(double seconds, const Seen& seen) = 0;
};

// Limits of a session with the arm: the model's torques; somewhat more than its speeds, since the
// arm's own limit comes first, with a reflex that can be recovered from; nine tenths of the
// `external` torques at which the arm ends a session itself [Nm]. Damping and inertia are those at
// the posture.
SessionSettings session_settings(const ArmSettings& settings, ArmModel arm,
                                 const JointVector& posture, std::span<const double> external);

// Throws std::runtime_error that names the joint, unless all joints are within their range and,
// where start_q is given, within ForeignArm::kStartTolerance of it.
void require_posture(const JointVector& q, const ArmLimits& limits,
                     const std::vector<std::string>& joint_names,
                     const std::optional<JointVector>& start_q);

}  // namespace impedraw
