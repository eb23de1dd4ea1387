// With every error on, a step of the world and a sample of the sensor allocate nothing. malloc is
// hooked.
#include <cstdlib>

#include <gtest/gtest.h>

#include "allocations.h"
#include "impedraw/simulation/joint_sensor.h"
#include "impedraw/simulation/wrench_sensor.h"
#include "worlds.h"

namespace impedraw {
namespace {

using namespace testing_worlds;

TEST(NoAllocation, TheHookCatchesOne) {
  EXPECT_GT(allocations_in([] { free(std::malloc(10)); }), 0);
  EXPECT_GT(allocations_in([] {
              Eigen::MatrixXd m(3, 3);
              asm volatile("" : : "r"(m.data()) : "memory");
            }),
            0);
}

TEST(NoAllocation, AStepWithEveryErrorAndTheSensorsMakesNone) {
  WorldSettings settings = with({.mass_scale = 1.05,
                                 .centre_shift = 0.003,
                                 .viscous_friction = 0.5,
                                 .stiction = 1.5,
                                 .load_friction = 0.01,
                                 .friction_ripple = 0.1,
                                 .torque_ripple = 0.1,
                                 .torque_quantum = 0.01,
                                 .loop_delay = 2e-3,
                                 .pen_longer = 1e-3});
  settings.joint_friction = 0.5;
  settings.joint_spring.arm = SpringsOf::iiwa;
  settings.tip.friction_change = 0.1;
  settings.tip.wear = 1e-4;
  settings.flange_sensor = true;
  settings.substeps = 3;
  World probe(kArm, nullptr, settings);
  probe.set_state(working_posture(), JointVector::Zero(7));
  const Canvas canvas = plane_under(probe.state().X_WE.p, 0.3e-3);
  World world(kArm, &canvas, settings);
  CanvasMotionSettings motion;
  motion.sway = {1e-4, 0.0, 1e-4};
  motion.roll = 1e-3;
  motion.jolts = 1e-5;
  world.move_canvas(CanvasMotion(motion));
  world.set_state(working_posture(), JointVector::Zero(7));
  WrenchSensor sensor(WrenchSensorSettings::realistic(), settings.dt, 1);
  JointSensor joints({.quantum = 1e-5,
                      .position_noise = 1e-5,
                      .velocity_noise = 1e-3,
                      .delay = 2e-3,
                      .velocity = VelocityReading::difference},
                     7, settings.dt, 1);
  const int elbow = world.link("link_4").value();
  const JointVector tau = world.terms().bias;
  const Vector6 push = Vector6::Ones();
  int touching = 0;
  EXPECT_EQ(allocations_in([&] {
              for (int i = 0; i < 20; ++i) {
                world.push_link(elbow, Eigen::Vector3d::UnitY());
                touching += world.step(tau, push).touching;
                joints.sample(world.state().q, world.state().v);
                sensor.sample(world.flange_wrench());
              }
            }),
            0);
  EXPECT_GT(touching, 0);
}

}  // namespace
}  // namespace impedraw
