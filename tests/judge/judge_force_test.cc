// ./impedraw judge-force as its user meets it.
#include <chrono>
#include <csignal>
#include <thread>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "process.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Words = std::vector<std::string>;

class JudgeForce : public ScratchFolder {
 protected:
  Ended call(Words words) const {
    words.insert(words.begin(), "judge-force");
    return Process(folder_, words).wait();
  }
};

TEST_F(JudgeForce, LeavesEveryMetricOfEveryRun) {
  const Ended ended = call({"--cases", "hold-still,contact-10", "--runs", "2", "--out", "out"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  const auto json = nlohmann::json::parse(content_of(folder_ / "out/force.json"));
  ASSERT_EQ(json["cases"].size(), 2u);
  EXPECT_EQ(json["cases"][0]["case"], "contact-10");
  for (const auto& one : json["cases"]) {
    ASSERT_EQ(one["controllers"].size(), 3u);
    for (const auto& judged : one["controllers"]) {
      ASSERT_EQ(judged["runs"].size(), 2u);
      double sum = 0.0;
      for (const auto& run : judged["runs"]) {
        EXPECT_FALSE(run.contains("ended")) << run.dump();
        for (const char* metric :
             {"settling_time", "overshoot", "steady_error", "rms", "sd", "bandwidth", "work_lost"})
          EXPECT_TRUE(run.contains(metric));
        sum += run["rms"].get<double>();
      }
      EXPECT_DOUBLE_EQ(judged["mean"]["rms"].get<double>(), 0.5 * sum);
      EXPECT_NE(judged["runs"][0]["rms"], judged["runs"][1]["rms"]);  // noise and placement differ
    }
  }
  const auto& ours = json["cases"][1]["controllers"][0];
  EXPECT_LT(ours["worst"]["steady_error"].get<double>(), 0.1);
  EXPECT_LT(ours["worst"]["sd"].get<double>(), 0.1);
  const std::string page = content_of(folder_ / "out/force.html");
  EXPECT_NE(page.find("<th>steady_error<br>[N]</th>"), std::string::npos);  // fits 1200 pixels
  EXPECT_THAT(page, AllOf(HasSubstr("<h1>Force benchmark, simulated</h1>"), HasSubstr("<svg"),
                          HasSubstr("written here"), HasSubstr("is behind")));
}

TEST_F(JudgeForce, TwoIntoOneFolderAreRefused) {
  std::filesystem::create_directory(folder_ / "out");
  const Words words{"judge-force", "--out", "out"};
  Process first(folder_, words);
  while (first.running() && !std::filesystem::exists(folder_ / "out/run.lock"))
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const Ended second = call({"--cases", "contact-10", "--runs", "1", "--out", "out"});
  EXPECT_EQ(second.code, 2) << second.err;
  EXPECT_THAT(second.err, HasSubstr("out"));
  first.signal(SIGINT);
  EXPECT_NE(first.wait().code, 0);
}

// Its workpiece goes with the canvas. The scenario's drawing would lie off that.
TEST_F(JudgeForce, FollowsACanvasThatWasMoved) {
  const Ended ended = call({"--cases", "hold-still", "--runs", "1", "--controllers", "ours",
                            "--set", "canvas.move=[0.05,0.12,0.05]", "--out", "out"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  const auto json = nlohmann::json::parse(content_of(folder_ / "out/force.json"));
  const auto& ours = json["cases"][0]["controllers"][0];
  EXPECT_LT(ours["worst"]["steady_error"].get<double>(), 0.1);
}

TEST_F(JudgeForce, NamesWhatIsWrong) {
  const std::pair<Words, const char*> cases[] = {
      {{"--cases", "stepps"}, "steps"},
      {{"--controllers", "crips"}, "crisp"},
      {{"--runs", "0"}, "--runs"},
      {{"--arm", "ur6e"}, "ur5e"},
      {{"--set", "canvas.kind=plane", "--cases", "steps"}, "canvas.kind"},
      {{"--rig", "orders.json", "--cases", "steps"}, "its own workpieces"},
      {{"--sensor", "none.csv", "--cases", "steps"}, "--sensor: the simulated arm"},
      {{"--set", "tool.kind=pad", "--cases", "steps"}, "tool.kind: judge-force judges a pen's"},
      {{"--arm", "iiwa-lcm", "--cases", "hand-across", "--set", "control.wrench=ground_truth"},
       "--rig"}};
  for (const auto& [words, said] : cases) {
    const Ended ended = call(words);
    EXPECT_EQ(ended.code, 2) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(said));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "runs/judge-force/force.json"));
  }
}

}  // namespace
}  // namespace impedraw
