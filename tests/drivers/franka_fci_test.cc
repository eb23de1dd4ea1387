// The driver against a made-up arm at the other end of its sockets, with the URDF of models/arms.
#include "impedraw/drivers/franka_fci.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "allocations.h"
#include "impedraw/arm/arm_notes.h"
#include "impedraw/common/errors.h"
#include "loopback_server.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

std::string arm_text(const std::string& name) {
  std::ostringstream all;
  all << std::ifstream("models/arms/" + name + ".urdf").rdbuf();
  return all.str();
}

// As the arm sends it: links named link1 … link7.
std::string franka_names(std::string urdf) {
  for (std::size_t at = 0; (at = urdf.find("\"link_", at)) != std::string::npos;)
    urdf.erase(at + 5, 1);
  return urdf;
}

// An arm that rests. It answers requests as franka-sim does, and sends a state for each command,
// or each millisecond while there is none. After `reflex_after` commands it stops by a reflex.
class MadeUpArm {
 public:
  MadeUpArm() : udp_(socket(AF_INET, SOCK_DGRAM, 0)) {
    url = "fci://" + server_.address();
    thread_ = std::thread([this] { serve(); });
  }
  ~MadeUpArm() { end(); }

  void end() {
    over_ = true;
    server_.refuse();
    if (thread_.joinable()) thread_.join();
    close(udp_);
  }

  std::string url, urdf = franka_names(arm_text("fr3"));
  std::atomic<int> version = 10;
  std::atomic<long> reflex_after = -1;
  std::atomic<int> reflex_flag = 32;
  std::atomic<long> recoveries = 0;
  std::atomic<long> jump_after = -1;  // commands, then joint 1 stands 0.5 rad further
  std::atomic<bool> babbles = false;  // with answers to requests that nobody made
  JointVector q = JointVector::Zero(7);
  std::vector<double> torque0;          // of every command; read after end()
  std::vector<std::uint64_t> answered;  // its message_id
  bool finished = false;

 private:
  void serve() {
    const int peer = server_.take();
    if (peer < 0) return;
    std::vector<std::uint8_t> got;
    std::array<std::uint8_t, 4096> some;
    sockaddr_in client{};
    std::uint64_t id = 1000;
    std::uint8_t mode = 1, controller = 3;
    std::uint32_t motion = 0;
    bool reflexed = false;
    while (!over_) {
      pollfd waiting[] = {{peer, POLLIN, 0}, {udp_, POLLIN, 0}};
      poll(waiting, 2, 1);
      bool step = waiting[0].revents == 0 && waiting[1].revents == 0;
      if (waiting[0].revents) {
        const ssize_t n = recv(peer, some.data(), some.size(), 0);
        if (n <= 0) break;
        got.insert(got.end(), some.begin(), some.begin() + n);
        FciHeader header{};
        if (got.size() >= 12) std::memcpy(&header, got.data(), 12);
        if (got.size() < 12 || got.size() < header.size) continue;
        std::vector<std::uint8_t> answer = {0};
        if (header.command == 0) {
          std::uint16_t port = 0;
          std::memcpy(&port, got.data() + 14, 2);
          client.sin_family = AF_INET;
          client.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
          client.sin_port = htons(port);
          answer = {0, static_cast<std::uint8_t>(version), 0};
        } else if (header.command == 1) {
          answer = {1};
          motion = header.id;
          mode = 2;
          controller = 2;
        } else if (header.command == 10) {
          ++recoveries;
          mode = 1;
        } else if (header.command == 11) {
          answer.insert(answer.end(), urdf.begin(), urdf.end());
        }
        for (int i = 0; babbles && i < 100; ++i)
          respond(peer, 11, 5000, std::vector<std::uint8_t>(1 << 20));
        respond(peer, header.command, header.id, answer);
        got.erase(got.begin(), got.begin() + header.size);
      }
      if (waiting[1].revents) {
        std::array<std::uint8_t, 400> command;
        recv(udp_, command.data(), command.size(), 0);
        if (command[370]) {
          finished = true;
          mode = 1;
          controller = 3;
          respond(peer, 1, motion, {0});
        } else if (mode == 2) {
          double tau = 0.0;
          std::uint64_t echoed = 0;
          std::memcpy(&tau, command.data() + 314, 8);
          std::memcpy(&echoed, command.data(), 8);
          torque0.push_back(tau);
          answered.push_back(echoed);
          if (!reflexed && reflex_after >= 0 && static_cast<long>(torque0.size()) >= reflex_after) {
            reflexed = true;
            mode = 4;
            controller = 3;
          }
          step = true;
        }
      }
      if (!step || client.sin_port == 0) continue;
      std::vector<std::uint8_t> state(kFciStateSize);
      ++id;
      std::memcpy(state.data(), &id, 8);
      for (int j = 0; j < 7; ++j) {
        const bool jumped =
            j == 0 && jump_after >= 0 && static_cast<long>(torque0.size()) >= jump_after;
        const auto angle = static_cast<float>(q[j] + (jumped ? 0.5 : 0.0));
        std::memcpy(state.data() + 596 + 4 * j, &angle, 4);
      }
      state[1289] = controller;
      if (mode == 4 && reflex_flag >= 0) state[1331 + static_cast<std::size_t>(reflex_flag)] = 1;
      state[1372] = mode;
      sendto(udp_, state.data(), state.size(), 0, reinterpret_cast<sockaddr*>(&client),
             sizeof client);
    }
    close(peer);
  }

  static void respond(int peer, std::uint32_t command, std::uint32_t id,
                      const std::vector<std::uint8_t>& payload) {
    std::vector<std::uint8_t> bytes(12);
    const std::uint32_t header[] = {command, id, static_cast<std::uint32_t>(12 + payload.size())};
    std::memcpy(bytes.data(), header, 12);
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    send(peer, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }

  LoopbackServer server_;
  int udp_;
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

class FrankaFciTest : public ScratchFolder {
 protected:
  FrankaFciTest()
      : model(write("fr3_pen.urdf", urdf_with_pen(arm_text("fr3"), {0.12, 0.05})).string()) {
    arm.q << 0, -0.3, 0, -2.2, 0, 1.9, 0.785;
    settings.driver = ArmDriver::franka;
    settings.url = arm.url;
    settings.clock = ArmClock::lock_step;
    settings.max_silence = 1.0;
  }

  std::string refusal(FrankaFci& driver) {
    try {
      driver.start();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "started";
  }

  // Wants 30 Nm on the first joint for so many cycles, or until a fault.
  void drive(FrankaFci& driver, int cycles) {
    JointVector tau = JointVector::Constant(7, 1.0), gravity = tau;
    tau[0] += 30.0;
    for (int i = 0; i < cycles && driver.fault().empty(); ++i) {
      driver.read();
      if (driver.fault().empty()) driver.command(tau, gravity);
    }
  }

  ArmModel model;
  MadeUpArm arm;
  ArmSettings settings;
};

TEST_F(FrankaFciTest, TorqueRampsWithoutABumpAndEndsWithZero) {
  FrankaFci driver(settings, model, 1e-3, arm.q);
  driver.start();
  drive(driver, 400);
  EXPECT_EQ(driver.fault(), "");
  driver.stop();
  arm.end();
  ASSERT_GT(arm.torque0.size(), 400u);
  EXPECT_LT(std::abs(arm.torque0[0]), 1.0);
  double rate = 0.0, most = 0.0;
  for (std::size_t i = 1; i < arm.torque0.size(); ++i) {
    rate = std::max(rate, 1e3 * std::abs(arm.torque0[i] - arm.torque0[i - 1]));
    most = std::max(most, arm.torque0[i]);
    EXPECT_GT(arm.answered[i], arm.answered[i - 1]);
  }
  EXPECT_LE(rate, 900.0 + 1e-6);
  EXPECT_DOUBLE_EQ(most, 30.0);
  EXPECT_EQ(arm.torque0.back(), 0.0);
  EXPECT_TRUE(arm.finished);
}

// Neither what the loop does before its first command() nor the start of the motion is one.
TEST_F(FrankaFciTest, TheFirstControlStepBeginsWithTheMotion) {
  settings.clock = ArmClock::wall;
  FrankaFci driver(settings, model, 1e-3, arm.q);
  driver.start();
  driver.read();
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  const JointVector zero = JointVector::Zero(7);
  driver.command(zero, zero);
  EXPECT_LT(driver.read().step_time, 0.15);
  EXPECT_EQ(driver.fault(), "");
  driver.stop();
}

// Between the states, too, nothing goes to the heap: neither in the session nor in the protocol.
TEST_F(FrankaFciTest, ACycleAllocatesNothing) {
  FrankaFci driver(settings, model, 1e-3, arm.q);
  driver.start();
  drive(driver, 50);
  EXPECT_EQ(allocations_of_this_thread_in([&] { drive(driver, 300); }), 0);
  EXPECT_EQ(driver.fault(), "");
  driver.stop();
  EXPECT_GT(allocations_of_this_thread_in([] { ::operator delete(::operator new(4)); }), 0)
      << "it is counted";
}

TEST_F(FrankaFciTest, AReflexIsNamedAndRecoveredFrom) {
  arm.reflex_after = 50;
  FrankaFci driver(settings, model, 1e-3, arm.q);
  driver.start();
  drive(driver, 400);
  EXPECT_EQ(driver.fault(), "arm: reflex controller_torque_discontinuity (state start)");
  driver.stop();
  JointVector q;
  ASSERT_TRUE(driver.recover(&q));
  EXPECT_LT((q - arm.q).norm(), 1e-6);
  driver.start();
  drive(driver, 100);
  EXPECT_EQ(driver.fault(), "");
  driver.stop();
  arm.end();
  EXPECT_EQ(arm.recoveries, 1);
  ASSERT_GT(arm.torque0.size(), 150u);
  EXPECT_LT(std::abs(arm.torque0[50]), 1.0);
  EXPECT_EQ(arm.torque0.back(), 0.0);
}

TEST_F(FrankaFciTest, AReflexWithoutAFlagHasAName) {
  arm.reflex_after = 50;
  arm.reflex_flag = -1;
  FrankaFci driver(settings, model, 1e-3, arm.q);
  driver.start();
  drive(driver, 400);
  EXPECT_EQ(driver.fault(), "arm: reflex without a flag that names its cause (state start)");
  driver.stop();
}

TEST_F(FrankaFciTest, APositionThatJumpsIsAFaultAndZeroComesLast) {
  arm.jump_after = 300;
  FrankaFci driver(settings, model, 1e-3, arm.q);
  driver.start();
  drive(driver, 400);
  EXPECT_THAT(driver.fault(), HasSubstr("the position of joint 1 jumped by 0.500 rad"));
  EXPECT_NEAR(driver.read().q[0], arm.q[0], 1e-6);  // the last that was believed
  driver.stop();
  arm.end();
  EXPECT_EQ(arm.torque0.back(), 0.0);
}

TEST_F(FrankaFciTest, AnswersThatNobodyAskedForEndTheConnection) {
  arm.babbles = true;
  FrankaFci driver(settings, model, 1e-3, arm.q);
  EXPECT_THAT(refusal(driver), HasSubstr("answers that nobody asked for"));
}

TEST_F(FrankaFciTest, AfterACollisionOnlyAPersonGoesOn) {
  arm.reflex_after = 50;
  arm.reflex_flag = 7;
  FrankaFci driver(settings, model, 1e-3, arm.q);
  driver.start();
  drive(driver, 400);
  EXPECT_THAT(driver.fault(), HasSubstr("cartesian_reflex"));
  driver.stop();
  JointVector q;
  EXPECT_FALSE(driver.recover(&q));
  arm.end();
  EXPECT_EQ(arm.recoveries, 0);
}

TEST_F(FrankaFciTest, AnotherVersionIsNamed) {
  arm.version = 9;
  FrankaFci driver(settings, model, 1e-3, arm.q);
  EXPECT_THAT(refusal(driver), HasSubstr("speaks FCI version 9, this program 10"));
}

TEST_F(FrankaFciTest, AnotherPostureIsRefused) {
  JointVector elsewhere = arm.q;
  elsewhere[3] += 0.1;
  FrankaFci driver(settings, model, 1e-3, elsewhere);
  EXPECT_THAT(refusal(driver), HasSubstr("joint_4 stands at -2.200 rad"));
}

TEST_F(FrankaFciTest, AnotherArmIsRefusedByName) {
  arm.urdf = franka_names(arm_text("panda"));
  FrankaFci driver(settings, model, 1e-3, arm.q);
  EXPECT_THAT(refusal(driver), HasSubstr("this describes another arm"));
}

// The same limits, and an elbow that stands 5 mm elsewhere.
TEST_F(FrankaFciTest, OtherKinematicsAreRefused) {
  std::string other = franka_names(arm_text("fr3"));
  const std::size_t at = other.find("0.0825", other.find("<joint name=\"joint_4\""));
  ASSERT_NE(at, std::string::npos);
  other.replace(at, 6, "0.0875");
  EXPECT_THROW(require_same_arm(other, model), InputError);
  EXPECT_NO_THROW(require_same_arm(franka_names(arm_text("fr3")), model));
}

TEST_F(FrankaFciTest, SettingsAreChecked) {
  for (const char* url : {"tcpq://127.0.0.1:7701", "fci://", "fci://arm", "fci://127.0.0.1:0",
                          "fci://127.0.0.1:", "fci://127.0.0.1:x"}) {
    settings.url = url;
    EXPECT_THROW(FrankaFci(settings, model, 1e-3, std::nullopt), InputError) << url;
  }
  settings.url = "fci://127.0.0.1";
  EXPECT_THROW(FrankaFci(settings, model, 2e-3, std::nullopt), InputError);
}

}  // namespace
}  // namespace impedraw
