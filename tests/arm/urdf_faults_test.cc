// Arm descriptions at fault: one line that names the joint or link, and nothing of the parser's.
#include <gmock/gmock.h>

#include "iiwa_variants.h"
#include "impedraw/arm/arm_model.h"
#include "impedraw/common/errors.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

const char* const kJoint3 = "<joint name=\"joint_3\"";
const char* const kLink3 = "<link name=\"link_3\"";

class UrdfFaults : public ScratchFolder {
 protected:
  void expect(const std::string& urdf, const std::vector<std::string>& named) const {
    const auto file = write("arm.urdf", urdf);
    ::testing::internal::CaptureStderr();
    ::testing::internal::CaptureStdout();
    std::string error = "accepted";
    try {
      ArmModel{file};
    } catch (const InputError& caught) {
      error = caught.what();
    }
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    EXPECT_THAT(error, HasSubstr("arm.urdf"));
    for (const std::string& words : named) EXPECT_THAT(error, HasSubstr(words));
  }
};

TEST_F(UrdfFaults, TheParsersMessagesBecomeOneLine) {
  expect("<robot name=\"a\"><link name=\"b\"></robot>", {"line 1", "</robot> closes <link>"});
  expect("not XML", {"a URDF is XML"});
  const std::string limit =
      "<limit lower=\"-2.96706\" upper=\"2.96706\" effort=\"176\" velocity=\"1.7453\"/>";
  expect(changed(iiwa_urdf(), kJoint3, limit, ""), {"joint_3", "limit"});
  expect(changed(iiwa_urdf(), kJoint3, "parent link=\"link_2\"", "parent link=\"none\""), {"none"});
  expect(changed(iiwa_urdf(), kJoint3, "xyz=\"0 0.2045 0\"", "xyz=\"0 abc 0\""), {"not a valid"});
}

TEST_F(UrdfFaults, RadiiAndLengthsMustBePositive) {
  expect(changed(iiwa_urdf(), kLink3, "radius=\"0.07\" length=\"0.2155\"",
                 "radius=\"-0.07\" length=\"0.2155\""),
         {"'link_3'", "radius", "-0.07", "more than 0"});
  expect(changed(iiwa_urdf(), "<collision><origin xyz=\"0 0 0.10775\" rpy=\"0 0 0\"/>",
                 "length=\"0.2155\"", "length=\"0\""),
         {"length", "more than 0"});
  expect(changed(iiwa_urdf(), kLink3, "<sphere radius=\"0.07\"/>", "<sphere radius=\"-1\"/>"),
         {"'link_3'", "sphere", "-1"});
}

TEST_F(UrdfFaults, JointsThatCannotBeDrivenAreNamed) {
  expect(changed(iiwa_urdf(), kJoint3, "<limit", "<mimic joint=\"joint_1\"/><limit"),
         {"'joint_3'", "mimics", "'joint_1'"});
  expect(changed(iiwa_urdf(), kJoint3, "revolute", "floating"), {"'joint_3'", "floating"});
  const std::string slide = changed(iiwa_urdf(), kJoint3, "revolute", "prismatic");
  expect(changed(slide, kJoint3, "lower=\"-2.96706\"", "lower=\"4\""),
         {"'joint_3'", "lower limit"});
  expect(changed(slide, kJoint3, "effort=\"176\"", "effort=\"0\""), {"'joint_3'", "effort"});
}

// Each was taken, and its motion unstable, endless, or refused in MuJoCo's words.
TEST_F(UrdfFaults, AxesDampingAndSpeedsThatNoJointHasAreNamed) {
  for (const char* axis : {"0 0 0", "0 1e-12 0"})
    expect(changed(iiwa_urdf(), kJoint3, "<axis xyz=\"0 0 1\"/>",
                   std::string("<axis xyz=\"") + axis + "\"/>"),
           {"'joint_3'", std::string("<axis xyz=\"") + axis + "\">", "direction"});
  for (const char* what : {"damping=\"-1\"", "friction=\"-2\"", "damping=\"1e9\""})
    expect(changed(iiwa_urdf(), kJoint3, "<limit", std::string("<dynamics ") + what + "/><limit"),
           {"'joint_3'", what, "valid are 0 to 10000"});
  for (const char* velocity : {"1e-9", "0", "-1", "nan", "inf"})
    expect(changed(iiwa_urdf(), kJoint3, "velocity=\"1.7453\"",
                   std::string("velocity=\"") + velocity + "\""),
           {"'joint_3'", velocity, "0.01 rad/s or more"});
  for (const std::string length : {"inf", "nan", "abc"})
    expect(changed(iiwa_urdf(), "<collision><origin xyz=\"0 0 0.10775\" rpy=\"0 0 0\"/>",
                   "length=\"0.2155\"", "length=\"" + length + "\""),
           {"cylinder's length is " + length});
}

TEST_F(UrdfFaults, SixAndEightJointsAreRead) {
  EXPECT_EQ(ArmModel(write("6.urdf", six_joint_urdf())).joints(), 6);
  EXPECT_EQ(ArmModel(write("8.urdf", eight_joint_urdf())).joints(), 8);
}

}  // namespace
}  // namespace impedraw
