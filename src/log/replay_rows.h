// The rows of run.h5 that a replay shows, block by block, so that a long log need not fit into
// memory.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

class LogReader;

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
  bool reduced() const;    // rows of selected steps only
  bool cut_short() const;  // rows() are what is left of a file that lost its end

  // Reads rows [begin, begin + n). Returns false if they exist but cannot be read.
  bool read(std::size_t begin, std::size_t n, ReplayRows* rows) const;

 private:
  std::unique_ptr<LogReader> log_;
};

}  // namespace impedraw
