// Checks the values of a log that later stages rely on. A log is input: it may be damaged or made
// up. Private to src/log.
#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "impedraw/log/log_reader.h"
#include "impedraw/log/run_data.h"

namespace impedraw {

// Throws InputError naming dataset and row unless vertices and points are finite and near the arm,
// triangles name vertices that exist, and the target's strokes are numbered in order.
void require_valid(const LogReader& log, const RunConstants& constants);

// Throws InputError unless the place on a stroke is finite. row: of the step.
void require_along(const LogReader& log, const LogStep& step, std::size_t row);

// Checks the steps of a log, one after the other.
class StepChecks {
 public:
  explicit StepChecks(const LogReader& log);

  // Throws InputError naming dataset and row unless times are finite and increase, the stroke has a
  // possible number, the mode is the index of a contact state that has a name, and contact points
  // are NaN or near the arm, a line through all of them no longer than any ink.
  void next(const LogStep& step);

 private:
  const LogReader& log_;
  std::size_t row_ = 0;
  double last_time_;
  Eigen::Vector3d last_point_;
  double length_ = 0.0;  // [m]
};

}  // namespace impedraw
