#include "impedraw/capture/capture.h"

#include <cmath>
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "../scratch_folder.h"
#include "grey_png.h"
#include "impedraw/capture/capture_cloud.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;
using CaptureFolder = ScratchFolder;
using ::testing::HasSubstr;

constexpr int kWidth = 320, kHeight = 240;
constexpr double kFocal = 300.0, kScale = 1e-4;  // [px], [m]
const Eigen::Vector3d kCentre(0.6, 0.0, 0.1);    // of a ball on a table at z = 0
constexpr double kRadius = 0.1;

// A camera above (0.6, 0, 0) that looks down, x of C along x of W.
Pose above(double height) {
  Pose X_WC;
  X_WC.p = {0.6, 0.0, height};
  X_WC.R = Eigen::Vector3d(1, -1, -1).asDiagonal();
  return X_WC;
}

// Ball and table in closed form, as depth along the camera's z; `mix`: of both at the ball's rim.
GreyImage ball_on_table(const Pose& X_WC, bool mix) {
  GreyImage image{kWidth, kHeight, {}};
  for (int j = 0; j < kHeight; ++j) {
    for (int i = 0; i < kWidth; ++i) {
      const Eigen::Vector3d d =
          X_WC.R * Eigen::Vector3d((i - 159.5) / kFocal, (j - 119.5) / kFocal, 1);
      const Eigen::Vector3d o = X_WC.p - kCentre;
      const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - kRadius * kRadius;
      const double inside = b * b - a * c, table = -X_WC.p.z() / d.z();
      double z = inside > 0 ? (-b - std::sqrt(inside)) / a : table;
      const double rim = std::sqrt(std::max(0.0, c - b * b / a + kRadius * kRadius)) - kRadius;
      if (mix && std::abs(rim) < 0.7 * table / kFocal) z = 0.5 * (z + table);
      image.values.push_back(static_cast<std::uint16_t>(std::lround(z / kScale)));
    }
  }
  return image;
}

std::string view_json(const std::string& depth, const Pose& X_WC, const std::string& more = {}) {
  const Eigen::Quaterniond q(X_WC.R);
  return fmt::format(
      R"({{"depth": "{}", "depth_scale": {}, "width": {}, "height": {}, "fx": {}, "fy": {}, )"
      R"("cx": 159.5, "cy": 119.5, "X_WC": {{"p": [{}, {}, {}], "q_wxyz": [{}, {}, {}, {}]}}{}}})",
      depth, kScale, kWidth, kHeight, kFocal, kFocal, X_WC.p.x(), X_WC.p.y(), X_WC.p.z(), q.w(),
      q.x(), q.y(), q.z(), more);
}

void write_capture(const fs::path& folder, const std::string& views) {
  std::ofstream(folder / "capture.json")
      << R"({"format": "impedraw-capture", "version": 1, "views": [)" << views << "]}";
}

Pose no_tip(const std::vector<double>&) { throw InputError("no arm"); }

std::string error_of(const fs::path& folder) {
  try {
    read_capture(folder, no_tip);
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST_F(CaptureFolder, PointsLieOnTheBallAndTheTable) {
  write_grey_png(folder_ / "d.png", ball_on_table(above(0.8), true));
  write_capture(folder_, view_json("d.png", above(0.8)));
  const CaptureCloud seen = cloud_of(read_capture(folder_, no_tip), {}, {});
  ASSERT_GT(seen.cloud.points.size(), 0.9 * kWidth * kHeight);
  double worst = 0;
  for (const Eigen::Vector3d& p : seen.cloud.points)
    worst = std::max(worst, std::min(std::abs((p - kCentre).norm() - kRadius), std::abs(p.z())));
  EXPECT_LT(worst, 1.5e-4);  // the step of the depth values; what mixes both is off by centimetres
  ASSERT_EQ(seen.notes.size(), 1u);
  EXPECT_THAT(seen.notes.front(), HasSubstr("beside edges"));
}

TEST_F(CaptureFolder, PlacesACameraOnTheTool) {
  write_grey_png(folder_ / "d.png", ball_on_table(above(0.8), false));
  std::string view = view_json("d.png", above(0.3), R"(, "joints": [0.5])");
  view.replace(view.find("X_WC"), 4, "X_EC");
  write_capture(folder_, view);
  const auto lifted = [](const std::vector<double>& q) {
    Pose X_WE;
    X_WE.p.z() = q.at(0);
    return X_WE;
  };
  const Capture capture = read_capture(folder_, lifted);
  EXPECT_LT((capture.views.front().X_WC.p - above(0.8).p).norm(), 1e-12);
}

TEST_F(CaptureFolder, LeavesOutTheArm) {
  write_grey_png(folder_ / "d.png", ball_on_table(above(0.8), false));
  write_capture(folder_, view_json("d.png", above(0.8), R"(, "joints": [0.0])"));
  const auto ball = [](const std::vector<double>&) {
    return std::vector<Capsule>{{kCentre, kCentre, kRadius}};
  };
  const CaptureCloud seen = cloud_of(read_capture(folder_, no_tip), {}, ball);
  for (const Eigen::Vector3d& p : seen.cloud.points) ASSERT_LT(std::abs(p.z()), 0.02);
}

// The camera sees it 16 mm beside where the joints say that it is: more than the padding.
TEST_F(CaptureFolder, LeavesOutAnArmThatStandsBeside) {
  write_grey_png(folder_ / "d.png", ball_on_table(above(0.8), false));
  write_capture(folder_, view_json("d.png", above(0.8), R"(, "joints": [0.0])"));
  const Eigen::Vector3d beside = kCentre + Eigen::Vector3d(0.016, 0.0, 0.0);
  const CaptureCloud seen = cloud_of(read_capture(folder_, no_tip), {}, [&](const auto&) {
    return std::vector<Capsule>{{beside, beside, kRadius}};
  });
  EXPECT_GT(seen.cloud.points.size(), 0.6 * kWidth * kHeight);  // the table
  for (const Eigen::Vector3d& p : seen.cloud.points) ASSERT_LT(std::abs(p.z()), 0.02);
}

TEST_F(CaptureFolder, RefusesWhatIsDamagedInOneLine) {
  const fs::path& folder = folder_;
  EXPECT_THAT(error_of(folder / "none"), HasSubstr("is no folder"));
  EXPECT_THAT(error_of(folder), HasSubstr("no such file"));
  std::ofstream(folder / "capture.json") << "{";
  EXPECT_THAT(error_of(folder), HasSubstr("no valid JSON"));
  write_capture(folder, "");
  EXPECT_THAT(error_of(folder), HasSubstr("a view or more"));
  write_capture(folder, view_json("d.png", above(0.8)));
  EXPECT_THAT(error_of(folder), HasSubstr("no such file"));
  write_grey_png(folder / "d.png", {16, 16, std::vector<std::uint16_t>(256, 1)});
  EXPECT_THAT(error_of(folder), HasSubstr("d.png has 16 × 16 px, the view 320 × 240"));
  write_grey_png(folder / "d.png", ball_on_table(above(0.8), false));
  EXPECT_EQ(error_of(folder), "no error");
  fs::resize_file(folder / "d.png", fs::file_size(folder / "d.png") / 2);
  EXPECT_THAT(error_of(folder), HasSubstr("ends too early"));
  std::ofstream(folder / "d.png") << "text";
  EXPECT_THAT(error_of(folder), HasSubstr("is no PNG image"));
  write_capture(folder, view_json("../d.png", above(0.8)));
  EXPECT_THAT(error_of(folder), HasSubstr("in the capture's folder"));
  Pose scaled = above(0.8);
  std::string view = view_json("d.png", scaled);
  view.replace(view.find("q_wxyz\": ["), 10, "q_wxyz\": [9");
  write_capture(folder, view);
  EXPECT_THAT(error_of(folder), HasSubstr("must have 1"));
  view = view_json("d.png", above(0.8), R"(, "distortion": {"model": "fisheye"})");
  write_capture(folder, view);
  EXPECT_THAT(error_of(folder), HasSubstr("valid are none, brown_conrady"));
}

TEST_F(CaptureFolder, NotesUnknownKeys) {
  write_grey_png(folder_ / "d.png", ball_on_table(above(0.8), false));
  write_capture(folder_, view_json("d.png", above(0.8), R"(, "serial": 7)"));
  const Capture capture = read_capture(folder_, no_tip);
  ASSERT_EQ(capture.notes.size(), 1u);
  EXPECT_THAT(capture.notes.front(), HasSubstr("'serial' is not read"));
}

}  // namespace
}  // namespace impedraw
