// The arm stands clear of the canvas when a run begins, or the run is refused before.
#include <regex>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "iiwa_variants.h"
#include "impedraw/common/errors.h"
#include "impedraw/experiment/prepare.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

// The cylinder's top lies on both sides of the arm's base.
TEST(StartPosture, ACanvasThroughTheArmIsRefusedByNameBeforeThePlan) {
  DrawOptions options;
  options.assignments = {"canvas.kind=cylinder", "canvas.cylinder.length=2"};
  try {
    prepare_plan(resolve(options));
    FAIL() << "is planned";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("link_1 touches the canvas in the start"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("arm.start"));
  }
  options.assignments = {"canvas.kind=cylinder", "canvas.cylinder.length=0.6"};
  EXPECT_NO_THROW(prepare_plan(resolve(options)));
}

// The iiwa's description with all lengths of joints and bodies times `scale`.
std::string scaled_iiwa(double scale) {
  const std::string text = iiwa_urdf();
  const std::regex length("(<origin xyz|radius|length)=\"([^\"]*)\"");
  std::string urdf;
  auto from = text.begin();
  for (std::sregex_iterator at(text.begin(), text.end(), length), end; at != end; ++at) {
    urdf.append(from, text.begin() + at->position());
    urdf += (*at)[1].str() + "=\"";
    std::istringstream numbers((*at)[2].str());
    for (double x; numbers >> x;) urdf += std::to_string(scale * x) + " ";
    urdf.back() = '"';
    from = text.begin() + at->position() + at->length();
  }
  return urdf.append(from, text.end());
}

class SmallArm : public ScratchFolder {};

TEST_F(SmallArm, StartsNearerToItsBaseAndSaysSo) {
  DrawOptions options;
  const std::string urdf = "arm.urdf=" + write("small.urdf", scaled_iiwa(0.55)).string();
  options.assignments = {urdf};
  const PreparedPlan e = prepare_plan(resolve(options), {}, Unreachable::tell);
  EXPECT_THAT(e.belief.notes, ::testing::Contains(::testing::HasSubstr("the tip starts at")));
  EXPECT_LT(e.scenario.arm.start_p_WE.x(), 0.44);
  ArmModel arm(folder_ / "small.urdf");
  EXPECT_LT((arm.tip_pose(e.belief.start_q).p - e.scenario.arm.start_p_WE).norm(), 1e-6);
  // A start that somebody asks for is not moved.
  options.assignments = {urdf, "arm.start=[0.45, 0, 0.51]"};
  EXPECT_THROW(prepare_plan(resolve(options), {}, Unreachable::tell), InputError);
}

// As a vendor's arm whose meshes are four times as large as it is.
TEST_F(SmallArm, ALinkThatHidesTheCanvasIsNamed) {
  const std::string huge = changed(
      iiwa_urdf(), "<link name=\"link_0\">\n",
      "<collision><origin xyz=\"0 0 0.07875\" rpy=\"0 0 0\"/><geometry><cylinder radius=\"0.09\"",
      "<collision><origin xyz=\"0 0 0.07875\" rpy=\"0 0 0\"/><geometry><cylinder radius=\"0.9\"");
  DrawOptions options;
  options.assignments = {"arm.urdf=" + write("huge.urdf", huge).string()};
  try {
    prepare_plan(resolve(options), {}, Unreachable::tell);
    FAIL() << "is planned";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("link_0, whose body is 1.8 m across, stands"));
  }
}

}  // namespace
}  // namespace impedraw
