// The controller alone: takes the state of an arm and returns the joint torque with its terms. The
// arm is fictitious and at rest.
#include <cstdio>

#include "impedraw/control/impedance.h"

int main() {
  using namespace impedraw;
  ArmTerms arm(7);  // seven joints; compute these terms from your arm's dynamics at each step
  arm.M.diagonal() << 4.0, 4.0, 1.5, 1.5, 0.3, 0.2, 0.05;
  arm.g << 0.0, -60.0, 0.0, 25.0, 0.5, -1.0, 0.0;
  arm.J << 0.0, 0.1, 0.0, 0.3, 0.0, -0.2, 0.0,  //
      0.6, 0.0, 0.4, 0.0, 0.1, 0.0, 0.0,        //
      0.0, -0.6, 0.0, 0.5, 0.0, 0.1, 0.0,       //
      0.0, 0.0, -0.5, 0.0, 0.8, 0.0, 0.1,       //
      0.0, 1.0, 0.0, -1.0, 0.0, -1.0, 0.0,      //
      1.0, 0.0, 0.8, 0.0, -0.5, 0.0, -1.0;
  arm.X_WE.p = {0.6, 0.0, 0.1};
  arm.X_WE.R.diagonal() << 1.0, -1.0, -1.0;  // the pen points down

  ImpedanceSettings settings;  // each has a unit and a default
  settings.normal_force = 5.0;
  settings.null_space.q_0 = 0.2 * Eigen::VectorXd::Unit(7, 2);  // rest position of the third joint
  settings.observer.enabled = false;  // this arm does not move under torque
  ImpedanceController controller(settings, 7);

  TipReference reference;
  reference.p_WD = arm.X_WE.p + Eigen::Vector3d(1e-3, 0.0, 0.0);  // 1 mm further on
  reference.pen_down = true;
  const SurfaceEstimate surface{SurfaceStatus::ok, Eigen::Vector3d::UnitZ(),
                                0.0};          // at the tip, facing up
  const Wrench F_ext = 5.0 * Wrench::Unit(2);  // the contact force on the pen

  const ImpedanceTorque* out = nullptr;
  for (int i = 0; i < 500; ++i)
    // one step per millisecond: the normal force ramps up
    out = &controller.step(arm, reference, surface, F_ext);
  std::printf("%s, all well: %s\n", kContactModeNames[static_cast<int>(out->mode)].data(),
              out->status.ok() ? "yes" : "no");
  std::printf("%-18s", "torque [Nm]");
  for (const double tau : out->tau) std::printf("%9.3f", tau);
  for (int term = 0; term < kTorqueTerms; ++term) {
    std::printf("\n  %-16s", kTorqueTermNames[term].data());
    for (const double tau : out->terms.col(term)) std::printf("%9.3f", tau);
  }
  std::printf("\n");
}
