// The FCI's messages against bytes that franka-sim 1.1.7 packed (tests/data/franka_sim_state.bin,
// which its RobotState made of the numbers below), and against the protocol's own layout.
#include "impedraw/drivers/fci_link.h"

#include <bit>
#include <fstream>
#include <iterator>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace impedraw {
namespace {

std::vector<std::uint8_t> captured() {
  std::ifstream file("tests/data/franka_sim_state.bin", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(FciMessages, ReadsTheStateThatFrankaSimPacks) {
  FciState state;
  ASSERT_TRUE(decode_fci_state(captured(), &state));
  EXPECT_EQ(state.message_id, 123456789012u);
  EXPECT_EQ(state.arm.utime, 123456789012000);
  for (int j = 0; j < 7; ++j) {
    EXPECT_FLOAT_EQ(static_cast<float>(state.arm.q[j]), static_cast<float>(0.1 * j - 0.25));
    EXPECT_EQ(state.arm.v[j], -0.5 + 0.125 * j);
    EXPECT_EQ(state.arm.external[j], (j % 2 ? -1.0 : 1.0) * (1.5 + j));
  }
  EXPECT_EQ(state.mode, FciMode::reflex);
  EXPECT_TRUE(state.external_controller);
  EXPECT_EQ(fci_errors(state.errors), "controller_torque_discontinuity");
  EXPECT_EQ(fci_errors(state.reflex_reason),
            "joint_velocity_violation, communication_constraints_violation");
  EXPECT_EQ(state.success_rate, 0.75);
}

TEST(FciMessages, AStateOfAnotherSizeChangesNothing) {
  std::vector<std::uint8_t> bytes = captured();
  FciState state;
  state.message_id = 7;
  bytes.push_back(0);
  EXPECT_FALSE(decode_fci_state(bytes, &state));
  bytes.resize(kFciStateSize - 1);
  EXPECT_FALSE(decode_fci_state(bytes, &state));
  EXPECT_FALSE(decode_fci_state({}, &state));
  EXPECT_EQ(state.message_id, 7u);
}

// Offsets counted from the layout in the header.
TEST(FciMessages, WritesTorqueAndEndWhereTheProtocolHasThem) {
  JointVector torque(7);
  torque << 1, -2, 3, -4, 5, -6, 7;
  std::array<std::uint8_t, kFciCommandSize> bytes;
  encode_fci_torque(0x0102030405060708, torque, true, bytes);
  EXPECT_EQ(bytes[0], 8);
  EXPECT_EQ(bytes[7], 1);
  for (std::size_t i = 8; i < 314; ++i) EXPECT_EQ(bytes[i], 0) << i;
  for (std::size_t j = 0; j < 7; ++j) {
    std::array<std::uint8_t, 8> number;
    std::copy_n(bytes.begin() + 314 + 8 * j, 8, number.begin());
    EXPECT_EQ(std::bit_cast<double>(number), torque[static_cast<Eigen::Index>(j)]);
  }
  EXPECT_EQ(bytes[370], 1);
}

TEST(FciMessages, RequestsCarryTheirSize) {
  const auto bytes = encode_fci_request(FciCommand::move, 9, fci_torque_move());
  ASSERT_EQ(bytes.size(), 12u + 8 + 6 * 8);
  const FciHeader header =
      decode_fci_header(std::span<const std::uint8_t, kFciHeaderSize>(bytes.data(), 12));
  EXPECT_EQ(header.command, 1u);
  EXPECT_EQ(header.id, 9u);
  EXPECT_EQ(header.size, bytes.size());
  EXPECT_EQ(bytes[12], 2);  // external controller
  EXPECT_EQ(bytes[16], 4);  // no motion generator
  EXPECT_EQ(fci_collision_behavior({}, {}).size(), 8u * (4 * 7 + 4 * 6));
}

TEST(FciMessages, ACollisionIsNothingToGoOnAfter) {
  std::array<std::uint8_t, 41> flags{};
  EXPECT_FALSE(fci_collision(flags));
  flags[32] = flags[25] = flags[3] = 1;
  EXPECT_FALSE(fci_collision(flags));
  flags[7] = 1;
  EXPECT_TRUE(fci_collision(flags));
  EXPECT_THAT(fci_errors(flags), ::testing::HasSubstr("cartesian_reflex"));
}

}  // namespace
}  // namespace impedraw
