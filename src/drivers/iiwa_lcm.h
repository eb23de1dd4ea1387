// KUKA's LBR iiwa through LCM, driven by torque alone: the messages of drake-iiwa-driver and of
// Drake's simulated iiwa, the session of arm_session.h.
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

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "impedraw/arm/arm_model.h"
#include "impedraw/common/pose.h"
#include "impedraw/drivers/arm_session.h"
#include "impedraw/drivers/lcm_link.h"
#include "impedraw/experiment/scenario.h"

namespace impedraw {

// The LCM messages of the KUKA LBR iiwa, as drake-iiwa-driver and Drake's IiwaDriver speak them,
// and of the wrench at the tip. Encoded as LCM does: a fingerprint of the type, then the fields in
// order, big-endian. Checked against Drake's encoder (tests/drivers, tests/foreign/drake).
//
//   lcmt_iiwa_command  { int64 utime; int32 num_joints; double joint_position[num_joints];
//                        int32 num_torques; double joint_torque[num_torques]; }
//   lcmt_iiwa_status   { int64 utime; int32 num_joints; double[num_joints]
//                        joint_position_measured, joint_velocity_estimated,
//                        joint_position_commanded, joint_position_ipo, joint_torque_measured,
//                        joint_torque_commanded, joint_torque_external; }
//   lcmt_force_torque  { int64 timestamp; double fx, fy, fz, tx, ty, tz; }

inline constexpr int kIiwaJoints = 7;
inline constexpr const char* kIiwaCommandChannel = "IIWA_COMMAND";
inline constexpr const char* kIiwaStatusChannel = "IIWA_STATUS";
// Wrench of the environment on the tip, at E in W, from whoever measures it. Our own channel: the
// iiwa's protocol has none.
inline constexpr const char* kTipWrenchChannel = "IMPEDRAW_TIP_WRENCH";

// A command of torques alone.
inline constexpr std::size_t kIiwaCommandSize = 8 + 8 + 4 + 4 + 8 * kIiwaJoints;
void encode_iiwa_command(std::int64_t utime, const JointVector& torque,
                         std::span<std::uint8_t, kIiwaCommandSize> bytes) noexcept;

enum class Decoded { ok, other_type, wrong_size, wrong_joints };
const char* name_of(Decoded result);

// Leaves `status` as it is unless the result is ok.
Decoded decode_iiwa_status(std::span<const std::uint8_t> bytes, ArmStatus* status) noexcept;

struct TipWrench {
  std::int64_t utime = 0;  // when it was measured, by the arm's clock [µs]
  Vector6 wrench = Vector6::Zero();
};
Decoded decode_tip_wrench(std::span<const std::uint8_t> bytes, TipWrench* wrench) noexcept;

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
  void stop() noexcept override;

  void hold() noexcept override;
  const ArmSession& session() const { return *session_; }
  void observe(double seconds, const Seen& seen) override;

 private:
  void connect();
  bool receive(double until) noexcept override;
  void send(const JointVector& wanted, bool stale) noexcept override;
  bool reachable() const noexcept override { return link_->connected(); }
  void require_wrench_stamp(std::int64_t utime) noexcept;

  std::vector<std::string> joint_names_;
  ArmLimits limits_;
  bool wants_wrench_;
  SessionSettings session_settings_;
  std::unique_ptr<LcmLink> link_;
  ArmStatus decoded_;
  TipWrench wrench_;
  bool decoded_any_ = false, wrench_any_ = false, began_ = false;
  std::string misread_;  // why a message could not be read
};

}  // namespace impedraw
