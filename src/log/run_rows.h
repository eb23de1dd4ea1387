// Rows of run.h5 column by column, as they stand there; of a reduced log those of some steps. 0.6
// kB a row: a whole long run is read as RunData, which is a sixth of that.
#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

class LogReader;

// n rows, j joints; units, frames and NaN as in log.h.
struct RunRows {
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
  std::vector<double> stroke_along;  // NaN throughout in a log that has none

  std::size_t rows() const { return time.size(); }
};

enum class Columns {
  all,
  of_results
};  // of_results: those that RunData is made from; the others keep what they held

// Rows [begin, begin + n) of the log; false where they are there but cannot be read. Throws
// InputError as read_rows.
bool read_rows(const LogReader& log, std::size_t begin, std::size_t n, Columns columns,
               RunRows* rows);

// All rows of a log, which must fit into memory. Throws InputError naming the file and the dataset
// when it is no log, lacks a dataset, or has one of the wrong shape. A log that was cut off by a
// kill is read as far as every dataset goes.
RunRows read_rows(const std::filesystem::path& path);

}  // namespace impedraw
