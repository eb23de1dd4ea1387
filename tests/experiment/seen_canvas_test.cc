// Drawing on a cloud: of the standard bowl, written from its mesh, and of a sheet with a hole that
// nobody modelled.
#include <cmath>
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "../scratch_folder.h"
#include "impedraw/canvas/built_in.h"
#include "impedraw/common/errors.h"
#include "impedraw/experiment/prepare.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using ::testing::Contains;
using ::testing::HasSubstr;
using SeenFolder = ScratchFolder;

Prepared bowl_with(std::vector<std::string> assignments) {
  DrawOptions options;
  options.scenario = "scenarios/bowl-sine.yaml";
  options.assignments = std::move(assignments);
  return prepare(resolve(options));
}

std::string error_of(std::vector<std::string> assignments) {
  try {
    bowl_with(std::move(assignments));
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

std::filesystem::path bowl_cloud(const std::filesystem::path& folder) {
  CapSettings settings;
  settings.edge = 0.003;
  std::ofstream file(folder / "bowl.xyz");
  for (const Vector3d& p : make_bowl(settings).vertices)
    file << fmt::format("{:.6f} {:.6f} {:.6f}\n", p.x(), p.y(), p.z());
  file << "nan nan nan\n";
  return folder / "bowl.xyz";
}

TEST_F(SeenFolder, TheSineOnACloudOfTheBowl) {
  const std::string cloud = "perception.cloud=" + bowl_cloud(folder_).string();
  const Prepared e = bowl_with({"perception.source=cloud", cloud});
  const Prepared simulated = bowl_with({});
  EXPECT_TRUE(e.plan.preflight.findings.empty());
  EXPECT_NEAR(e.plan.path.pen_down_length(), simulated.plan.path.pen_down_length(), 1e-3);
  double worst = 0.0;
  for (const Vector3d& p : e.yardstick.target.points) {
    const SurfaceEstimate at = e.belief.perception->estimate(p);
    ASSERT_EQ(at.status, SurfaceStatus::ok);
    worst = std::max(worst, std::abs(at.distance));
  }
  EXPECT_LT(worst, 1e-4);
  EXPECT_THAT(e.belief.notes, Contains(HasSubstr("1 have no place")));
}

TEST_F(SeenFolder, ACanvasThatNobodyModelledIsWhatWasSeen) {
  const std::string cloud = "perception.cloud=" + bowl_cloud(folder_).string();
  const Prepared e = bowl_with({"perception.source=cloud", cloud, "canvas.kind=seen"});
  EXPECT_TRUE(is_rehearsal(e.scenario));
  EXPECT_THAT(e.belief.notes, Contains(HasSubstr("rehearsal: ")));
  const CapSettings bowl;
  for (const Vector3d& p : e.yardstick.target.points)
    EXPECT_NEAR((p - bowl.centre).norm(), bowl.radius, 1e-4);
}

TEST_F(SeenFolder, HolesStayHoles) {
  std::ofstream file(folder_ / "sheet.xyz");
  for (double x = 0.45; x < 0.75; x += 0.002)
    for (double y = -0.15; y < 0.15; y += 0.002)
      if (std::hypot(x - 0.6, y) > 0.02) file << fmt::format("{} {} {}\n", x, y, 0.1);
  file.close();
  const Prepared e =
      bowl_with({"perception.source=cloud", "perception.cloud=" + (folder_ / "sheet.xyz").string(),
                 "canvas.kind=seen", "drawing.shape=sine", "drawing.skip_unreachable=true"});
  EXPECT_FALSE(e.truth.canvas->ray({0.6, 0.0, 1.0}, {0, 0, -1}));
  const auto beside = e.truth.canvas->ray({0.64, 0.0, 1.0}, {0, 0, -1});
  ASSERT_TRUE(beside);
  EXPECT_NEAR(beside->p_W.z(), 0.1, 1e-6);
}

TEST_F(SeenFolder, AnUprightSheetIsNoSurfaceTowardsThePage) {
  std::ofstream file(folder_ / "upright.xyz");
  for (double y = -0.15; y < 0.15; y += 0.002)
    for (double z = 0.05; z < 0.3; z += 0.002) file << fmt::format("{} {} {}\n", 0.6, y, z);
  file.close();
  EXPECT_THAT(
      error_of({"perception.source=cloud", "perception.cloud=" + (folder_ / "upright.xyz").string(),
                "perception.viewpoint=[1.5, 0, 0.2]", "canvas.kind=seen"}),
      HasSubstr("what was seen makes no surface towards the drawing plane"));
}

TEST(SeenCanvas, WhatNothingShowsIsRefused) {
  EXPECT_THAT(error_of({"canvas.kind=seen"}), HasSubstr("nothing shows it"));
  EXPECT_THAT(error_of({"perception.source=cloud"}), HasSubstr("perception.cloud is empty"));
  EXPECT_THAT(error_of({"arm.driver=iiwa-lcm"}), HasSubstr("canvas.true_model=true"));
  EXPECT_THAT(error_of({"arm.driver=iiwa-lcm", "canvas.true_model=true"}),
              ::testing::Not(HasSubstr("true_model")));
}

}  // namespace
}  // namespace impedraw
