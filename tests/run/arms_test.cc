// Arms that do not have seven joints: they draw with the default settings, and settings with one
// entry per joint are judged by the arm's own number of joints.
#include <gmock/gmock.h>

#include "iiwa_variants.h"
#include "impedraw/common/errors.h"
#include "run/drawn_scenario.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class ArmsTest : public ScratchFolder {
 protected:
  std::string six() const { return write("six.urdf", six_joint_urdf()).string(); }
  std::string eight() const { return write("eight.urdf", eight_joint_urdf()).string(); }

  std::string refusal(const std::vector<std::string>& assignments) const {
    DrawOptions options;
    options.scenario = "scenarios/bowl-sine.yaml";
    options.assignments = assignments;
    Places places;
    try {
      prepare(resolve(options, &places), places);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }
};

const std::vector<std::string> kCircle = {"drawing.shape=circle", "path.draw_speed=0.1"};

Figures draw_circle(const std::string& urdf, std::vector<std::string> more = {}) {
  more.insert(more.end(), kCircle.begin(), kCircle.end());
  more.push_back("arm.urdf=" + urdf);
  return draw_scenario("bowl-sine", more);
}

// The limits are those promised for the standard drawings.
void expect_drawn(const Figures& figures) {
  EXPECT_GT(figures["contact_fraction"], 0.999);
  EXPECT_GT(figures["coverage"], 0.999);
  EXPECT_LT(figures["ink_error_rms"], 0.1);  // [mm]
  EXPECT_NEAR(figures["force_mean"], 5.0, 0.05);
}

// Without a null space nothing holds the posture but the task.
TEST_F(ArmsTest, SixJointsDraw) { expect_drawn(draw_circle(six())); }

TEST_F(ArmsTest, EightJointsDraw) { expect_drawn(draw_circle(eight())); }

TEST_F(ArmsTest, EightJointsDrawWithGivenPostures) {
  expect_drawn(draw_circle(eight(), {"arm.posture_seed=[0, 0.6, 0, -1.4, 0, 1.1, 0, 0.1]",
                                     "control.null_stiffness=[5, 10, 10, 10, 10, 10, 10, 20]"}));
}

TEST_F(ArmsTest, SettingsPerJointNameArmAndCount) {
  for (const std::string name : {"arm.posture_seed", "arm.q_0", "control.null_stiffness"}) {
    const std::string error =
        refusal({"arm.urdf=" + eight(), name + "=[0.1, 0.2, 0.3, 0.1, 0.2, 0.3, 0.1]"});
    EXPECT_THAT(error, AllOf(HasSubstr("--set " + name), HasSubstr(name + " has 7 entries"),
                             HasSubstr("eight.urdf has 8 joints")));
    EXPECT_EQ(error.find("joints"), error.rfind("joints")) << error;
  }
  EXPECT_THAT(refusal({"control.null_stiffness=[1]"}),
              AllOf(HasSubstr("has 1 entry"), HasSubstr("iiwa14_pen.urdf has 7 joints")));
}

TEST_F(ArmsTest, PosturesBeyondTheJointRangesNameTheJoint) {
  for (const std::string name : {"arm.posture_seed", "arm.q_0"})
    EXPECT_THAT(
        refusal({name + "=[0, 0.6, 0, -1.4, 0, 2.5, 0]"}),
        AllOf(HasSubstr("--set " + name), HasSubstr("2.5 rad is beyond the range of joint 6"),
              HasSubstr("-2.094 to 2.094 rad")));
  const std::string bent = changed(iiwa_urdf(), "</robot>", "</robot>",
                                   "<impedraw rest_posture=\"0 0.6 0 -4 0 1.1 0\"/></robot>");
  EXPECT_THAT(refusal({"arm.urdf=" + write("bent.urdf", bent).string()}),
              HasSubstr("bent.urdf: rest_posture: -4 rad is beyond the range of joint 4"));
}

TEST_F(ArmsTest, AStartOutOfReachIsNamedForAnyArm) {
  EXPECT_THAT(refusal({"arm.urdf=" + six(), "arm.start=[2, 0, 0.5]"}),
              HasSubstr("out of the arm's reach"));
}

}  // namespace
}  // namespace impedraw
