// A run read back from run.h5: what the metrics and pictures need of it.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "report/log.h"

namespace impedraw {

// n rows, j joints; names, units, frames and NaN as in log.h.
struct RunData {
  using Points = std::vector<Eigen::Vector3d>;
  using Joints = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;  // n×j

  std::vector<double> time;
  Joints joint_position, joint_velocity, joint_torque;
  Joints torque_before_limits;  // sum of the named terms; no rows where the log has no terms
  Points tip_position;
  std::vector<Eigen::Quaterniond> tip_orientation;
  Points desired_position;
  Points contact_force, contact_point, contact_normal;
  Points disturbance_force;
  Points surface_normal;
  std::vector<double> surface_distance, push, step_time;
  std::vector<int> mode, stroke;

  std::vector<std::string> joint_names, mode_names;
  Eigen::VectorXd joint_lower, joint_upper, torque_limit;
  Points canvas_vertices;
  std::vector<Eigen::Vector3i> canvas_triangles;
  Points cloud_points;
  Points target_points;
  std::vector<int> target_stroke;
  WallTimes wall;                                 // NaN where the run was killed before it closed its log
  std::map<std::string, std::string> attributes;  // the root's text attributes

  std::size_t rows() const { return time.size(); }
};

// Throws InputError naming the file and the dataset when it is no log, lacks a dataset, or has one of the wrong shape. A log that was cut
// off by a kill is read as far as every dataset goes.
RunData read_run(const std::filesystem::path& path);

}  // namespace impedraw
