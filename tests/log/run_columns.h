// The rows of run.h5 column by column, and a run put together from them: for tests, in memory. A
// reduced log has rows for selected steps only.
#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/log/run_data.h"
#include "impedraw/log/run_rows.h"

namespace impedraw {

// n rows, j joints; units, frames and NaN as in log.h.
struct RunRows {
  using Points = std::vector<Eigen::Vector3d>;
  using Joints = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;  // n×j

  std::vector<double> time;
  Joints joint_position, joint_velocity, joint_torque;
  Joints torque_before_limits;  // sum of the named terms; empty if the log has no terms
  Points tip_position;
  std::vector<Eigen::Quaterniond> tip_orientation;
  Points desired_position;
  Points contact_force, contact_point;
  Points contact_normal;  // in W, also where the log has it in the canvas's frame
  Points disturbance_force;
  Points surface_normal;
  std::vector<double> surface_distance, push, step_time;
  std::vector<double> time_scale;  // all 1 if the log has none
  std::vector<int> mode, stroke;
  std::vector<double> stroke_along;  // all NaN if the log has none

  std::size_t rows() const { return time.size(); }
};

// Throws InputError as visit_rows().
inline RunRows read_rows(const std::filesystem::path& path) {
  const ReplayLog log(path);
  const auto n = static_cast<Eigen::Index>(log.rows()), joints = Eigen::Index{log.joints()};
  const std::size_t terms = log.torque_terms().size();
  RunRows rows;
  for (RunRows::Joints* all : {&rows.joint_position, &rows.joint_velocity, &rows.joint_torque})
    all->resize(n, joints);
  rows.torque_before_limits.resize(terms > 0 ? n : 0, joints);
  visit_rows(path, [&](const LogRow& row) {
    const auto i = static_cast<Eigen::Index>(rows.rows());
    rows.time.push_back(row.time);
    rows.joint_position.row(i) = row.joint_position.transpose();
    rows.joint_velocity.row(i) = row.joint_velocity.transpose();
    rows.joint_torque.row(i) = row.joint_torque.transpose();
    for (std::size_t k = 0; k < terms; ++k) {
      if (k == 0) rows.torque_before_limits.row(i).setZero();
      rows.torque_before_limits.row(i) += row.torque_terms[k].transpose();
    }
    rows.tip_position.push_back(row.tip_position);
    rows.tip_orientation.push_back(row.tip_orientation);
    rows.desired_position.push_back(row.desired_position);
    rows.contact_force.push_back(row.contact_force);
    rows.contact_point.push_back(row.contact_point);
    rows.contact_normal.push_back(row.contact_normal_W());
    rows.disturbance_force.push_back(row.disturbance_force);
    rows.surface_normal.push_back(row.surface_normal);
    rows.surface_distance.push_back(row.surface_distance);
    rows.push.push_back(row.push);
    rows.step_time.push_back(row.step_time);
    rows.time_scale.push_back(row.time_scale);
    rows.mode.push_back(row.mode);
    rows.stroke.push_back(row.stroke);
    rows.stroke_along.push_back(row.stroke_along);
  });
  return rows;
}

// What read_run() makes of a log with these rows.
inline RunData recorded(const RunRows& rows, const RunConstants& constants) {
  RunLogHeader header;
  static_cast<RunDescription&>(header) = constants;
  const bool terms = rows.torque_before_limits.rows() > 0;
  if (terms) header.torque_terms = {"all"};
  RunRecorder recorder(header);
  LogRow row(static_cast<int>(rows.joint_torque.cols()));
  for (std::size_t i = 0; i < rows.rows(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    row.time = rows.time[i];
    row.joint_position = rows.joint_position.row(k).transpose();
    row.joint_velocity = rows.joint_velocity.row(k).transpose();
    row.joint_torque = rows.joint_torque.row(k).transpose();
    if (terms) row.torque_terms[0] = rows.torque_before_limits.row(k).transpose();
    row.tip_position = rows.tip_position[i];
    row.tip_orientation = rows.tip_orientation[i];
    row.desired_position = rows.desired_position[i];
    row.contact_force = rows.contact_force[i];
    row.contact_point = rows.contact_point[i];
    row.contact_normal = rows.contact_normal[i];
    row.surface_normal = rows.surface_normal[i];
    row.surface_distance = rows.surface_distance[i];
    row.push = rows.push[i];
    row.step_time = rows.step_time[i];
    row.time_scale = rows.time_scale[i];
    row.mode = rows.mode[i];
    row.stroke = rows.stroke[i];
    row.stroke_along = rows.stroke_along[i];
    recorder.add(row);
  }
  RunData run = recorder.take(constants.wall);
  static_cast<RunConstants&>(run) = constants;
  run.step_time = rows.step_time;
  return run;
}

}  // namespace impedraw
