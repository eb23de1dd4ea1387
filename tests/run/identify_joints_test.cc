// Delays and frictions that are put into the simulated arm, and what is found.
#include "impedraw/run/identify_joints.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "impedraw/experiment/prepare.h"
#include "impedraw/run/simulated_arm.h"

namespace impedraw {
namespace {

Prepared prepared(const std::vector<std::string>& assignments) {
  DrawOptions options;
  options.scenario = "scenarios/bowl-sine.yaml";
  options.assignments = assignments;
  return prepare(resolve(options));
}

TEST(IdentifyDelay, TheDelayThatWasPutInIsFound) {
  for (const int steps : {0, 1, 3, 8}) {
    SCOPED_TRACE(steps);
    Prepared e = prepared(
        {"world.errors.loop_delay=" + std::to_string(1e-3 * steps), "world.joint_friction=0.3"});
    SimulatedArm arm(e, e.belief.start_q, Disturbances());
    const LoopDelay found = identify_delay(e.belief.arm, arm);
    EXPECT_NEAR(found.delay, 1e-3 * steps, 1e-9);
    EXPECT_GT(found.explained, 0.5);
  }
}

TEST(IdentifyFriction, TheFrictionThatWasPutInIsFound) {
  Prepared e = prepared({"world.joint_friction=0.8", "world.errors.viscous_friction=1.5",
                         "world.errors.loop_delay=0.001"});
  SimulatedArm arm(e, e.belief.start_q, Disturbances());
  const std::vector<JointFriction> found = identify_friction(e.belief.arm, arm, 1e-3);
  ASSERT_EQ(found.size(), 7u);
  for (std::size_t j = 0; j < 7; ++j) {
    SCOPED_TRACE(j);
    EXPECT_NEAR(found[j].coulomb, 0.8, 0.1);
    EXPECT_NEAR(found[j].viscous, 1.5, 0.3);
  }
}

// With velocities that are filtered and positions that are rounded: the defect was a fit on the
// filter's lag.
TEST(IdentifyFriction, TheRotorsThatTheModelLacksAreFound) {
  const std::vector<double> rotors = {0.3, 0.3, 0.2, 0.2, 0.1, 0.1, 0.05};
  Prepared e = prepared(
      {"world.errors.rotor_inertia=[0.3,0.3,0.2,0.2,0.1,0.1,0.05]", "world.joint_friction=1",
       "control.check_rotors=false", "world.joint_sensor.velocity=difference",
       "world.joint_sensor.velocity_bandwidth=250", "world.joint_sensor.quantum=1e-5"});
  SimulatedArm arm(e, e.belief.start_q, Disturbances());
  const std::vector<JointFriction> found = identify_friction(e.belief.arm, arm, 0.0);
  for (std::size_t j = 0; j < 7; ++j) {
    SCOPED_TRACE(j);
    EXPECT_NEAR(found[j].inertia, rotors[j], 0.01 + 0.1 * rotors[j]);
    EXPECT_LT(found[j].inertia_error, 0.05);
  }
}

}  // namespace
}  // namespace impedraw
