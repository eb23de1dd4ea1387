// The arms of models/arms with a pen draw on the bowl where --place auto puts it, with the default
// settings and no gain of their own.
#include <cmath>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>

#include "impedraw/arm/arm_model.h"
#include "impedraw/arm/arm_notes.h"
#include "impedraw/common/errors.h"
#include "impedraw/experiment/place_auto.h"
#include "run/drawn_scenario.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

std::string text_of_arm(const std::string& name) {
  std::ostringstream all;
  all << std::ifstream("models/arms/" + name + ".urdf").rdbuf();
  return all.str();
}

class DescribedArms : public ScratchFolder, public ::testing::WithParamInterface<const char*> {
 protected:
  std::string with_pen(const PenOnFlange& pen = {}) const {
    return write("arm.urdf", urdf_with_pen(text_of_arm(GetParam()), pen)).string();
  }

  void draw(const std::string& scenario, const std::string& text = "") const {
    DrawOptions options;
    options.scenario = "scenarios/" + scenario + ".yaml";
    options.text = text;
    options.assignments = {"arm.urdf=" + with_pen()};
    Places places;
    const Scenario given = resolve(options, &places);
    const PlacedCanvas placed = place_automatically(given, places);
    ASSERT_TRUE(placed.passes);
    Prepared experiment = prepare(placed.scenario, places);
    const auto log = folder_ / "run.h5";
    const RunOutcome outcome = run(experiment, log, 0.0);
    EXPECT_EQ(outcome.end, RunEnd::finished) << outcome.cause;
    const Metrics metrics = compute_metrics(read_run(log));
    EXPECT_GE(metrics.contact_fraction.or_nan(), 0.999);
    EXPECT_LE(metrics.ink_error_rms.or_nan(), 0.1);
    EXPECT_NEAR(metrics.force_mean.or_nan(), 5.0, 0.05);
    EXPECT_LE(metrics.force_sd.or_nan(), 0.1);
  }
};

TEST_P(DescribedArms, DrawTheSine) { draw("bowl-sine"); }

TEST_P(DescribedArms, DrawTheMAndText) {
  if (seeds(0, 1) == 0) GTEST_SKIP() << "with IMPEDRAW_LONG";
  draw("bowl-m");
  draw("bowl-sine", "robot");
}

// The rod's mass and length, by the forces that it takes to hold the arm and by the tip's place.
TEST_P(DescribedArms, TheToolHasItsLengthAndMass) {
  const PenOnFlange light{0.12, 0.05}, heavy{0.2, 0.55};
  ArmModel before(with_pen(light));
  const JointVector q = Eigen::Map<const Eigen::VectorXd>(
      before.rest_posture().data(), static_cast<Eigen::Index>(before.rest_posture().size()));
  ASSERT_EQ(q.size(), before.joints());
  const Pose X_light = before.tip_pose(q);
  ArmTerms terms(before.joints());
  before.compute(q, JointVector::Zero(q.size()), &terms);
  const JointVector g_light = terms.g;
  const Eigen::MatrixXd J_tip = terms.J;
  ArmModel after(with_pen(heavy));
  const Pose X_heavy = after.tip_pose(q);
  after.compute(q, JointVector::Zero(q.size()), &terms);
  const Eigen::Vector3d z = X_light.R.col(2);
  EXPECT_LT((X_heavy.p - X_light.p - 0.08 * z).norm(), 1e-9);
  // Weights m g at half of each rod, with the tip's Jacobian carried there.
  const auto weight = [&](const PenOnFlange& pen) -> JointVector {
    const Eigen::Vector3d r = (0.5 * pen.length - 0.12) * z;
    JointVector tau(q.size());
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      const Eigen::Vector3d v = J_tip.col(j).head<3>(), w = J_tip.col(j).tail<3>();
      tau[j] = pen.mass * 9.81 * (v + w.cross(r)).z();
    }
    return tau;
  };
  EXPECT_LT((terms.g - g_light - weight(heavy) + weight(light)).cwiseAbs().maxCoeff(), 5e-3);
}

INSTANTIATE_TEST_SUITE_P(Arms, DescribedArms,
                         ::testing::Values("fr3", "gen3", "iiwa14", "iiwa7", "panda", "ur5e"),
                         [](const auto& arm) { return std::string(arm.param); });

class ArmNotesTest : public ScratchFolder {};

TEST_F(ArmNotesTest, AreReadAndChecked) {
  const std::string bare = text_of_arm("fr3"), pen = urdf_with_pen(bare, {});
  EXPECT_EQ(ArmModel(write("fr3.urdf", pen)).limits().torque_rate, 1000.0);
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = pen;
    return write("changed.urdf", text.replace(text.find(from), from.size(), to));
  };
  EXPECT_THROW(ArmModel(changed("torque_rate=\"1000\"", "torque_rate=\"-1\"")), InputError);
  EXPECT_THROW(ArmModel(changed("rest_posture=\"0 ", "rest_posture=\"")), InputError);
  EXPECT_THROW(ArmModel(changed("rest_posture=\"0 ", "rest_posture=\"zero ")), InputError);
  EXPECT_TRUE(std::isinf(ArmModel("models/iiwa14_pen.urdf").limits().torque_rate));
}

TEST_F(ArmNotesTest, AToolNeedsAFlangeAndNoOtherTool) {
  EXPECT_THROW(urdf_with_pen("<robot name=\"r\"></robot>", {}), InputError);
  EXPECT_THROW(urdf_with_pen(urdf_with_pen(text_of_arm("ur5e"), {}), {}), InputError);
}

}  // namespace
}  // namespace impedraw
