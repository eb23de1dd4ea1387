// The quantities of one control step that metrics, plots and a resumed run need. A reduced log
// holds them for every step under /every_step. For a full log they are computed from its rows. Both
// use the functions below, so the numbers are bitwise equal.
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
  double tracking_error = LogRow::kNone;                // [m]
  double push = 0.0;                                    // [N]
  // largest ratio of a joint's |torque| to its limit; stored in float precision
  double torque_share = 0.0;
  // smallest distance of a joint to its limits, in this step and all before it [rad]
  double joint_margin = std::numeric_limits<double>::infinity();
  // largest ratio of a joint's |speed| to its limit, in this step and all before it; NaN: no limits
  double joint_speed_share = LogRow::kNone;
  int clipped = 0;  // 1: a joint's torque was clipped
  int mode = 0;
  int stroke = -1;
  double stroke_along = LogRow::kNone;  // [m]
  // measured force · the controller's estimated normal [N]; NaN without an estimate; stored in
  // float precision
  double felt_force = LogRow::kNone;
  double time_scale = 1.0;  // of the plan's clock; stored in float precision
  double step_time = 0.0;   // [s]; stored in float precision
};

// 0: no contact; NaN: not known, as the force is NaN.
double normal_force(const Eigen::Vector3d& force, const Eigen::Vector3d& normal);

// Angles [rad]. Both are NaN except on pen-down ink: a stroke is planned and `force` =
// normal_force() is large enough to write.
double tilt_angle(const Eigen::Quaterniond& tip, const Eigen::Vector3d& contact_normal, int stroke,
                  double force);
double normal_error_angle(const Eigen::Vector3d& surface_normal, double surface_distance,
                          const Eigen::Vector3d& contact_normal, int stroke, double force);

// Distance between the tip and where the controller wanted it at the same instant, along the
// canvas: without its part along the true normal [m]. NaN as above.
double tracking_distance(const Eigen::Vector3d& tip, const Eigen::Vector3d& desired,
                         const Eigen::Vector3d& contact_normal, int stroke, double force);

using JointReference = Eigen::Ref<const Eigen::VectorXd>;
double torque_share(const JointReference& torque, const JointReference& limit);
double joint_margin(const JointReference& position, const JointReference& lower,
                    const JointReference& upper);
// NaN if `limit` is empty or no joint has one.
double joint_speed_share(const JointReference& velocity, const JointReference& limit);
bool is_clipped(const JointReference& before_limits, const JointReference& torque);

// Computes the steps during a run.
class LogSteps {
 public:
  explicit LogSteps(const RunLogHeader& header);
  // Set the extremes of the earlier steps when a log is continued.
  void set_joint_margin(double before) { joint_margin_ = before; }
  void set_joint_speed_share(double before) { joint_speed_share_ = before; }

  LogStep measure(const LogRow& row) noexcept;

 private:
  JointVector lower_, upper_, torque_limit_, speed_limit_;
  std::vector<std::size_t> terms_;  // in alphabetical order of their names, as a log lists them
  double joint_margin_ = std::numeric_limits<double>::infinity();
  double joint_speed_share_ = LogRow::kNone;
};

}  // namespace impedraw
