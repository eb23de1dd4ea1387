// KUKA's LBR iiwa through LCM, driven by torque alone: the messages of drake-iiwa-driver and of
// Drake's simulated iiwa (iiwa_messages.h), the session of arm_session.h.
//
// Clock    ArmSettings::clock. In lock-step each status is answered by one command that carries the
//          status's own utime, and the arm waits for it: after the session's quiet time, whoever
//          simulates waits from the first command on. On a wall clock the newest status is
//          answered, and the loop must not wait: see docs/arm-iiwa.md.
// State    positions and velocities of the status. The status's torques are never taken for force.
// Wrench   of the channel IMPEDRAW_TIP_WRENCH, where the scenario wants one. A stamp that is more
//          than SessionSettings::max_gap ahead of the newest status, or 1 s before the first, is a
//          fault.
// Torque   without gravity: the arm adds its own.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "impedraw/arm/arm_model.h"
#include "impedraw/drivers/arm_session.h"
#include "impedraw/drivers/foreign_arm.h"
#include "impedraw/drivers/iiwa_messages.h"
#include "impedraw/drivers/lcm_link.h"
#include "impedraw/experiment/scenario.h"

namespace impedraw {

class IiwaLcm : public ForeignArm {
 public:
  // start_q: where the arm must stand at start(), within kStartTolerance; nothing: anywhere.
  // `arm` is asked for limits and inertia here only. Throws InputError if it cannot be an iiwa's
  // model.
  IiwaLcm(const ArmSettings& settings, const ArmModel& arm, double period,
          std::optional<JointVector> start_q, bool wrench);
  ~IiwaLcm() override;

  DriverInfo info() const override;
  void start() override;
  const ArmState& read() noexcept override;
  void command(const JointVector& tau, const JointVector& gravity) noexcept override;
  const std::string& fault() const noexcept override { return fault_; }
  void stop() noexcept override;

  void hold() noexcept override;
  const ArmSession& session() const { return *session_; }
  Counts counts() const noexcept override;
  void observe(double seconds, const Seen& seen) override;

 private:
  void connect();
  // Receives until a status is to be answered or `until` [s]; true if there is one.
  bool receive(double until) noexcept;
  void send(const JointVector& wanted, bool stale) noexcept;
  void require_wrench_stamp(std::int64_t utime) noexcept;
  void note_fault() noexcept;

  ArmSettings settings_;
  double period_;
  std::vector<std::string> joint_names_;
  ArmLimits limits_;
  std::optional<JointVector> start_q_;
  bool wants_wrench_;
  SessionSettings session_settings_;
  std::unique_ptr<LcmLink> link_;
  std::unique_ptr<ArmSession> session_;
  ArmStatus decoded_;
  TipWrench wrench_;
  bool decoded_any_ = false, wrench_any_ = false, answerable_ = false, began_ = false;
  long statuses_ = 0, answered_ = 0;
  double read_at_ = 0.0, last_step_ = 0.0;  // [s]
  std::int64_t first_utime_ = 0;
  std::string misread_;  // why a message could not be read
  ArmState state_;
  JointVector wanted_, zero_;
  std::string fault_;
};

}  // namespace impedraw
