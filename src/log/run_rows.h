// The rows of run.h5, column by column. A reduced log has rows for selected steps only. A row takes
// 0.6 kB; for whole long runs use RunData, which takes a sixth of that.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/log/log.h"

namespace impedraw {

class LogReader;

// The rows of run.h5 that a replay shows, block by block, so that a long log need not fit into
// memory.

// n rows, j joints; units, frames and NaN as in log.h.
struct ReplayRows {
  using Joints = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;  // n×j

  std::vector<double> time;
  Joints joint_position, joint_velocity, joint_torque;
  std::vector<Joints> torque_terms;  // in the order of ReplayLog::torque_terms()
  std::vector<Eigen::Vector3d> tip_position, contact_force, surface_normal;
  std::vector<Eigen::Vector4d> tip_orientation;  // w x y z
  // Position and quaternion w x y z of the canvas's frame; empty where the canvas stands.
  using CanvasPoses = std::vector<Eigen::Matrix<double, 7, 1>>;
  CanvasPoses canvas_pose, estimated_canvas_pose;
  std::vector<double> surface_distance;
  std::vector<int> mode, stroke;

  std::size_t rows() const { return time.size(); }
};

class ReplayLog {
 public:
  // Throws InputError as read_rows().
  explicit ReplayLog(const std::filesystem::path& path);
  ~ReplayLog();

  std::size_t rows() const;  // that are complete in every dataset
  int joints() const;
  const std::vector<std::string>& torque_terms() const;
  bool canvas_moves() const;
  bool cut_short() const;  // rows() are what is left of a file that lost its end

  // Reads rows [begin, begin + n). Returns false if they exist but cannot be read.
  bool read(std::size_t begin, std::size_t n, ReplayRows* rows) const;

 private:
  std::unique_ptr<LogReader> log_;
};

class LogReader;

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

enum class Columns {
  all,
  of_results
};  // of_results: only the columns that RunData needs; the others stay unchanged

// Reads rows [begin, begin + n) of the log. Returns false if they exist but cannot be read. Throws
// InputError as the overload below.
bool read_rows(const LogReader& log, std::size_t begin, std::size_t n, Columns columns,
               RunRows* rows);

// Reads all rows of a log, which must fit into memory. Throws InputError naming the file and the
// dataset if the file is no log, lacks a dataset, or has one of the wrong shape. The log of a
// killed run is read up to the last row that is complete in every dataset.
RunRows read_rows(const std::filesystem::path& path);

// Hands over the rows of a log, one after the other, with time, stroke and place on it, mode,
// measured joint positions, pose of the tip, contact force, point and normal, measured wrench,
// push, estimated normal and poses of the canvas. Throws InputError as read_rows(), or if rows
// cannot be read.
void visit_rows(const std::filesystem::path& path, const std::function<void(const LogRow&)>& visit);

}  // namespace impedraw
