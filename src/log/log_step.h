// One control step as far as metrics, plots and a resumed run need it. A reduced log holds all of
// them under /every_step; of a full log they are worked out from its rows. Both go through the
// functions below, so that both give the same numbers to the last bit.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/log/log.h"

namespace impedraw {

struct LogStep {
  double time = 0.0;
  double force = 0.0;                                   // contact force · outward normal [N]
  Eigen::Vector3d contact_point = LogRow::no_vector();  // [m]; NaN out of contact
  double tilt = LogRow::kNone;                          // [rad]
  double normal_error = LogRow::kNone;                  // [rad]
  double push = 0.0;                                    // [N]
  // largest |torque| of a joint against its limit; a float's precision is kept
  double torque_share = 0.0;
  // smallest distance of a joint to its limits, of this step and all before it [rad]
  double joint_margin = std::numeric_limits<double>::infinity();
  int clipped = 0;  // 1: a joint's torque was
  int mode = 0;
  int stroke = -1;
  double stroke_along = LogRow::kNone;  // [m]
  // measured wrench's force · the controller's own normal [N]; NaN where it had no estimate; a
  // float's precision is kept
  double felt_force = LogRow::kNone;
  double step_time = 0.0;  // [s]; a float's precision is kept
};

double normal_force(const Eigen::Vector3d& force, const Eigen::Vector3d& normal);  // 0: no contact

// Both NaN but on pen-down ink: a stroke, and `force` = normal_force() that writes.
double tilt_angle(const Eigen::Quaterniond& tip, const Eigen::Vector3d& contact_normal, int stroke,
                  double force);
double normal_error_angle(const Eigen::Vector3d& surface_normal, double surface_distance,
                          const Eigen::Vector3d& contact_normal, int stroke, double force);

using JointReference = Eigen::Ref<const Eigen::VectorXd>;
double torque_share(const JointReference& torque, const JointReference& limit);
double joint_margin(const JointReference& position, const JointReference& lower,
                    const JointReference& upper);
bool is_clipped(const JointReference& before_limits, const JointReference& torque);

// Works the steps of a run out while it lasts.
class LogSteps {
 public:
  explicit LogSteps(const RunLogHeader& header);
  // The smallest of all steps before, where the log goes on.
  void set_joint_margin(double before) { joint_margin_ = before; }

  LogStep measure(const LogRow& row) noexcept;

 private:
  JointVector lower_, upper_, torque_limit_;
  std::vector<std::size_t> terms_;  // in alphabetical order of their names, as a log lists them
  double joint_margin_ = std::numeric_limits<double>::infinity();
};

}  // namespace impedraw
