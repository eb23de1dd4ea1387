// Checks the values of a log that later stages rely on. A log is input: it may be damaged or made
// up. Private to src/log.
#pragma once

#include <span>
#include <string>

#include <Eigen/Core>

#include "impedraw/log/log_reader.h"
#include "impedraw/log/run_data.h"

namespace impedraw {

// Throws InputError naming dataset and row unless vertices and points are finite and near the arm,
// triangles name vertices that exist, and the target's strokes are numbered in order.
void require_valid(const LogReader& log, const RunConstants& constants);

// Checks the steps of a log block by block. Each call takes the next rows of its dataset.
class StepChecks {
 public:
  explicit StepChecks(const LogReader& log);

  void times(std::span<const double> times);  // finite and increasing
  // Length along the stroke: finite where there is a stroke.
  void alongs(std::span<const double> alongs, std::span<const int> strokes) const;
  void strokes(std::span<const int> strokes) const;
  void modes(std::span<const int> modes) const;  // index of a contact state that has a name
  // NaN, or near the arm; a line through all of them is no longer than any ink.
  void contact_points(std::span<const Eigen::Vector3d> points);
  void next(std::size_t rows) { row_ += rows; }  // after each block

 private:
  [[noreturn]] void fail(const char* name, std::size_t row, const std::string& what) const;

  const LogReader& log_;
  std::string at_;  // "/every_step" in a reduced log
  std::size_t row_ = 0;
  double last_time_;
  Eigen::Vector3d last_point_;
  double length_ = 0.0;  // [m]
};

}  // namespace impedraw
