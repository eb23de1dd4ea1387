// Interface between loop and arm: the calls that a driver receives, their order, and that the loop
// needs no other data.
#include "impedraw/run/driver.h"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "allocations.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/exchange.h"
#include "impedraw/log/run_data.h"
#include "impedraw/metrics/metrics.h"
#include "impedraw/run/control_loop.h"
#include "impedraw/run/executor.h"
#include "impedraw/run/identify_joints.h"
#include "impedraw/run/log_row.h"
#include "impedraw/run/simulated_arm.h"
#include "log/run_columns.h"
#include "run/prepared.h"
#include "run/test_driver.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

namespace fs = std::filesystem;

class DriverTest : public ::testing::Test {
 protected:
  ~DriverTest() override { fs::remove(log_); }
  fs::path log_ =
      fs::temp_directory_path() / ("impedraw_driver_" + std::to_string(getpid()) + ".h5");
};

// Without the simulator's truth the torques are bitwise the same: the control uses none of it.
TEST_F(DriverTest, TheLoopDrawsTheSameWithoutTheTruth) {
  for (const char* name : {"bowl-m", "bowl-sine-realistic", "bowl-m-blind"}) {
    SCOPED_TRACE(name);
    Prepared e = prepared(name);
    const auto drawn = [&](bool truthful) {
      TestDriver driver(e);
      driver.truthful = truthful;
      EXPECT_EQ(run(e, driver, log_, 0.0).end, RunEnd::finished);
      EXPECT_EQ(driver.order, "start stop ");
      EXPECT_TRUE(driver.finite);
      return read_rows(log_);
    };
    const RunRows with = drawn(true), without = drawn(false);
    ASSERT_EQ(with.time, without.time);
    EXPECT_EQ(with.joint_torque, without.joint_torque);
    EXPECT_EQ(with.mode, without.mode);
    // Without the true tip, the log holds the arm's estimate of it.
    for (std::size_t i = 0; i < with.time.size(); i += 100)
      ASSERT_LT((with.tip_position[i] - without.tip_position[i]).norm(), 1e-9) << i;
  }
}

// The log then holds the wrench as it was measured, and nothing where it was not.
TEST_F(DriverTest, WithoutTheTruthContactIsWhatWasMeasured) {
  Prepared e = prepared("bowl-sine");
  TestDriver driver(e);
  ASSERT_EQ(run(e, driver, log_, 0.0).end, RunEnd::finished);
  const RunRows with = read_rows(log_);
  driver.truthful = false;
  ASSERT_EQ(run(e, driver, log_, 0.0).end, RunEnd::finished);
  const RunRows without = read_rows(log_);
  int compared = 0;
  for (std::size_t i = 1; i < with.time.size(); i += 10) {
    if (with.stroke[i] < 0 || with.stroke[i - 1] < 0) continue;
    // A wrench is that of the step before.
    ASSERT_LT((without.contact_force[i] - with.contact_force[i - 1]).norm(), 1e-6) << i;
    // The tip yields by half a millimetre at the most.
    ASSERT_LT((without.contact_point[i] - with.contact_point[i]).norm(), 1e-3) << i;
    ++compared;
  }
  EXPECT_GT(compared, 900);

  Prepared unfelt = prepared("bowl-sine-natural");
  TestDriver blind(unfelt);
  blind.truthful = false;
  ASSERT_EQ(run(unfelt, blind, log_, 0.0).end, RunEnd::finished);
  for (const Eigen::Vector3d& force : read_rows(log_).contact_force)
    ASSERT_TRUE(force.array().isNaN().all());
  const Metrics metrics = compute_metrics(read_run(log_));
  EXPECT_THAT(metrics.contact_fraction.reason(), HasSubstr("contact is unknown"));
  EXPECT_THAT(metrics.coverage.reason(), HasSubstr("contact is unknown"));
  EXPECT_TRUE(metrics.joint_margin_min.value());
}

// What got no ink is drawn again after it was planned how, while the arm is answered and stays.
TEST_F(DriverTest, OnAWallClockTheArmIsHeldWhileTheLoopPlans) {
  class Held : public TestDriver {
   public:
    explicit Held(Prepared& e) : TestDriver(e), loop_(std::this_thread::get_id()) {
      changed_info().waits = false;
    }
    void command(const JointVector& tau, const JointVector& gravity) noexcept override {
      if (std::this_thread::get_id() != loop_) {
        ++held;
        moved = std::max(moved, truth()->v.norm());
      }
      TestDriver::command(tau, gravity);
    }
    int held = 0;
    double moved = 0.0;  // [rad/s]

   private:
    std::thread::id loop_;
  };
  Prepared e = prepared("safety-no-cloud", {"drawing.redraw=true"});
  Held driver(e);
  const RunOutcome outcome = run(e, driver, log_, 0.0);
  EXPECT_EQ(outcome.end, RunEnd::finished) << outcome.cause;
  EXPECT_EQ(outcome.drawn_again.size(), 1u);
  EXPECT_TRUE(outcome.lacking.empty());
  EXPECT_EQ(driver.order, "start stop ");
  EXPECT_GT(driver.held, 10);
  EXPECT_LT(driver.moved, 0.02);
  EXPECT_EQ(compute_metrics(read_run(log_)).coverage.or_nan(), 1.0);
}

// As an arm on a wall clock whose cameras keep capturing: frames are taken by another thread, with
// what they refer to their own.
class CapturingDriver : public TestDriver {
 public:
  explicit CapturingDriver(Prepared& e) : TestDriver(e), loop_(std::this_thread::get_id()) {
    changed_info().waits = false;
  }
  const ArmState& read() noexcept override {
    const ArmState& state = TestDriver::read();
    for (CanvasFrame frame; inner().next_frame(&frame);) {
      auto copy = std::make_unique<Frame>();
      copy->frame = frame;
      copy->image = *frame.depth;
      copy->camera = *frame.camera_model;
      copy->arm.assign(frame.arm.begin(), frame.arm.end());
      if (queue_.give(std::move(copy))) ++given_;
    }
    // The simulator runs ahead of any wall clock: it is held back to what perception can follow.
    while (given_ > taken_) std::this_thread::sleep_for(std::chrono::microseconds(200));
    return state;
  }
  bool next_frame(CanvasFrame* frame) noexcept override {
    if (std::this_thread::get_id() == loop_) in_loop = true;
    std::unique_ptr<Frame> next;
    if (!queue_.take(&next)) return false;
    last_ = std::move(next);
    *frame = last_->frame;
    frame->depth = &last_->image;
    frame->camera_model = &last_->camera;
    frame->arm = last_->arm;
    ++taken_;
    return true;
  }
  bool in_loop = false;
  int taken() const { return taken_; }

 private:
  struct Frame {
    CanvasFrame frame;
    DepthImage image;
    DepthCamera camera;
    std::vector<Capsule> arm;
  };
  std::thread::id loop_;
  Queue<std::unique_ptr<Frame>, 256> queue_;
  std::atomic<int> given_ = 0, taken_ = 0;
  std::unique_ptr<Frame> last_;
};

TEST_F(DriverTest, OnAWallClockFramesAreTakenBesideTheLoop) {
  Prepared e = prepared("moving-turntable", {"perception.frames.depth=true",
                                             "perception.frames.rate=10", "drawing.redraw=false"});
  CapturingDriver driver(e);
  const RunOutcome outcome = run(e, driver, log_, 0.0);
  EXPECT_EQ(outcome.end, RunEnd::finished) << outcome.cause;
  EXPECT_FALSE(driver.in_loop);
  EXPECT_GT(driver.taken(), 300);
  const Metrics m = compute_metrics(read_run(log_));
  EXPECT_GT(m.contact_fraction.or_nan(), 0.99);
  EXPECT_LT(m.ink_error_rms.or_nan(), 0.3);
  EXPECT_LT(m.normal_error_mean.or_nan(), 0.3);
}

TEST_F(DriverTest, AnArmThatIsNotSimulatedHereIsNotSimulated) {
  Prepared e = prepared(
      "bowl-sine", {"arm.driver=iiwa-lcm", "control.inertia=natural", "canvas.true_model=true"});
  EXPECT_THROW(run(e, log_, 0.0), InputError);
  EXPECT_FALSE(fs::exists(log_));
}

// A driver on a wall clock: time goes on whatever the loop does. A pause holds the plan's clock:
// the pen stays where it is with its push, and the drawing comes out whole.
TEST_F(DriverTest, AnArmThatDoesNotWaitIsPausedByThePlansClock) {
  Prepared e = prepared("bowl-sine", {"log.rate=full"});
  TestDriver driver(e);
  driver.changed_info().waits = false;
  constexpr double kFrom = 6.0, kTo = 8.5;  // [s]; longer than the clock's patience
  double time = 0.0;
  RunHooks hooks;
  hooks.held = [](double) {
    ADD_FAILURE() << "an arm that does not wait was held between two steps";
    return false;
  };
  hooks.paused = [&] { return time >= kFrom && time < kTo; };
  hooks.row = [&](const LogRow& row) { time = row.time; };
  const RunOutcome outcome = run(e, driver, log_, 0.0, hooks);
  ASSERT_EQ(outcome.end, RunEnd::finished) << outcome.cause;
  EXPECT_NEAR(outcome.simulated, e.plan.path.duration() + kTo - kFrom, 0.3);
  EXPECT_EQ(driver.order, "start stop ");

  const RunRows rows = read_rows(log_);
  Eigen::AlignedBox3d tip;
  double least = 1e9, most = 0.0;
  for (std::size_t i = 0; i < rows.time.size(); ++i) {
    if (rows.time[i] < kFrom + 0.3 || rows.time[i] > kTo) continue;
    EXPECT_EQ(rows.time_scale[i], 0.0) << rows.time[i];
    tip.extend(rows.tip_position[i]);
    least = std::min(least, rows.contact_force[i].norm());
    most = std::max(most, rows.contact_force[i].norm());
  }
  EXPECT_LT(tip.diagonal().norm(), 2e-4);
  EXPECT_GT(least, 4.5);
  EXPECT_LT(most, 5.5);
  const RunData drawn = read_run(log_);
  const Metrics metrics = compute_metrics(drawn, match_ink(drawn));
  EXPECT_EQ(metrics.coverage.value().value_or(-1.0), 1.0);
  EXPECT_EQ(metrics.gaps.value().value_or(-1.0), 0.0);
  EXPECT_LT(metrics.ink_error_rms.value().value_or(1e9), 0.05);
  EXPECT_GT(metrics.force_peak.value().value_or(-1.0), 4.9);
  EXPECT_LT(metrics.force_peak.value().value_or(1e9), 5.5);
}

TEST_F(DriverTest, AnArmThatDoesNotWaitIsStoppedInAPause) {
  Prepared e = prepared("bowl-sine");
  TestDriver driver(e);
  driver.changed_info().waits = false;
  double time = 0.0;
  RunHooks hooks;
  hooks.paused = [&] { return time >= 5.0; };
  hooks.interrupted = [&] { return time >= 9.0; };
  hooks.row = [&](const LogRow& row) { time = row.time; };
  const RunOutcome outcome = run(e, driver, log_, 0.0, hooks);
  EXPECT_EQ(outcome.end, RunEnd::interrupted);
  EXPECT_THAT(outcome.cause, HasSubstr("the pen was lifted"));
  EXPECT_LT(time, 12.0);
  EXPECT_EQ(read_rows(log_).contact_force.back().norm(), 0.0) << "the pen is up";
}

TEST_F(DriverTest, GravityIsThePartThatHoldsTheArm) {
  Prepared e = prepared("bowl-sine");
  TestDriver driver(e);
  ASSERT_EQ(run(e, driver, log_, 0.0).end, RunEnd::finished);
  // At rest over its last point the arm needs little more than gravity compensation.
  EXPECT_GT(driver.last_gravity.norm(), 20.0);
  EXPECT_LT((driver.last_tau - driver.last_gravity).norm(), 2.0);
}

TEST_F(DriverTest, AFaultEndsTheRunByItsName) {
  Prepared e = prepared("bowl-sine");
  TestDriver driver(e);
  driver.fault_time = 2.0;
  const RunOutcome outcome = run(e, driver, log_, 0.0);
  EXPECT_EQ(outcome.end, RunEnd::stopped);
  EXPECT_EQ(outcome.cause, "the cable was pulled");
  EXPECT_NEAR(outcome.simulated, 2.0, 1.5e-3) << "at the next cycle";
  EXPECT_EQ(driver.order, "start stop ");
}

TEST_F(DriverTest, IsStoppedWhateverHappens) {
  Prepared e = prepared("bowl-sine");
  TestDriver unwritable(e);
  EXPECT_THROW(run(e, unwritable, "/no/such/folder/run.h5", 0.0), LogError);
  EXPECT_THAT(unwritable.order, ::testing::EndsWith("stop "));
  TestDriver absent(e);
  absent.start_failure = "no arm at 127.0.0.1";
  EXPECT_THROW(run(e, absent, log_, 0.0), std::runtime_error);
  EXPECT_FALSE(fs::exists(log_)) << "nothing was begun";
}

TEST_F(DriverTest, OfAnotherArmIsRefused) {
  Prepared e = prepared("bowl-sine");
  const auto refusal = [&](auto change) -> std::string {
    TestDriver driver(e);
    change(driver.changed_info());
    try {
      run(e, driver, log_, 0.0);
    } catch (const InputError& error) {
      EXPECT_EQ(driver.order, "") << "it is not even started";
      return error.what();
    }
    return "none";
  };
  EXPECT_EQ(refusal([](DriverInfo& info) { info.joints = 6; }),
            "driver: its arm has 6 joints, the model 7");
  EXPECT_EQ(refusal([](DriverInfo& info) { info.period = 0.005; }),
            "driver: its period is 0.005 s, the controller's step 0.001 s");
  EXPECT_THAT(refusal([](DriverInfo& info) { info.wrench = WrenchReading::none; }),
              HasSubstr("it gives no wrench, control.wrench needs the wrench at the tip"));
}

TEST_F(DriverTest, TheToolIsFoundThroughIt) {
  Prepared e = prepared("bowl-sine-sensor");
  TestDriver driver(e);
  const ToolIdentification through = calibrate_tool(e, driver, 4, 0.5).found,
                           simulated = calibrate_tool(e, driver.inner(), 4, 0.5).found;
  EXPECT_EQ(through.mass, simulated.mass);
  EXPECT_NEAR(through.mass, 0.05, 1e-3);
  EXPECT_EQ(driver.order, "start stop ");
}

// From a state to a torque to the world's next state and the log's row.
TEST(Driver, ACycleAllocatesNothing) {
  for (const char* name : {"bowl-m", "bowl-sine-realistic", "bowl-push"}) {
    SCOPED_TRACE(name);
    Prepared e = prepared(name);
    SimulatedArm arm(e, e.belief.start_q, Disturbances(e.scenario, e.plan.path));
    ControlLoop loop(e.control, e.belief.arm, arm.info(), [&](const Eigen::Vector3d& p_W, double) {
      return e.belief.perception->estimate(p_W);
    });
    LogRow row(e.belief.arm.joints());
    const RunHooks hooks;
    ArmMonitors monitors(e, arm, hooks);
    Ending ending;
    const Reaction reaction(&ending);
    int verdicts = 0;
    arm.start();
    const ArmState* state = &arm.read();
    const auto cycles = [&](int count) {
      for (int i = 0; i < count; ++i) {
        const PathSample desired = e.plan.path.at(state->time);
        const ImpedanceTorque& out = loop.step(*state, desired.reference);
        Cycle cycle{.time = state->time,
                    .run_time = state->time,
                    .dt = 1e-3,
                    .desired = desired,
                    .arm = loop.terms(),
                    .space = loop.space(),
                    .F_ext = loop.F_ext(),
                    .surface = loop.surface(),
                    .canvas = loop.canvas(),
                    .out = out,
                    .state = state,
                    .truth = arm.truth(),
                    .tared = true};
        fill_state(e, cycle, &row);
        arm.command(out.tau, out.terms.col(kGravity));
        fill_contact(e, cycle, &row);
        cycle.state = state = &arm.read();
        verdicts += static_cast<bool>(monitors.judge(cycle, reaction, false));
      }
    };
    cycles(10);
    const int most = static_cast<int>(e.plan.path.duration() / 1e-3) - 100;
    EXPECT_EQ(allocations_in([&] { cycles(most); }), 0);
    EXPECT_EQ(verdicts, 0);
    EXPECT_TRUE(arm.fault().empty()) << arm.fault();
  }
}

}  // namespace
}  // namespace impedraw
