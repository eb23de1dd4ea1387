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
  WallArm(Prepared& e, std::atomic<long>* answers, bool* stopped)
      : inner_(e, e.belief.start_q, Disturbances()), answers_(*answers), stopped_(*stopped) {}

  DriverInfo info() const override {
    DriverInfo info = inner_.info();
    info.waits = false;
    return info;
  }
  void start() override { inner_.start(); }
  const ArmState& read() noexcept override {
    if (reading_) fault_ = "read twice";
    reading_ = true;
    if (fails_at > 0 && answers_ >= fails_at) fault_ = "the cable was pulled";
    return inner_.read();
  }
  void command(const JointVector& tau, const JointVector& gravity) noexcept override {
    if (!reading_) fault_ = "answered twice";
    reading_ = false;
    ++answers_;
    inner_.command(tau, gravity);
  }
  const std::string& fault() const noexcept override {
    return fault_.empty() ? inner_.fault() : fault_;
  }
  void stop() noexcept override { stopped_ = true; }
  const GroundTruth* truth() const noexcept override { return inner_.truth(); }

  long fails_at = 0;  // answers; 0: never

 private:
  SimulatedArm inner_;
  std::atomic<long>& answers_;
  bool& stopped_;
  bool reading_ = false;
  std::string fault_;
};

class ForceBenchOnTheWall : public ::testing::Test {
 protected:
  DriverMaker maker() {
    return [this](const JointVector&, const Resumption*) {
      auto made = std::make_unique<WallArm>(e_, &answers_, &stopped_);
      arm_ = made.get();
      arm_->fails_at = fails_at_;
      return made;
    };
  }
  // Until the arm was answered so many times more.
  void wait_for(long more) const {
    const long until = answers_ + more;
    while (answers_ < until && fault_free())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  bool fault_free() const { return !bench_ || bench_->fault().empty(); }

  Prepared e_ = prepared(
      "force-benchmark",
      {"control.wrench=ground_truth", "arm.start=[0.6, 0, 0.13]", "perception.enabled=false"});
  std::atomic<long> answers_ = 0;
  long fails_at_ = 0;
  bool stopped_ = false;
  WallArm* arm_ = nullptr;
  std::unique_ptr<ForceBench> bench_;
  const std::function<bool()> go_on_ = [] { return true; };
};

TEST_F(ForceBenchOnTheWall, HoldsTheArmBetweenTwoRuns) {
  bench_ = std::make_unique<ForceBench>(e_, maker(), false);
  wait_for(2000);
  const ForceCase c = force_cases({"contact-10"}).front();
  std::vector<Eigen::Vector3d> begins;
  for (const ForceController controller : {ForceController::ours, ForceController::impedance}) {
    const ForceRun run = bench_->run(c, controller, 1, go_on_);
    EXPECT_EQ(run.ended, "");
    EXPECT_GT(run.record.size(), 1000u);
    wait_for(3000);
    const JointVector q = arm_->truth()->q;
    wait_for(3000);
    EXPECT_LT((arm_->truth()->q - q).norm(), 1e-3);
    EXPECT_EQ(bench_->fault(), "");
  }
  bench_.reset();
  EXPECT_TRUE(stopped_);
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
