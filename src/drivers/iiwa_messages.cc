#include "impedraw/drivers/iiwa_messages.h"

#include <bit>

#include "impedraw/drivers/big_endian.h"

namespace impedraw {

namespace {

constexpr std::uint64_t kStatusType = 0xf16fb804284abca3, kCommandType = 0xddc7c7738c815334,
                        kForceTorqueType = 0x73206439325b65c5;

double get_double(const std::uint8_t** from) {
  return std::bit_cast<double>(get_big_endian(8, from));
}

}  // namespace

const char* name_of(Decoded result) {
  switch (result) {
    case Decoded::ok:
      return "ok";
    case Decoded::other_type:
      return "of another type";
    case Decoded::wrong_size:
      return "of the wrong size";
    case Decoded::wrong_joints:
      return "of an arm that has not seven joints";
  }
  return "?";
}

void encode_iiwa_command(std::int64_t utime, const JointVector& torque,
                         std::span<std::uint8_t, kIiwaCommandSize> bytes) noexcept {
  std::uint8_t* to = bytes.data();
  put_big_endian(kCommandType, 8, &to);
  put_big_endian(static_cast<std::uint64_t>(utime), 8, &to);
  put_big_endian(0, 4, &to);
  put_big_endian(kIiwaJoints, 4, &to);
  for (int j = 0; j < kIiwaJoints; ++j)
    put_big_endian(std::bit_cast<std::uint64_t>(torque[j]), 8, &to);
}

Decoded decode_iiwa_status(std::span<const std::uint8_t> bytes, ArmStatus* status) noexcept {
  const std::uint8_t* from = bytes.data();
  if (bytes.size() < 20) return Decoded::wrong_size;
  if (get_big_endian(8, &from) != kStatusType) return Decoded::other_type;
  const auto utime = static_cast<std::int64_t>(get_big_endian(8, &from));
  if (get_big_endian(4, &from) != kIiwaJoints) return Decoded::wrong_joints;
  if (bytes.size() != 20 + 7 * 8 * kIiwaJoints) return Decoded::wrong_size;
  status->utime = utime;
  for (int j = 0; j < kIiwaJoints; ++j) status->q[j] = get_double(&from);
  for (int j = 0; j < kIiwaJoints; ++j) status->v[j] = get_double(&from);
  from += 4 * 8 * kIiwaJoints;  // commanded, interpolated, measured and commanded torque
  for (int j = 0; j < kIiwaJoints; ++j) status->external[j] = get_double(&from);
  return Decoded::ok;
}

Decoded decode_tip_wrench(std::span<const std::uint8_t> bytes, TipWrench* wrench) noexcept {
  const std::uint8_t* from = bytes.data();
  if (bytes.size() < 8) return Decoded::wrong_size;
  if (get_big_endian(8, &from) != kForceTorqueType) return Decoded::other_type;
  if (bytes.size() != 16 + 6 * 8) return Decoded::wrong_size;
  wrench->utime = static_cast<std::int64_t>(get_big_endian(8, &from));
  for (int i = 0; i < 6; ++i) wrench->wrench[i] = get_double(&from);
  return Decoded::ok;
}

}  // namespace impedraw
