// The benchmark with an arm that does not wait: it is answered between two runs as well, and stays
// where it is meanwhile.
#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "impedraw/judge/force_results.h"
#include "impedraw/judge/force_trial.h"
#include "run/prepared.h"
#include "run/test_driver.h"

namespace impedraw {
namespace {

// The simulated arm, which tells that it does not wait.
class WallArm : public TestDriver {
 public:
  // What the test's thread looks at while another one drives the arm.
  struct Seen {
    std::atomic<long> answers = 0;
    std::atomic<double> fastest = 0.0;  // [rad/s]
    std::string order;                  // of the calls, once it was stopped
  };

  WallArm(Prepared& e, Seen* seen) : TestDriver(e), seen_(*seen) { changed_info().waits = false; }

  const ArmState& read() noexcept override {
    const ArmState& state = TestDriver::read();
    seen_.fastest = std::max<double>(seen_.fastest, truth()->v.norm());
    return state;
  }
  void command(const JointVector& tau, const JointVector& gravity) noexcept override {
    TestDriver::command(tau, gravity);
    ++seen_.answers;
  }
  void stop() noexcept override {
    TestDriver::stop();
    seen_.order = order;
  }

 private:
  Seen& seen_;
};

class ForceBenchOnTheWall : public ::testing::Test {
 protected:
  DriverMaker maker() {
    return [this](const JointVector&, const Resumption*) {
      auto arm = std::make_unique<WallArm>(e_, &seen_);
      arm->fault_time = fault_time_;
      return arm;
    };
  }
  // Until the arm was answered so many times more.
  void wait_for(long more) const {
    const long until = seen_.answers + more;
    while (seen_.answers < until && fault_free())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  bool fault_free() const { return !bench_ || bench_->fault().empty(); }

  Prepared e_ = prepared(
      "force-benchmark",
      {"control.wrench=ground_truth", "arm.start=[0.6, 0, 0.13]", "perception.enabled=false"});
  WallArm::Seen seen_;
  double fault_time_ = -1.0;
  std::unique_ptr<ForceBench> bench_;
  const std::function<bool()> go_on_ = [] { return true; };
};

TEST_F(ForceBenchOnTheWall, HoldsTheArmBetweenTwoRuns) {
  bench_ = std::make_unique<ForceBench>(e_, maker(), false);
  wait_for(2000);
  const ForceCase c = force_cases({"contact-10"}).front();
  for (const ForceController controller : {ForceController::ours, ForceController::impedance}) {
    const ForceRun run = bench_->run(c, controller, 1, go_on_);
    EXPECT_EQ(run.ended, "");
    EXPECT_GT(run.record.size(), 1000u);
    wait_for(3000);
    seen_.fastest = 0.0;
    wait_for(3000);
    EXPECT_LT(seen_.fastest, 1e-3);
    EXPECT_EQ(bench_->fault(), "");
  }
  bench_.reset();
  EXPECT_EQ(seen_.order, "start stop ");  // read() and command() in turns
}

TEST_F(ForceBenchOnTheWall, TellsAFaultBetweenTwoRuns) {
  fault_time_ = 0.5;
  bench_ = std::make_unique<ForceBench>(e_, maker(), false);
  wait_for(1000);
  EXPECT_EQ(bench_->fault(), "the cable was pulled");
}

// The torques of a real arm change by 850 Nm/s at most.
ForceMetrics on_slow_torques(const std::string& name) {
  Prepared e = prepared("force-benchmark", {"arm.start=[0.6, 0, 0.13]", "perception.enabled=false",
                                            "control.torque_rate=850"});
  ForceBench bench(e, {}, false);
  const ForceCase c = force_cases({name}).front();
  const ForceRun run = bench.run(c, ForceController::ours, 1, [] { return true; });
  EXPECT_EQ(run.ended, "");
  return judge_force(run.record, run.question);
}

TEST(ForceBench, ABlowAStepAndAnEdgeAreBorneWithTheTorqueRatesOfARealArm) {
  const ForceMetrics blow = on_slow_torques("contact-100"), step = on_slow_torques("steps"),
                     edge = on_slow_torques("edged-75");
  ASSERT_TRUE(blow.value[kSettlingTime]) << "the pen hammers";
  EXPECT_LT(*blow.value[kSettlingTime], 0.3);
  EXPECT_LT(*blow.value[kSd], 0.1);
  EXPECT_LT(*step.value[kOvershoot], 0.25);
  EXPECT_LT(*edge.value[kSd], 0.5);
}

TEST(ForceResults, TellWhetherTheArmWasSimulated) {
  ForceResults results;
  results.arm = "fr3";
  results.driver = "franka";
  for (const bool simulated : {true, false}) {
    results.simulated = simulated;
    EXPECT_EQ(force_page(results).find("Force benchmark, simulated") != std::string::npos,
              simulated);
    EXPECT_EQ(nlohmann::json::parse(force_json(results))["simulated"].get<bool>(), simulated);
  }
}

}  // namespace
}  // namespace impedraw
