// The tool that static readings show, against the one that made them.
#include "impedraw/sensing/tool_identification.h"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kMass = 0.52;
const Vector3d kCentre(0.012, -0.021, 0.127);
const Vector6 kBias = (Vector6() << 3.0, -2.0, 5.0, 0.2, -0.1, 0.05).finished();
const Vector3d kGravity(0.0, 0.0, -9.81);

StaticReading pose(const Matrix3d& R_WS) {
  const Vector3d weight_W = kMass * kGravity;
  StaticReading out{R_WS, kBias};
  out.reading_S.head<3>() += R_WS.transpose() * weight_W;
  out.reading_S.tail<3>() +=
      R_WS.transpose() * (R_WS * kCentre).cross(weight_W);  // in W, where the arm hangs
  return out;
}

Matrix3d tilt(double angle_deg, const Vector3d& axis) {
  return AngleAxisd(angle_deg * std::numbers::pi / 180.0, axis.normalized()).matrix();
}

// Pen down, and five tilts that a wrist reaches.
std::vector<StaticReading> six_poses() {
  const Matrix3d down = tilt(180.0, Vector3d::UnitX());
  std::vector<StaticReading> poses{pose(down)};
  for (const double angle : {60.0, -60.0}) {
    poses.push_back(pose(down * tilt(angle, Vector3d::UnitX())));
    poses.push_back(pose(down * tilt(angle, Vector3d::UnitY())));
  }
  poses.push_back(pose(down * tilt(90.0, {1.0, 1.0, 0.0})));
  return poses;
}

std::string refusal(const std::vector<StaticReading>& poses, const Vector3d& gravity_W = kGravity) {
  try {
    identify_tool(poses, gravity_W);
  } catch (const InputError& error) {
    std::printf("  %s\n", error.what());
    return error.what();
  }
  return "taken";
}

TEST(ToolIdentification, IsExactWithoutNoise) {
  for (const std::size_t count : {3, 6}) {
    std::vector<StaticReading> poses = six_poses();
    poses.resize(count);
    const ToolIdentification tool = identify_tool(poses);
    EXPECT_NEAR(tool.mass, kMass, 1e-12);
    EXPECT_LT((tool.p_SC - kCentre).norm(), 1e-12);
    EXPECT_LT((tool.bias_S - kBias).norm(), 1e-11);
    EXPECT_LT(tool.residual_force, 1e-12);
    EXPECT_LT(tool.residual_torque, 1e-12);
  }
}

TEST(ToolIdentification, ItsErrorsAreAsLargeAsItSays) {
  const int seed = 21, trials = 1000;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 rng(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  const double noise_force = 0.05, noise_torque = 0.003;
  double mass_square = 0.0, mass_stated = 0.0, force_square = 0.0, torque_square = 0.0;
  Vector3d centre_square = Vector3d::Zero(), centre_stated = Vector3d::Zero();
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<StaticReading> poses = six_poses();
    for (StaticReading& p : poses) {
      p.reading_S.head<3>() += Vector3d::NullaryExpr([&] { return noise_force * noise(rng); });
      p.reading_S.tail<3>() += Vector3d::NullaryExpr([&] { return noise_torque * noise(rng); });
    }
    const ToolIdentification tool = identify_tool(poses);
    EXPECT_NEAR(tool.mass, kMass, 0.02);
    EXPECT_LT((tool.p_SC - kCentre).norm(), 5e-3);
    EXPECT_LT((tool.bias_S - kBias).head<3>().norm(), 0.3);
    EXPECT_LT((tool.bias_S - kBias).tail<3>().norm(), 0.02);
    mass_square += std::pow(tool.mass - kMass, 2) / trials;
    mass_stated += std::pow(tool.mass_error, 2) / trials;
    centre_square += (tool.p_SC - kCentre).cwiseAbs2() / trials;
    centre_stated += tool.p_SC_error.cwiseAbs2() / trials;
    force_square += std::pow(tool.residual_force, 2) / trials;
    torque_square += std::pow(tool.residual_torque, 2) / trials;
  }
  std::printf(
      "  mass ± %.4f kg, stated %.4f; centre ± (%.2f %.2f %.2f) mm, stated (%.2f %.2f %.2f)\n",
      std::sqrt(mass_square), std::sqrt(mass_stated), 1e3 * std::sqrt(centre_square[0]),
      1e3 * std::sqrt(centre_square[1]), 1e3 * std::sqrt(centre_square[2]),
      1e3 * std::sqrt(centre_stated[0]), 1e3 * std::sqrt(centre_stated[1]),
      1e3 * std::sqrt(centre_stated[2]));
  EXPECT_NEAR(std::sqrt(mass_square / mass_stated), 1.0, 0.1);  // √(1/2000) = 2 % of scatter
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(std::sqrt(centre_square[axis] / centre_stated[axis]), 1.0, 0.1) << axis;
  EXPECT_NEAR(std::sqrt(force_square), noise_force, 0.05 * noise_force);
  EXPECT_NEAR(std::sqrt(torque_square), noise_torque, 0.05 * noise_torque);
}

TEST(ToolIdentification, ConditionIsAsItsHeaderSays) {
  std::vector<StaticReading> poses;
  for (const double angle : {0.0, 90.0, 180.0, 270.0})
    poses.push_back(pose(tilt(angle, Vector3d::UnitX())));
  for (const double angle : {90.0, -90.0}) poses.push_back(pose(tilt(angle, Vector3d::UnitY())));
  EXPECT_NEAR(identify_tool(poses).condition, std::sqrt(1.5), 1e-9);
  poses.clear();
  for (const double angle : {30.0, -30.0}) {
    poses.push_back(pose(tilt(angle, Vector3d::UnitX())));
    poses.push_back(pose(tilt(angle, Vector3d::UnitY())));
  }
  std::printf("  ± 30° about two axes: condition %.2f\n", identify_tool(poses).condition);
  EXPECT_NEAR(identify_tool(poses).condition, 5.0, 0.5);
}

TEST(ToolIdentification, NamesWhatDegeneratePosesLeaveOpen) {
  EXPECT_THAT(refusal({}), HasSubstr("0 poses, needs at least 3"));
  EXPECT_THAT(refusal({six_poses()[0], six_poses()[1]}), HasSubstr("2 poses, needs at least 3"));

  std::vector<StaticReading> about_the_vertical, about_x, two_ends;
  for (const double angle : {0.0, 40.0, 90.0, 200.0})
    about_the_vertical.push_back(pose(tilt(angle, Vector3d::UnitZ())));
  EXPECT_THAT(refusal(about_the_vertical), HasSubstr("mass and force bias"));
  // Upside down and back: gravity has turned, but along one line only.
  for (const double angle : {0.0, 180.0, 0.0, 180.0})
    two_ends.push_back(pose(tilt(angle, Vector3d::UnitX())));
  EXPECT_THAT(refusal(two_ends), HasSubstr("centre of mass along (0.00, 0.00, "));
  for (const double angle : {-4.0, 0.0, 4.0})
    about_x.push_back(pose(tilt(angle, Vector3d::UnitX())));
  EXPECT_THAT(refusal(about_x), HasSubstr("mass and force bias"));
  about_x.push_back(pose(tilt(70.0, Vector3d::UnitX())));
  // Gravity has gone from −z to (0, −sin 70°, −cos 70°).
  EXPECT_THAT(refusal(about_x), HasSubstr("centre of mass along (0.00, 0.82, -0.57)"));
  std::vector<StaticReading> repaired = about_x, arc = about_x;
  repaired.push_back(
      pose(tilt(40.0, {0.0, 0.82, -0.57})));  // gravity goes across, as the message says
  EXPECT_EQ(refusal(repaired), "taken");
  arc.push_back(pose(tilt(-70.0, Vector3d::UnitX())));
  EXPECT_EQ(refusal(arc), "taken") << "an arc about one axis will do, if it is long";
}

TEST(ToolIdentification, RefusesReadingsThatCannotBe) {
  std::vector<StaticReading> poses = six_poses();
  poses[2].reading_S[4] = std::nan("");
  EXPECT_THAT(refusal(poses), HasSubstr("pose 2 must have a finite reading"));
  poses = six_poses();
  poses[1].R_WS *= 1.1;
  EXPECT_THAT(refusal(poses), HasSubstr("pose 1 must have a rotation"));
  poses = six_poses();
  for (StaticReading& p : poses) p.reading_S *= -1.0;
  EXPECT_THAT(refusal(poses), HasSubstr("must be greater than 0"));
  EXPECT_THAT(refusal(six_poses(), Vector3d::Zero()), HasSubstr("gravity_W"));
}

}  // namespace
}  // namespace impedraw
