#include "impedraw/log/log_step.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "impedraw/common/rotations.h"
#include "impedraw/ink/ink_lines.h"
#include "impedraw/log/run_data.h"

namespace impedraw {
namespace {

double to_float(double x) { return static_cast<double>(static_cast<float>(x)); }

}  // namespace

double normal_force(const Eigen::Vector3d& force, const Eigen::Vector3d& normal) {
  if (!force.allFinite()) return LogRow::kNone;
  const double f = force.dot(normal);
  return std::isfinite(f) ? f : 0.0;
}

double tilt_angle(const Eigen::Quaterniond& tip, const Eigen::Vector3d& contact_normal, int stroke,
                  double force) {
  if (stroke < 0 || !is_ink(force)) return LogRow::kNone;
  return angle_between(-(tip * Eigen::Vector3d::UnitZ()), contact_normal);
}

double normal_error_angle(const Eigen::Vector3d& surface_normal, double surface_distance,
                          const Eigen::Vector3d& contact_normal, int stroke, double force) {
  const bool estimate = std::isfinite(surface_distance) && surface_normal.allFinite();
  if (stroke < 0 || !is_ink(force) || !estimate) return LogRow::kNone;
  return angle_between(surface_normal, contact_normal);
}

double tracking_distance(const Eigen::Vector3d& tip, const Eigen::Vector3d& desired,
                         const Eigen::Vector3d& contact_normal, int stroke, double force) {
  if (stroke < 0 || !is_ink(force)) return LogRow::kNone;
  const Eigen::Vector3d error = tip - desired;
  return (error - contact_normal * contact_normal.dot(error)).norm();
}

double torque_share(const JointReference& torque, const JointReference& limit) {
  return to_float((torque.array().abs() / limit.array()).maxCoeff());
}

double joint_margin(const JointReference& position, const JointReference& lower,
                    const JointReference& upper) {
  double margin = std::numeric_limits<double>::infinity();
  for (Eigen::Index j = 0; j < position.size(); ++j)
    margin = std::min({margin, position[j] - lower[j], upper[j] - position[j]});
  return margin;
}

double joint_speed_share(const JointReference& velocity, const JointReference& limit) {
  double share = LogRow::kNone;
  for (Eigen::Index j = 0; j < limit.size(); ++j)
    if (std::isfinite(limit[j])) share = std::fmax(share, std::abs(velocity[j]) / limit[j]);
  return share;
}

bool is_clipped(const JointReference& before_limits, const JointReference& torque) {
  return ((before_limits - torque).array().abs() > 1e-9 * before_limits.array().abs().max(1.0))
      .any();
}

LogSteps::LogSteps(const RunLogHeader& header)
    : lower_(header.joint_lower),
      upper_(header.joint_upper),
      torque_limit_(header.torque_limit),
      speed_limit_(header.joint_speed_limit),
      terms_(header.torque_terms.size()) {
  std::iota(terms_.begin(), terms_.end(), 0);
  std::sort(terms_.begin(), terms_.end(), [&](std::size_t a, std::size_t b) {
    return header.torque_terms[a] < header.torque_terms[b];
  });
}

LogStep LogSteps::measure(const LogRow& row) noexcept {
  LogStep step;
  step.time = row.time;
  const Eigen::Vector3d contact_normal = row.contact_normal_W();
  step.force = normal_force(row.contact_force, contact_normal);
  step.contact_point = row.contact_point;
  step.tilt = tilt_angle(row.tip_orientation, contact_normal, row.stroke, step.force);
  step.normal_error = normal_error_angle(row.surface_normal, row.surface_distance, contact_normal,
                                         row.stroke, step.force);
  step.tracking_error = tracking_distance(row.tip_position, row.desired_position, contact_normal,
                                          row.stroke, step.force);
  step.push = row.push;
  step.torque_share = torque_share(row.joint_torque, torque_limit_);
  joint_margin_ = std::min(joint_margin_, joint_margin(row.joint_position, lower_, upper_));
  step.joint_margin = joint_margin_;
  joint_speed_share_ =
      std::fmax(joint_speed_share_, joint_speed_share(row.joint_velocity, speed_limit_));
  step.joint_speed_share = joint_speed_share_;
  if (!terms_.empty()) {
    JointVector sum = row.torque_terms[terms_.front()];
    for (std::size_t k = 1; k < terms_.size(); ++k) sum += row.torque_terms[terms_[k]];
    step.clipped = is_clipped(sum, row.joint_torque);
  }
  step.mode = row.mode;
  step.stroke = row.stroke;
  step.stroke_along = row.stroke_along;
  step.felt_force = to_float(row.wrench_measured.head<3>().dot(row.surface_normal));
  step.time_scale = to_float(row.time_scale);
  step.step_time = to_float(row.step_time);
  return step;
}

}  // namespace impedraw
