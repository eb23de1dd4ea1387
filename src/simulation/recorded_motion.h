// A recorded motion of a body, as a motion tracker leaves it, played back smoothly.
//
//   t, x, y, z, qw, qx, qy, qz        s, m, a unit quaternion: X_WB of any frame B of the body
//
// Positions and quaternions are interpolated by natural cubic splines, so that velocity and
// acceleration are continuous. Only the change since the first row counts:
//
//   X(t) = X_WB(t) X_WB(0)⁻¹
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "impedraw/common/pose.h"

namespace impedraw {

class RecordedMotion {
 public:
  static constexpr double kLongestGap = 0.25;  // between two rows [s]
  static constexpr double kMostSpeed = 2.0;    // of B's origin from row to row [m/s]
  static constexpr double kMostTurn = 10.0;    // [rad/s]

  struct State {
    Pose X;                                       // of the body since the first row, W
    Eigen::Vector3d v = Eigen::Vector3d::Zero();  // of B's origin, W [m/s]
    Eigen::Vector3d w = Eigen::Vector3d::Zero();  // W [rad/s]
    Eigen::Vector3d p = Eigen::Vector3d::Zero();  // B's origin, W [m]
  };

  // A text of rows; lines that start with # and a header are skipped. Throws InputError "<name>:
  // line <n>: …" for what is no row, times that do not increase, gaps and jumps.
  RecordedMotion(std::string_view text, const std::string& name);

  double duration() const noexcept { return times_.back(); }  // [s]

  // t: since the first row, held to 0 … duration(). Allocates nothing.
  State at(double t) const noexcept;

 private:
  using Row = Eigen::Matrix<double, 7, 1>;  // position, quaternion w, x, y, z
  std::vector<double> times_;               // since the first row [s]
  std::vector<Row> rows_, curvatures_;
};

// Throws InputError.
RecordedMotion read_recorded_motion(const std::filesystem::path& file);

}  // namespace impedraw
