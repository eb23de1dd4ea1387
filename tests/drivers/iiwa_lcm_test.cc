// The driver against a made-up arm at the other end of a socket: LCM's tcpq as a broker speaks it.
#include "impedraw/drivers/iiwa_lcm.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <bit>
#include <chrono>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "lcm_frames.h"
#include "loopback_server.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

// An arm that rests, with the broker before it. Statuses at 1 kHz of its clock: by the wall until
// the first command, then in lock-step.
class MadeUpArm {
 public:
  struct Command {
    std::int64_t utime;
    double torque0;
    std::int64_t newest;  // utime of the last status before it
  };

  MadeUpArm() {
    url = "tcpq://" + server_.address();
    thread_ = std::thread([this] { serve(); });
  }
  ~MadeUpArm() { end(); }

  void end() {
    over_ = true;
    server_.refuse();
    if (thread_.joinable()) thread_.join();
  }

  std::string url;
  std::atomic<long> dies_after = -1, silent_after = -1;  // commands
  std::atomic<bool> resets = false;                      // the connection, at the end
  std::atomic<bool> breaks_off = false;                  // the last status, in its middle
  std::atomic<double> q0 = 0.0;
  std::vector<Command> commands;  // read after end()

 private:
  void serve() {
    while (!over_) {
      const int peer = server_.take();
      if (peer < 0) return;
      Bytes got;
      gone_ = false;
      if (receive(peer, &got, 8, 1000)) {
        send_all(peer, lcm_greeting());
        got.erase(got.begin(), got.begin() + 8);
        drive(peer, &got);
      }
      const linger at_once{1, 0};
      if (resets) setsockopt(peer, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
      close(peer);
    }
  }

  void drive(int peer, Bytes* got) {
    std::int64_t utime = 7'000'000;
    while (!over_) {
      const auto count = static_cast<long>(commands.size());
      if (dies_after >= 0 && count >= dies_after) {
        if (breaks_off) {
          Bytes half = status(utime);
          half.resize(half.size() / 2);
          send_all(peer, half);
          std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        over_ = true;
        return;
      }
      if (silent_after < 0 || count < silent_after) send_all(peer, status(utime));
      // Commands, as many as there are; in lock-step the one that answers.
      do {
        if (!receive(peer, got, got->size() + 1, commands.empty() ? 1 : 100) && gone_) return;
        take(got, utime);
      } while (!over_ && !commands.empty() && commands.back().utime != utime &&
               (silent_after < 0 || count < silent_after));
      utime += 1000;
    }
  }

  Bytes status(std::int64_t utime) const {
    Bytes message;
    put_number(&message, 0xf16fb804284abca3, 8);
    put_number(&message, static_cast<std::uint64_t>(utime), 8);
    put_number(&message, 7, 4);
    for (int i = 0; i < 49; ++i)
      put_number(&message, i == 0 ? std::bit_cast<std::uint64_t>(q0.load()) : 0, 8);
    return lcm_frame("IIWA_STATUS", message);
  }

  void take(Bytes* got, std::int64_t newest) {
    while (got->size() >= 8) {
      const std::uint64_t kind = number_at(*got, 0, 4), name = number_at(*got, 4, 4);
      std::size_t size = 8 + name;
      if (got->size() < size) return;
      if (kind == 1) {
        if (got->size() < size + 4) return;
        const std::uint64_t length = number_at(*got, size, 4);
        if (got->size() < size + 4 + length) return;
        commands.push_back({static_cast<std::int64_t>(number_at(*got, size + 12, 8)),
                            std::bit_cast<double>(number_at(*got, size + 28, 8)), newest});
        size += 4 + length;
      }
      got->erase(got->begin(), got->begin() + static_cast<std::ptrdiff_t>(size));
    }
  }

  // Until there are `size` bytes; false after the time.
  bool receive(int peer, Bytes* got, std::size_t size, int ms) {
    while (got->size() < size) {
      pollfd waiting{peer, POLLIN, 0};
      if (poll(&waiting, 1, ms) != 1) return false;
      std::uint8_t buffer[4096];
      const ssize_t n = recv(peer, buffer, sizeof buffer, 0);
      if (n <= 0) {
        gone_ = true;
        return false;
      }
      got->insert(got->end(), buffer, buffer + n);
    }
    return true;
  }

  static void send_all(int peer, const Bytes& bytes) {
    send(peer, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }

  LoopbackServer server_;
  std::atomic<bool> over_ = false;
  bool gone_ = false;
  std::thread thread_;
};

ArmSettings settings_for(const std::string& url) {
  ArmSettings settings;
  settings.driver = ArmDriver::iiwa_lcm;
  settings.clock = ArmClock::lock_step;
  settings.max_silence = 0.5;
  settings.url = url;
  return settings;
}

JointVector torque(double x) { return JointVector::Constant(7, x); }

class IiwaLcmTest : public ::testing::Test {
 protected:
  ArmModel model_{"models/iiwa14_pen.urdf"};
};

// Runs `cycles` with 10 Nm wanted above gravity.
void drive(IiwaLcm& driver, int cycles) {
  for (int i = 0; i < cycles && driver.fault().empty(); ++i) {
    driver.read();
    driver.command(torque(110.0), torque(100.0));
  }
}

TEST_F(IiwaLcmTest, EachStatusIsAnsweredWithItsOwnTimeAndZeroComesLast) {
  MadeUpArm arm;
  {
    IiwaLcm driver(settings_for(arm.url), model_, 1e-3, torque(0.0), false);
    driver.start();
    drive(driver, 600);
    EXPECT_EQ(driver.fault(), "");
    EXPECT_EQ(driver.session().state(), SessionState::run);
    driver.stop();
    driver.stop();  // again: nothing more
  }
  arm.end();
  ASSERT_GT(arm.commands.size(), 600u);
  EXPECT_GE(arm.commands.front().newest - 7'000'000, 250'000);  // none within the first 0.25 s
  double before = 0.0, most = 0.0;
  for (std::size_t i = 1; i < arm.commands.size(); ++i) {
    const auto& [utime, tau, newest] = arm.commands[i];
    EXPECT_GT(utime, arm.commands[i - 1].utime);
    if (i > 5) {
      EXPECT_EQ(utime, newest) << i;
    }
    EXPECT_LE(std::abs(tau - before), 1.8 + 1e-9);  // 900 Nm/s, steps of up to 2 ms
    before = tau;
    most = std::max(most, tau);
  }
  EXPECT_EQ(arm.commands.front().torque0, 0.0);
  EXPECT_NEAR(most, 10.0, 1e-9);  // without gravity
  EXPECT_EQ(arm.commands.back().torque0, 0.0);
}

// What the loop does between its first read() and its first command() is no time of the arm's.
TEST_F(IiwaLcmTest, TheClockBeginsWithTheFirstCommand) {
  MadeUpArm arm;
  ArmSettings settings = settings_for(arm.url);
  settings.clock = ArmClock::wall;
  IiwaLcm driver(settings, model_, 1e-3, torque(0.0), false);
  driver.start();
  const ArmState& state = driver.read();
  EXPECT_EQ(state.time, 0.0);
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  driver.command(torque(110.0), torque(100.0));
  driver.read();
  EXPECT_GT(state.time, 0.5e-3);
  EXPECT_LT(state.time, 0.02);
  EXPECT_LT(state.step_time, 0.15);
  driver.stop();
  arm.end();
  ASSERT_FALSE(arm.commands.empty());
  EXPECT_EQ(arm.commands.front().torque0, 0.0);
}

TEST_F(IiwaLcmTest, ABrokerThatDiesIsAFaultAtOnceAndNoAbort) {
  for (int seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    MadeUpArm arm;
    arm.dies_after = 100 + seed;
    arm.resets = seed % 2 == 1;
    arm.breaks_off = seed % 4 >= 2;
    IiwaLcm driver(settings_for(arm.url), model_, 1e-3, torque(0.0), false);
    driver.start();
    testing::internal::CaptureStderr();
    int cycles = 0;
    for (; cycles < 1000 && driver.fault().empty(); ++cycles) drive(driver, 1);
    driver.stop();
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "the driver alone tells of it";
    EXPECT_LE(cycles, 100 + seed + 100);
    EXPECT_THAT(driver.fault(), HasSubstr("the connection to the LCM broker was lost"));
  }
}

TEST_F(IiwaLcmTest, SilenceLowersTheTorqueToZero) {
  MadeUpArm arm;
  arm.silent_after = 400;
  IiwaLcm driver(settings_for(arm.url), model_, 1e-3, torque(0.0), false);
  driver.start();
  drive(driver, 1000);
  EXPECT_THAT(driver.fault(), HasSubstr("no status of the arm for 0.5"));
  driver.stop();
  arm.end();
  ASSERT_GT(arm.commands.size(), 400u);
  EXPECT_EQ(arm.commands.back().torque0, 0.0);
  EXPECT_NEAR(arm.commands[399].torque0, 10.0, 1e-9);
}

TEST_F(IiwaLcmTest, NobodyThereIsToldInOneLine) {
  std::string url;
  {
    MadeUpArm arm;
    url = arm.url;
  }
  IiwaLcm driver(settings_for(url), model_, 1e-3, torque(0.0), false);
  testing::internal::CaptureStderr();
  try {
    driver.start();
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(), "arm.url " + url + ": no LCM broker answers (Connection refused)");
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(IiwaLcmTest, AnArmElsewhereIsNotMoved) {
  MadeUpArm arm;
  arm.q0 = 0.1;
  IiwaLcm driver(settings_for(arm.url), model_, 1e-3, torque(0.0), false);
  try {
    driver.start();
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("joint_1 stands at 0.100 rad, the drawing starts at 0.000"));
  }
  driver.stop();
  arm.end();
  EXPECT_TRUE(arm.commands.empty());
}

TEST_F(IiwaLcmTest, AnArmAtAnotherRateIsNotMoved) {
  MadeUpArm arm;
  IiwaLcm driver(settings_for(arm.url), model_, 5e-3, torque(0.0), false);
  try {
    driver.start();
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(),
                 "the arm's statuses are 1.000 ms apart, the controller's step is 5.000 ms");
  }
  driver.stop();
  arm.end();
  EXPECT_TRUE(arm.commands.empty());
}

TEST_F(IiwaLcmTest, AMissingWrenchIsToldBeforeAnythingMoves) {
  MadeUpArm arm;
  IiwaLcm driver(settings_for(arm.url), model_, 1e-3, torque(0.0), true);
  EXPECT_THROW(driver.start(), std::runtime_error);
  arm.end();
  EXPECT_TRUE(arm.commands.empty());
}

TEST(IiwaLcm, OtherUrlsAreRefused) {
  ArmModel model("models/iiwa14_pen.urdf");
  for (const char* url : {"udpm://239.255.76.67:7667", "tcpq://localhost:7701", "tcpq://127.0.0.1",
                          "tcpq://127.0.0.1:0", "tcpq://127.0.0.1:70000", "tcpq://:7701", ""}) {
    SCOPED_TRACE(url);
    EXPECT_THROW(IiwaLcm(settings_for(url), model, 1e-3, torque(0.0), false), InputError);
  }
}

}  // namespace
}  // namespace impedraw
