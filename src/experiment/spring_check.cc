#include "impedraw/experiment/spring_check.h"

#include <algorithm>

#include <fmt/format.h>

#include "impedraw/simulation/describe_world.h"
#include "impedraw/simulation/joint_springs.h"

namespace impedraw {

namespace {

JointSpringSettings springs_as_stated(const ArmSettings& s, const ArmModel& arm, double softer,
                                      double faster) {
  constexpr double kRotors = 10.0;  // true ones over what a torque loop leaves of them
  JointSpringSettings springs;
  for (const double K : s.joint_stiffness) springs.stiffness.push_back(K / softer);
  springs.loop_bandwidth = faster * s.torque_bandwidth;
  for (const double B : arm.rotor_inertia())
    springs.rotor_inertia.push_back(
        std::min(kSpringRotorRange.highest, s.torque_bandwidth > 0.0 ? kRotors * B : B));
  return springs;
}

// Nothing takes the springs' deflection off readings of the motors' side.
void refuse_motor_readings(const Scenario& s, ArmModel arm, const Eigen::VectorXd& q,
                           const SettingErrors& setting_errors) {
  constexpr double kMost = 2e-4;  // by which weight may shift the tip [m]
  if (s.arm.driver != ArmDriver::sim || !s.world.joint_spring.on()) return;
  const JointSpringValues springs = joint_spring_values(s.world.joint_spring, arm.joints());
  if (!springs.motor_side) return;
  ArmTerms terms(arm.joints());
  arm.compute(q, JointVector::Zero(arm.joints()), &terms);
  const JointVector bent = terms.g.cwiseQuotient(springs.stiffness);
  const double off = (terms.J.topRows<3>() * bent).norm();
  if (off <= kMost) return;
  setting_errors.raise(
      {"world.joint_spring.reading", "world.joint_spring"},
      fmt::format(
          "world.joint_spring.reading: motor: the arm's weight bends joints by up to {:.2g} "
          "mrad behind what is read, which puts the tip {:.2g} mm off, and nothing takes it "
          "off the readings; valid is link, or springs that bend it by {:.1g} mm at most",
          1e3 * bent.cwiseAbs().maxCoeff(), 1e3 * off, 1e3 * kMost));
}

}  // namespace

void bear_joint_springs(const Scenario& s, const ArmModel& arm, const Eigen::VectorXd& start_q,
                        const Eigen::VectorXd& q, ControlSetup* setup,
                        std::vector<std::string>* notes, const SettingErrors& setting_errors) {
  constexpr double kStep = 0.8;       // from one bandwidth to the next
  constexpr double kLeast = 5.0;      // that is of use against friction [rad/s]
  constexpr double kOff = 1.1;        // true springs and loop from what is said of them
  constexpr double kMostAfter = 0.4;  // of a kick that may be left after 0.8 s
  refuse_motor_readings(s, arm, q, setting_errors);
  if (s.arm.joint_stiffness.empty()) return;
  const double delay =
      s.arm.driver == ArmDriver::sim ? s.control.torque_delay.value_or(0.0) : s.arm.delay;
  double& bandwidth = setup->impedance.observer.bandwidth;
  const double asked = bandwidth;
  const auto calm = [&](double softer, double faster) {
    const JointSpringSettings springs = springs_as_stated(s.arm, arm, softer, faster);
    const Eigen::VectorXd links = -arm.rotor_inertia();  // the rotors are before the springs
    return kick_left({*setup, start_q, delay, springs, true}, arm, links) <= kMostAfter &&
           kick_left({*setup, q, delay, springs, false}, arm, links) <= kMostAfter;
  };
  setting_errors.locate({"arm.joint_stiffness", "arm.rotor_inertia"}, [&] {
    joint_spring_values(springs_as_stated(s.arm, arm, 1.0, 1.0), arm.joints());
  });
  while (bandwidth >= kLeast &&
         !(calm(1.0, 1.0) && calm(kOff, kOff) && calm(1.0 / kOff, 1.0 / kOff)))
    bandwidth *= kStep;
  const std::string law =
      fmt::format("with joints of {:.3g} Nm/rad and a torque loop of {:.3g} rad/s",
                  s.arm.joint_stiffness[0], s.arm.torque_bandwidth);
  if (bandwidth < kLeast)
    setting_errors.raise(
        {"arm.torque_bandwidth", "arm.joint_stiffness", "control"},
        fmt::format("arm.joint_stiffness: {}, the law does not calm down after a kick, with any "
                    "bandwidth of its observer; valid is a faster torque loop, or less of "
                    "control.stiffness_tangent, rotational_stiffness_tangent and damping_ratio",
                    law));
  if (bandwidth < asked)
    notes->push_back(fmt::format("{}, the law bears an observer of {:.3g} rad/s instead of {:.3g}",
                                 law, bandwidth, asked));
}

}  // namespace impedraw
