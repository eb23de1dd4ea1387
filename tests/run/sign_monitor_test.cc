// A mass of 4 kg on six joints along the axes of W, driven by torques and pushed at the tip: what
// the monitor says of signs that are wrong, and of those that are right.
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/run/monitors/sign_monitor.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

struct Plant {
  double moves = 1.0;                // of the torque that is commanded
  double acts = 1.0;                 // of the wrench that is measured
  double torque = 0.0, force = 0.0;  // amplitudes, of joint 2 and along z [Nm], [N]
  double frequency = 15.0;           // [Hz]
  bool one_sided = false;            // the force only pulls at the tip, or only pushes
  Eigen::Index axis = 2;             // of the force
  double friction = 0.0;             // believed coefficient at the tip

  // What the monitor says first.
  Verdict judged() const {
    constexpr double kMass = 4.0, kStep = 1e-3;
    ImpedanceSettings settings;
    settings.friction.coefficient = friction;
    SignMonitor monitor(settings, JointVector::Constant(6, 100.0));
    OperationalSpace space(settings.operational_space);
    ArmTerms arm(6);
    arm.M = kMass * JointMatrix::Identity(6, 6);
    arm.J.setIdentity(6, 6);
    arm.Cv.setZero(6);
    arm.g.setConstant(6, 3.0);
    arm.q.setZero(6);
    arm.v.setConstant(6, 1e-3);
    Verdict said;
    Vector6 F = Vector6::Zero();
    for (int i = 0; i < 1000 && !said; ++i) {
      // It grows, as pushes do that nothing answers. The weight changes beside it.
      const double t = i * kStep, phase = 2.0 * std::numbers::pi * frequency * t;
      arm.g[1] = 3.0 + 20.0 * std::cos(phase);
      const double wave =
          std::min(1.0, 2.0 * t) * (one_sided ? 0.5 - 0.5 * std::cos(phase) : std::sin(phase));
      JointVector tau = arm.g;
      tau[1] += torque * wave;
      space.update(arm);
      said = monitor.update(arm, &space, F, tau);
      F[axis] = force * wave;  // over the step that follows
      arm.v += kStep / kMass * (moves * (tau - arm.g) + acts * F);
      arm.v[0] += 1e-6;  // rest teaches nothing
    }
    return said;
  }
};

TEST(SignMonitor, NamesAJointThatTurnsAgainstItsTorque) {
  const Verdict said = Plant{.moves = -1.0, .torque = 10.0}.judged();
  EXPECT_EQ(said.severity, Severity::lose);
  EXPECT_THAT(said.cause, HasSubstr("joint 2 turns against its torque"));
  EXPECT_FALSE((Plant{.torque = 10.0}.judged()));
  EXPECT_FALSE((Plant{.moves = 0.5, .torque = 10.0}.judged())) << "twice the modelled mass";
  EXPECT_FALSE((Plant{.moves = -1.0, .torque = 2.0}.judged())) << "below 2 Nm, RMS";
  EXPECT_FALSE((Plant{.moves = -1.0, .torque = 10.0, .frequency = 2.0}.judged()))
      << "a shove on the elbow looks like that";
}

TEST(SignMonitor, NamesAWrenchWhoseSignIsWrong) {
  const Verdict said = Plant{.acts = -1.0, .force = 10.0}.judged();
  EXPECT_EQ(said.severity, Severity::damp);
  EXPECT_THAT(said.cause, HasSubstr("against the measured wrench, whose sign is wrong, along the "
                                    "tip's z"));
  EXPECT_FALSE((Plant{.force = 10.0}.judged()));
}

// No surface pulls: a small pull along the pen is enough.
TEST(SignMonitor, NamesASmallPullAgainstWhichTheArmMoves) {
  EXPECT_THAT((Plant{.acts = -1.0, .force = 4.0, .one_sided = true}.judged().cause),
              HasSubstr("whose sign is wrong, along the tip's z"));
  EXPECT_FALSE((Plant{.acts = -1.0, .force = -4.0, .one_sided = true}.judged())) << "a push";
  EXPECT_FALSE((Plant{.acts = -1.0, .force = 2.0, .one_sided = true}.judged())) << "below 2.5 N";
}

// Across its normal, a cut pushes harder than it does along it, and turns with the line.
TEST(SignMonitor, LeavesACutItsForcesAcross) {
  Plant plant{.acts = -1.0, .force = 10.0, .axis = 1};
  EXPECT_THAT(plant.judged().cause, HasSubstr("whose sign is wrong, along the tip's y"));
  plant.friction = 2.0;
  EXPECT_FALSE(plant.judged());
  plant.axis = 2;
  EXPECT_THAT(plant.judged().cause, HasSubstr("whose sign is wrong, along the tip's z"));
}

TEST(SignMonitor, NamesAWrenchThatIsMadeUp) {
  const Verdict said = Plant{.acts = 0.0, .force = 25.0}.judged();
  EXPECT_EQ(said.severity, Severity::damp);
  EXPECT_THAT(said.cause, HasSubstr("as if the measured wrench did not act along the tip's z"));
  // Above 9 N, RMS, but not less a tenth, for masses that may be wrong.
  EXPECT_FALSE((Plant{.acts = 0.0, .force = 13.0}.judged()));
  EXPECT_FALSE((Plant{.acts = 0.5, .force = 25.0}.judged()));
}

}  // namespace
}  // namespace impedraw
