// The part of run.h5 that metrics and pictures need: 97 bytes per step.
//
// The log is read chunk by chunk; a reduced log is read from /every_step. Joint margin and clipped
// torques are reduced to one number each while reading. Forces and angles are computed step by step
// (log_step.h). All values are doubles, so metrics equal those computed from the whole log. The
// exceptions are torque_share, time_scale and stroke_along, floats (error 6e-8).
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "impedraw/log/log.h"
#include "impedraw/log/log_step.h"

namespace impedraw {

struct RunConstants : RunDescription {
  WallTimes wall;          // NaN if the run was killed before it closed its log
  bool cut_short = false;  // the file lost its end: the steps are what is left
};

// n control steps.
struct RunData : RunConstants {
  using Points = std::vector<Eigen::Vector3d>;

  std::vector<double> time;  // [s]
  std::vector<double> f;     // contact force · outward normal [N], 0 out of contact, NaN unknown
  Points contact_point;      // [m]; NaN out of contact
  std::vector<double>
      tilt;  // angle between −z_E and the canvas's normal [rad]; NaN except on pen-down ink
  std::vector<double>
      // angle between the estimated normal and the canvas's [rad]; also NaN without an estimate
      normal_error;
  // of the tip from its desired position, along the canvas [m]; NaN except on pen-down ink
  std::vector<double> tracking_error;
  std::vector<double> push;         // [N]
  std::vector<double> step_time;    // [s]
  std::vector<float> torque_share;  // largest ratio of a joint's |torque| to its limit
  std::vector<float> time_scale;    // speed of the plan's clock; 1 in older logs; empty: all 1
  std::vector<float> stroke_along;  // of the desired point along its stroke [m]; NaN between
  std::vector<int> stroke;
  std::vector<std::int8_t> mode;

  // Over all steps.
  std::optional<std::size_t>
      clipped;  // steps with a clipped joint torque; none if the log has no terms
  // smallest distance to a joint limit [rad]
  double joint_margin = std::numeric_limits<double>::infinity();
  // largest ratio of a joint's |speed| to its limit; NaN: not known
  double joint_speed_share = LogRow::kNone;

  std::size_t rows() const { return time.size(); }
};

// Takes the rows while the run goes on, for a run that leaves no log: equal to read_run() of its
// log but for step_time, which is kept to a float's precision.
class RunRecorder {
 public:
  explicit RunRecorder(const RunLogHeader& header);
  void add(const LogRow& row);
  RunData take(const WallTimes& wall);

 private:
  LogSteps steps_;
  bool terms_;
  RunData run_;
};

// Throws InputError as visit_rows() does (run_rows.h). The log of a killed run is read up to the
// last row that is complete in every dataset.
RunData read_run(const std::filesystem::path& path);

}  // namespace impedraw
