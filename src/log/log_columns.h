// The datasets of run.h5 that grow with the run, as two lists of columns. Private to src/log.
#pragma once

#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

#include "impedraw/log/log.h"
#include "impedraw/log/log_step.h"

namespace impedraw {

// Logs of older versions lack it.
inline constexpr const char* kSpeedShareColumn = "/every_step/joint_speed_share";
// Only where the canvas moves.
inline constexpr const char* kCanvasPoseColumn = "/canvas/pose";
// Only where a pen's width changes with its force.
inline constexpr const char* kLineWidthColumn = "/ink/width";
inline constexpr const char* kEstimatedCanvasPoseColumn = "/canvas/estimated_pose";

struct LogColumn {
  std::string name;  // path in the file
  int width;         // 1: shape n; otherwise n×width
  bool integer;      // int32 instead of double
  const char* unit;
  const char* frame;
  std::string description;

  std::size_t row_bytes() const {
    return static_cast<std::size_t>(width) * (integer ? sizeof(int) : sizeof(double));
  }
};

// Columns in the order in which put_row() visits them. The first is the time.
std::vector<LogColumn> log_columns(const RunLogHeader& header);

// Columns of /every_step in the order in which put_step() visits them. The first is the time.
const std::vector<LogColumn>& step_columns(bool moving_canvas = false);

// Calls put(pointer to first value, count, size of one value) for each column of log_columns().
template <typename Put>
void put_row(const LogRow& row, int terms, bool joint_sensor, bool line_width, bool moving_canvas,
             Put&& put) {
  const auto vector = [&](const auto& v) {
    put(v.data(), static_cast<int>(v.size()), sizeof(double));
  };
  const auto number = [&](const auto& v) { put(&v, 1, sizeof(v)); };
  const auto quaternion = [&](const Eigen::Quaterniond& q) {
    const double wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
    put(wxyz, 4, sizeof(double));
  };
  number(row.time);
  vector(row.joint_position);
  vector(row.joint_velocity);
  vector(row.joint_torque);
  if (joint_sensor) {
    vector(row.measured_position);
    vector(row.measured_velocity);
  }
  for (int i = 0; i < terms; ++i) vector(row.torque_terms[i]);
  vector(row.tip_position);
  quaternion(row.tip_orientation);
  vector(row.tip_velocity);
  vector(row.desired_position);
  quaternion(row.desired_orientation);
  vector(row.contact_force);
  vector(row.contact_point);
  vector(row.contact_normal);
  vector(row.wrench_measured);
  vector(row.disturbance_force);
  vector(row.surface_normal);
  number(row.surface_distance);
  number(row.push);
  number(row.mode);
  number(row.stroke);
  number(row.stroke_along);
  number(row.time_scale);
  number(row.step_time);
  if (line_width) number(row.line_width);
  if (moving_canvas) {
    for (const Pose* pose : {&row.canvas_pose, &row.estimated_canvas_pose}) {
      const Eigen::Quaterniond q(pose->R);
      const double values[7] = {pose->p.x(), pose->p.y(), pose->p.z(), q.w(), q.x(), q.y(), q.z()};
      put(values, 7, sizeof(double));
    }
    vector(row.estimated_canvas_twist);
  }
}

// The same for step_columns(). Step is LogStep or const LogStep.
template <typename Step, typename Put>
void put_step(Step& step, Put&& put) {
  const auto number = [&](auto& v) { put(&v, 1, sizeof(v)); };
  number(step.time);
  number(step.force);
  put(step.contact_point.data(), 3, sizeof(double));
  number(step.tilt);
  number(step.normal_error);
  number(step.tracking_error);
  number(step.push);
  number(step.torque_share);
  number(step.joint_margin);
  number(step.joint_speed_share);
  number(step.clipped);
  number(step.mode);
  number(step.stroke);
  number(step.stroke_along);
  number(step.felt_force);
  number(step.time_scale);
  number(step.step_time);
}

}  // namespace impedraw
