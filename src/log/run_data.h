// A run read back from run.h5: what the metrics and pictures need of it, 81 bytes a row.
//
// The log is read chunk by chunk; of a reduced one what it holds of every step. What feeds one
// number alone (joint margin, clipped torques) is counted while reading; what the metrics take of
// forces, normals and orientations is worked out step by step (log_step.h). All in doubles, so that
// no metric differs from one worked out on the whole log; only torque_share, which is plotted to a
// hundredth of a percent, is a float (its error: 6e-8).
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "impedraw/log/log.h"
#include "impedraw/log/run_rows.h"

namespace impedraw {

// What does not change while a run lasts; units and frames as in log.h.
struct RunConstants {
  using Points = std::vector<Eigen::Vector3d>;

  std::vector<std::string> joint_names, mode_names;
  Eigen::VectorXd joint_lower, joint_upper, torque_limit;
  Points canvas_vertices;
  std::vector<Eigen::Vector3i> canvas_triangles;
  Points cloud_points;
  Points target_points;
  std::vector<int> target_stroke;
  WallTimes wall;  // NaN where the run was killed before it closed its log
  std::map<std::string, std::string> attributes;  // the root's text attributes
};

// n control steps.
struct RunData : RunConstants {
  std::vector<double> time;  // [s]
  std::vector<double> f;     // contact force · outward normal [N], 0 out of contact
  Points contact_point;      // [m]; NaN out of contact
  std::vector<double>
      tilt;  // angle between −z_E and the canvas's normal [rad]; NaN but on pen-down ink
  std::vector<double>
      // angle between the controller's normal and the canvas's [rad]; NaN too without an estimate
      normal_error;
  std::vector<double> push;         // [N]
  std::vector<double> step_time;    // [s]
  std::vector<float> torque_share;  // largest |torque| of a joint against its limit
  std::vector<int> stroke;
  std::vector<std::int8_t> mode;

  // Over all steps.
  std::optional<std::size_t>
      clipped;  // steps in which a joint's torque was; none where the log has no terms
  // smallest distance to a joint limit [rad]
  double joint_margin = std::numeric_limits<double>::infinity();

  std::size_t rows() const { return time.size(); }
};

// Takes the rows of a full log in, after those that are there; the limits must be set.
void add_rows(const RunRows& rows, RunData* run);

// Throws InputError as read_rows does. A log that was cut off by a kill is read as far as every
// dataset goes.
RunData read_run(const std::filesystem::path& path);

double angle_between(const Eigen::Vector3d& a,
                     const Eigen::Vector3d& b);  // [rad], exact near 0 and π

}  // namespace impedraw
