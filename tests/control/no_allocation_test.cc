// A step allocates nothing. malloc is hooked, so that every allocation counts: new, Eigen's aligned
// blocks, or a library's.
#include <cmath>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "allocations.h"
#include "arm_fixture.h"
#include "impedraw/perception/normals.h"

namespace impedraw {
namespace {

using namespace testing_arm;

TEST(NoAllocation, TheHookCatchesOne) {
  EXPECT_GT(allocations_in([] { free(std::malloc(10)); }), 0);
  EXPECT_GT(allocations_in([] {
              std::vector<double> v(10);
              asm volatile("" : : "r"(v.data()) : "memory");
            }),
            0);
  EXPECT_GT(allocations_in([] {
              Eigen::MatrixXd m(3, 3);
              asm volatile("" : : "r"(m.data()) : "memory");
            }),
            0);
  EXPECT_EQ(allocations_in([] {}), 0);
}

TEST(NoAllocation, AFreshNormalMakesNone) {
  PointCloud cloud;
  cloud.eyes.push_back({0.0, 0.0, 1.0});
  for (int i = 0; i < 60; ++i) {
    for (int k = 0; k < 60; ++k) {
      cloud.points.push_back({0.003 * i, 0.003 * k, 0.0001 * ((i * 7 + k * 13) % 10)});
      cloud.camera.push_back(0);
    }
  }
  const SurfaceEstimator estimator(cloud);
  int known = 0;
  const int made = allocations_in([&] {
    for (int i = 0; i < 500; ++i)
      known += estimator.estimate({0.0005 * i, 0.09, 0.002}).status == SurfaceStatus::ok;
  });
  EXPECT_EQ(made, 0);
  EXPECT_GT(known, 100);
}

TEST(NoAllocation, AStepMakesNone) {
  ArmModel arm(kArm);
  std::mt19937 rng(2);
  for (const bool natural : {false, true}) {
    ImpedanceController controller(natural ? natural_settings(arm) : shaped_settings(arm), 7);
    ArmTerms terms = random_terms(arm, rng);
    const JointVector q = terms.q, v = terms.v;
    TipReference reference;
    reference.p_WD = terms.X_WE.p;
    SurfaceEstimate surface;
    surface.status = SurfaceStatus::ok;
    surface.distance = 0.0;
    Wrench F = Wrench::Zero();
    const int made = allocations_in([&] {
      for (int i = 0; i < 600; ++i) {
        reference.pen_down = i > 100 && i < 500;  // through every mode
        surface.distance = i > 520 ? 0.01 : 0.0;
        surface.status = i > 300 && i < 310 ? SurfaceStatus::too_few : SurfaceStatus::ok;
        F[2] = i > 110 ? 5.0 : 0.0;
        arm.compute(q, v, &terms);
        controller.step(terms, reference, surface, F);
      }
      // and through the release of a singular posture
      JointVector stretched = JointVector::Zero(7);
      arm.compute(stretched, v, &terms);
      controller.step(terms, reference, surface, F);
    });
    EXPECT_EQ(made, 0) << (natural ? "natural" : "shaped");
  }
}

// The other tasks of a step: observer, scaled inertia, limits, invalid and stale
// inputs.
TEST(NoAllocation, AStepInTroubleMakesNone) {
  ArmModel arm(kArm);
  std::mt19937 rng(3);
  for (const InertiaShaping inertia : {InertiaShaping::natural, InertiaShaping::scaled,
                                       InertiaShaping::shaped, InertiaShaping::light_normal}) {
    ImpedanceSettings s = shaped_settings(arm);
    s.inertia = inertia;
    s.inertia_scale = 2.0;
    s.timing.wrench_delay = 4e-3;
    s.stability_check.contact_stiffness_max = 1e3;
    s.timing.loop_delay = 3e-3;
    s.force_integral.enabled = true;
    s.limits.torque = 0.4 * s.limits.torque;
    s.limits.torque_rate = Eigen::VectorXd::Constant(7, 500.0);
    s.limits.joint_speed = 0.1 * arm.limits().speed;
    s.joint_range.lower = working_posture() - JointVector::Constant(7, 0.2);
    s.joint_range.upper = working_posture() + JointVector::Constant(7, 0.2);
    ASSERT_TRUE(s.observer.enabled);
    ImpedanceController controller(s, 7);
    ArmTerms terms = random_terms(arm, rng);
    const JointVector q = terms.q;
    JointVector v = terms.v;
    TipReference reference;
    SurfaceEstimate surface;
    surface.status = SurfaceStatus::ok;
    surface.distance = 0.0;
    Wrench F = 3.0 * Wrench::Ones();
    int limited = 0, observed = 0, bad = 0, stale_state = 0, stale_wrench = 0, retreats = 0,
        fast = 0;
    const int made = allocations_in([&] {
      for (int i = 0; i < 1000; ++i) {
        v[1] = 0.01 * (i % 3);  // an unexplained change of momentum
        arm.compute(q, v, &terms);
        reference.p_WD = terms.X_WE.p;
        if (i % 50 > 40) reference.p_WD.y() += 0.2;
        if (i % 50 > 45)
          reference.a_WD.x() = 1e3;
        else
          reference.a_WD.x() = 0.0;
        reference.pen_down = i % 200 > 20;
        if (i % 97 == 0) terms.v[3] = std::nan("");
        InputAges ages;
        if (i % 89 == 0) ages.state = 1.0;
        if (i % 200 > 150) ages.wrench = 1.0;
        const ImpedanceTorque& out = controller.step(terms, reference, surface, F, ages);
        limited += out.status.torque_limited;
        observed += out.terms.col(kDisturbance).norm() > 0.1;
        bad += out.status.bad_input;
        stale_state += out.status.stale_state;
        stale_wrench += out.status.stale_wrench;
        retreats += out.mode == ContactMode::retreat;
        fast += out.status.speed_limited;
      }
      controller.reset();
    });
    EXPECT_EQ(made, 0) << static_cast<int>(inertia);
    for (const int count : {limited, observed, bad, stale_state, stale_wrench, retreats, fast})
      EXPECT_GT(count, 5) << "not all of it was met";
  }
}

}  // namespace
}  // namespace impedraw
