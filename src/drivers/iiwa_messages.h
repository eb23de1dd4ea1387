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
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "impedraw/common/pose.h"
#include "impedraw/drivers/arm_session.h"

namespace impedraw {

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

}  // namespace impedraw
