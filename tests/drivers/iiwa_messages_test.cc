// The codec against bytes that Drake 1.51.1 encoded (pydrake's lcmt_iiwa_*.encode()).
// tests/foreign/drake compares with the running Drake.
#include "impedraw/drivers/iiwa_lcm.h"

#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes from_hex(const std::string& text) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(text.substr(i, 2), nullptr, 16)));
  return bytes;
}

// utime 123456789, no positions, torques 1, 2, 3, 4, 5, 6, 7.5
const char* const kCommand =
    "ddc7c7738c81533400000000075bcd1500000000000000073ff00000000000004000000000000000"
    "40080000000000004010000000000000401400000000000040180000000000"
    "00401e000000000000";
// utime 1024999; entry j of field k is k + j/8
const char* const kStatus =
    "f16fb804284abca300000000000fa3e700000007"
    "00000000000000003fc00000000000003fd00000000000003fd80000000000003fe0000000000000"
    "3fe40000000000003fe8000000000000"
    "3ff00000000000003ff20000000000003ff40000000000003ff60000000000003ff8000000000000"
    "3ffa0000000000003ffc000000000000"
    "40000000000000004001000000000000400200000000000040030000000000004004000000000000"
    "40050000000000004006000000000000"
    "40080000000000004009000000000000400a000000000000400b000000000000400c000000000000"
    "400d000000000000400e000000000000"
    "4010000000000000401080000000000040110000000000004011800000000000401200000000000040128000000000"
    "00"
    "4013000000000000"
    "40140000000000004014800000000000401500000000000040158000000000004016000000000000"
    "40168000000000004017000000000000"
    "4018000000000000401880000000000040190000000000004019800000000000401a000000000000401a8000000000"
    "00"
    "401b000000000000";
// timestamp 5, fx 1.5, tz −2
const char* const kWrench =
    "73206439325b65c500000000000000053ff80000000000000000000000000000000000000000000000000000000000"
    "00"
    "0000000000000000c000000000000000";

TEST(IiwaMessages, CommandIsWhatDrakeEncodes) {
  JointVector torque(7);
  torque << 1, 2, 3, 4, 5, 6, 7.5;
  std::array<std::uint8_t, kIiwaCommandSize> bytes;
  encode_iiwa_command(123456789, torque, bytes);
  EXPECT_EQ(Bytes(bytes.begin(), bytes.end()), from_hex(kCommand));
}

TEST(IiwaMessages, StatusOfDrakeIsRead) {
  ArmStatus status(7);
  ASSERT_EQ(decode_iiwa_status(from_hex(kStatus), &status), Decoded::ok);
  EXPECT_EQ(status.utime, 1024999);
  for (int j = 0; j < 7; ++j) {
    EXPECT_EQ(status.q[j], j / 8.0);
    EXPECT_EQ(status.v[j], 1 + j / 8.0);
    EXPECT_EQ(status.external[j], 6 + j / 8.0);
  }
}

TEST(IiwaMessages, WrenchOfDrakeIsRead) {
  TipWrench wrench;
  ASSERT_EQ(decode_tip_wrench(from_hex(kWrench), &wrench), Decoded::ok);
  EXPECT_EQ(wrench.utime, 5);
  EXPECT_EQ(wrench.wrench, (Vector6() << 1.5, 0, 0, 0, 0, -2).finished());
}

// Cut short, too long, of another type or another arm: refused by name, and nothing is changed.
TEST(IiwaMessages, OtherBytesAreRefused) {
  const Bytes good = from_hex(kStatus);
  ArmStatus status(7);
  const auto result = [&](const Bytes& bytes) { return decode_iiwa_status(bytes, &status); };
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_EQ(result(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size))),
              Decoded::wrong_size);
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_EQ(result(longer), Decoded::wrong_size);
  Bytes other = good;
  other[3] ^= 1;
  EXPECT_EQ(result(other), Decoded::other_type);
  Bytes six = good;
  six[19] = 6;
  EXPECT_EQ(result(six), Decoded::wrong_joints);
  EXPECT_EQ(status.utime, 0);
  EXPECT_TRUE(status.v.isZero());
  TipWrench wrench;
  EXPECT_EQ(decode_tip_wrench(good, &wrench), Decoded::other_type);
  EXPECT_EQ(decode_tip_wrench(Bytes(7), &wrench), Decoded::wrong_size);
}

}  // namespace
}  // namespace impedraw
