// Commissioning from the command line: each step finds what was put into the arm, refuses to begin
// without the one before, and draws with what was found.
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "impedraw/log/run_data.h"
#include "process.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;
using Words = std::vector<std::string>;
using Json = nlohmann::json;

class CommissionTest : public ScratchFolder {
 protected:
  Ended arm(const Words& arguments) const {
    Words words = {"arm"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    words.insert(words.end(), {"--into", "c"});
    return Process(folder_, words).wait();
  }
  Ended call(const Words& arguments) const { return Process(folder_, arguments).wait(); }
  Json found() const { return Json::parse(content_of(folder_ / "c/commissioning.json")); }
  void write_found(const Json& json) const { write("c/commissioning.json", json.dump()); }

  void find_latency() const {
    const Ended ended = arm({"latency", "--arm", "sim", "--set", "world.errors.loop_delay=0.002"});
    ASSERT_EQ(ended.code, 0) << ended.err;
  }
  // As if somebody had led the tip: `point` touched by a pen that is `longer` than the model's.
  static Json touch(const Eigen::Vector3d& point, const Eigen::Vector3d& axis, double longer) {
    const Eigen::Quaterniond R =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis.normalized());
    const Eigen::Matrix3d M = R.toRotationMatrix();
    const Eigen::Vector3d p = point - longer * M.col(2);
    return {{"p_WE", {p.x(), p.y(), p.z()}},
            {"R_WE", std::vector<double>(M.data(), M.data() + 9)},
            {"q", Json::array()}};
  }
};

TEST_F(CommissionTest, EachStepNeedsTheOneBefore) {
  EXPECT_THAT(arm({"friction", "--arm", "sim"}).err, HasSubstr("has no 'latency'; run ./impedraw"));
  EXPECT_THAT(arm({"touch", "--mark", "pen"}).err, HasSubstr("has no 'friction'"));
  EXPECT_THAT(arm({"pen-length"}).err, HasSubstr("--mark pen"));
  EXPECT_THAT(arm({"register"}).err, HasSubstr("has no 'pen-length'"));
  EXPECT_THAT(call({"draw", "--commissioned", "c", "--out", "run"}).err,
              HasSubstr("has no 'latency'"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "c"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "run"));
}

TEST_F(CommissionTest, LatencyAndFrictionThatWerePutInAreFound) {
  find_latency();
  EXPECT_NEAR(found()["latency"]["delay_s"].get<double>(), 0.002, 1e-9);
  const Ended ended = arm({"friction", "--arm", "sim", "--set", "world.joint_friction=0.4", "--set",
                           "world.errors.loop_delay=0.002"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  ASSERT_EQ(found()["friction"].size(), 7u);
  for (const Json& joint : found()["friction"])
    EXPECT_NEAR(joint["coulomb_Nm"].get<double>(), 0.4, 0.02) << joint;
}

TEST_F(CommissionTest, CameraLatencyThatWasPutInIsFoundAndTaken) {
  const std::string scenario = std::filesystem::absolute("scenarios/moving-sway.yaml").string();
  const Ended ended = arm({"camera-latency", scenario, "--seconds", "12", "--set",
                           "perception.errors.time_stamp=0.025"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  const Json latency = found()["camera-latency"];
  EXPECT_NEAR(latency["stamp_error_s"].get<double>(), 0.025, 1e-3);
  EXPECT_NEAR(latency["latency_s"].get<double>(), 0.06, 2e-3);
  EXPECT_NEAR(latency["jitter_s"].get<double>(), 0.01, 2e-3);
  EXPECT_THAT(arm({"camera-latency", scenario, "--set", "canvas.motion.sway=[0, 0, 0]", "--set",
                   "canvas.motion.roll=0"})
                  .err,
              HasSubstr("the canvas stands"));
  EXPECT_THAT(arm({"camera-latency"}).err, HasSubstr("no camera keeps capturing"));
}

TEST_F(CommissionTest, PenAndPageOfMadeUpTouchesAreFound) {
  Json json;
  json["latency"] = {{"delay_s", 0.001}};
  json["friction"] = Json::array();
  const Eigen::Vector3d dimple(0.5, 0.1, 0.05);
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(0, 0, -1), {0.5, 0, -1}, {0, 0.5, -1}, {-0.4, -0.3, -1}})
    json["pen touches"].push_back(touch(dimple, axis, 0.012));
  // A mesh that stands at (0.6, -0.1, 0.02), turned by 30 degrees about z.
  const Eigen::AngleAxisd turn(M_PI / 6.0, Eigen::Vector3d::UnitZ());
  const std::vector<Eigen::Vector3d> marks = {
      {0, 0, 0}, {0.2, 0, 0.01}, {0, 0.15, -0.02}, {0.2, 0.15, 0.03}};
  for (const Eigen::Vector3d& mark : marks) {
    json["page touches"].push_back(
        touch(turn * mark + Eigen::Vector3d(0.6, -0.1, 0.02), {0.1, 0.2, -1}, 0.012));
    json["page touches"].back()["mark"] = {mark.x(), mark.y(), mark.z()};
  }
  write_found(json);
  ASSERT_EQ(arm({"pen-length"}).code, 0);
  EXPECT_NEAR(found()["pen-length"]["longer_m"].get<double>(), 0.012, 1e-6);
  ASSERT_EQ(arm({"register"}).code, 0);
  const Json page = found()["register"];
  EXPECT_NEAR(page["p_WP_m"][0].get<double>(), 0.6, 1e-6);
  EXPECT_NEAR(page["p_WP_m"][1].get<double>(), -0.1, 1e-6);
  EXPECT_NEAR(page["p_WP_m"][2].get<double>(), 0.02, 1e-6);
  EXPECT_NEAR(page["roll_pitch_yaw_deg"][2].get<double>(), 30.0, 1e-4);

  json = found();
  json["page touches"][3]["p_WE"][2] = 0.1;  // slipped
  write_found(json);
  const Ended slipped = arm({"register"});
  EXPECT_EQ(slipped.code, 2) << slipped.err;
  EXPECT_EQ(found()["register"], page) << "what was found before stays";
}

TEST_F(CommissionTest, DrawTakesWhatWasFound) {
  find_latency();
  Json json = found();
  json["register"] = {{"p_WP_m", {0.6, 0.0, 0.02}}, {"roll_pitch_yaw_deg", {0.0, 0.0, 30.0}}};
  write_found(json);
  write("tile.obj", "v -0.2 -0.2 0\nv 0.2 -0.2 0\nv 0.2 0.2 0\nv -0.2 0.2 0\nf 1 2 3\nf 1 3 4\n");
  const Words words = {"draw",
                       "--commissioned",
                       "c",
                       "--shape",
                       "circle",
                       "--set",
                       "canvas.kind=mesh",
                       "--set",
                       "canvas.mesh.file=tile.obj",
                       "--set",
                       "world.errors.loop_delay=0.002",
                       "--set",
                       "drawing.placement.fit_radius=0.03",
                       "--set",
                       "path.draw_speed=0.1",
                       "--out",
                       "run"};
  const Ended ended = call(words);
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("commissioned  control.torque_delay=0.002"));
  EXPECT_THAT(ended.err, HasSubstr("commissioned  canvas.mesh.rotation=[0, 0, 30]"));
  const std::string scenario = content_of(folder_ / "run/scenario.yaml");
  EXPECT_THAT(scenario, HasSubstr("torque_delay: 0.002"));
  EXPECT_GT(Json::parse(content_of(folder_ / "run/metrics.json"))["contact_fraction"], 0.999);
}

TEST_F(CommissionTest, AnotherArmAndAnotherPenAreRefused) {
  find_latency();
  const Json json = found();
  Json other = json;
  other["arm"]["joints"][6] = "wrist_3_joint";
  write_found(other);
  EXPECT_THAT(call({"plan", "--commissioned", "c"}).err, HasSubstr("is of another arm"));
  other = json;
  other["pen-length"] = {{"longer_m", 0.012}};
  write_found(other);
  EXPECT_THAT(call({"plan", "--commissioned", "c"}).err,
              HasSubstr("it was found 12.0 mm longer than it was then"));
  write("c/commissioning.json", R"({"latency": {}})");
  EXPECT_THAT(call({"plan", "--commissioned", "c"}).err, HasSubstr("is damaged"));
}

// In the air: the whole drawing, the stated height above, and nothing touched.
TEST_F(CommissionTest, ADryRunTouchesNothing) {
  const Ended ended = call(
      {"draw", "--set", "drawing.dry_run=0.05", "--set", "path.draw_speed=0.1", "--out", "run"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  const RunData run = read_run(folder_ / "run/run.h5");
  ASSERT_GT(run.rows(), 1000u);
  for (const double f : run.f) EXPECT_EQ(f, 0.0);
  const Json metrics = Json::parse(content_of(folder_ / "run/metrics.json"));
  EXPECT_EQ(metrics["contact_fraction"], 0.0);
  EXPECT_GT(metrics["planned_time"], 1.0);
}

}  // namespace
}  // namespace impedraw
