// The benchmark with an arm that does not wait: it is answered between two runs as well, and stays
// where it is meanwhile.
#include <atomic>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "impedraw/judge/force_results.h"
#include "impedraw/judge/force_trial.h"
#include "impedraw/run/simulated_arm.h"
#include "run/prepared.h"

namespace impedraw {
namespace {

// The simulated arm, which tells that it does not wait. A second call in a row of read() or of
// command() is a fault, and so is whatever a test asks for.
class WallArm : public Driver {
 public:
  // What the test's thread looks at while another one drives the arm.
  struct Seen {
    std::atomic<long> answers = 0;
    std::atomic<double> fastest = 0.0;  // [rad/s]
    std::atomic<bool> stopped = false;
  };

  WallArm(Prepared& e, Seen* seen, long fails_at)
      : inner_(e, e.belief.start_q, Disturbances()), seen_(*seen), fails_at_(fails_at) {}

  DriverInfo info() const override {
    DriverInfo info = inner_.info();
    info.waits = false;
    return info;
  }
  void start() override { inner_.start(); }
  const ArmState& read() noexcept override {
    if (reading_) fault_ = "read twice";
    reading_ = true;
    if (fails_at_ > 0 && seen_.answers >= fails_at_) fault_ = "the cable was pulled";
    const ArmState& state = inner_.read();
    seen_.fastest = std::max<double>(seen_.fastest, inner_.truth()->v.norm());
    return state;
  }
  void command(const JointVector& tau, const JointVector& gravity) noexcept override {
    if (!reading_) fault_ = "answered twice";
    reading_ = false;
    ++seen_.answers;
    inner_.command(tau, gravity);
  }
  const std::string& fault() const noexcept override {
    return fault_.empty() ? inner_.fault() : fault_;
  }
  void stop() noexcept override { seen_.stopped = true; }
  const GroundTruth* truth() const noexcept override { return inner_.truth(); }

 private:
  SimulatedArm inner_;
  Seen& seen_;
  long fails_at_;  // answers; 0: never
  bool reading_ = false;
  std::string fault_;
};

class ForceBenchOnTheWall : public ::testing::Test {
 protected:
  DriverMaker maker() {
    return [this](const JointVector&, const Resumption*) {
      return std::make_unique<WallArm>(e_, &seen_, fails_at_);
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
  long fails_at_ = 0;
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
  EXPECT_TRUE(seen_.stopped);
}

TEST_F(ForceBenchOnTheWall, TellsAFaultBetweenTwoRuns) {
  fails_at_ = 500;
  bench_ = std::make_unique<ForceBench>(e_, maker(), false);
  wait_for(1000);
  EXPECT_EQ(bench_->fault(), "the cable was pulled");
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
