// A controller whose stiffness and force are changed while it runs.
#include <gtest/gtest.h>

#include "arm_fixture.h"
#include "free_arm.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using namespace testing_arm;

TEST(Retune, GivesTheControllerThatWouldHaveBeenMade) {
  ArmModel arm(kArm);
  for (const InertiaShaping inertia : {InertiaShaping::shaped, InertiaShaping::natural}) {
    ImpedanceSettings before = shaped_settings(arm), after;
    before.inertia = inertia;
    after = before;
    after.stiffness = {{1200.0, 900.0}, {60.0, 0.0}};
    after.normal_force = 8.0;
    ImpedanceController retuned(before, 7), made(after, 7);
    retuned.retune(after.stiffness, after.normal_force);
    std::mt19937 rng(1);
    for (int i = 0; i < 20; ++i) {
      const ArmTerms terms = random_terms(arm, rng);
      TipReference reference;
      reference.p_WD = terms.X_WE.p + Eigen::Vector3d(1e-3, 2e-3, 0.0);
      reference.n_WD = -terms.X_WE.R.col(2);
      reference.pen_down = true;
      const SurfaceEstimate surface{SurfaceStatus::ok, reference.n_WD, 1e-4};
      const Wrench F_ext = Wrench::Constant(0.5);
      EXPECT_EQ(retuned.step(terms, reference, surface, F_ext).tau,
                made.step(terms, reference, surface, F_ext).tau)
          << "step " << i;
    }
  }
}

TEST(Retune, RefusesAndKeepsWhatItHad) {
  ArmModel arm(kArm);
  const ImpedanceSettings s = shaped_settings(arm);
  ImpedanceController refused(s, 7), other(s, 7);
  EXPECT_THROW(refused.retune(s.stiffness, 99.0), InputError);
  EXPECT_THROW(refused.retune({{1e6, 0.0}, {1.0, 1.0}}, 5.0), InputError);
  std::mt19937 rng(2);
  const ArmTerms terms = random_terms(arm, rng);
  TipReference reference;
  reference.p_WD = terms.X_WE.p + Eigen::Vector3d(1e-3, 0.0, 0.0);
  reference.n_WD = -terms.X_WE.R.col(2);
  EXPECT_EQ(refused.step(terms, reference, {}, Wrench::Zero()).tau,
            other.step(terms, reference, {}, Wrench::Zero()).tau);
}

TEST(Retune, ChangesTheForceInContact) {
  ArmModel arm(kArm);
  ImpedanceSettings s = shaped_settings(arm);
  PlaneArm plane(s, 0.2);
  plane.draw(1500);
  const auto force = [&] {
    double mean = 0.0;
    for (int i = 0; i < 500; ++i) {
      plane.step();
      mean += plane.n_W.dot(plane.free.F_ext.head<3>()) / 500.0;
    }
    return mean;
  };
  EXPECT_NEAR(force(), s.normal_force, 0.1);
  plane.free.controller.retune(s.stiffness, 9.0);
  force();
  EXPECT_NEAR(force(), 9.0, 0.2);
}

}  // namespace
}  // namespace impedraw
