// run.h5: what happened in every control step, streamed while it happens.
//
// One row a step (row i: the state at t_i, the torque computed from it, the contact force acting
// over [t_i, t_i+1)); a reduced log has rows of some steps (row_selection.h) and of every step what
// metrics, plots and a resumed run need (/every_step, log_step.h). SI, world frame W, quaternions w
// x y z. docs of every dataset: columns() in log_columns.cc, written into the file as attributes
// unit, frame, description.
//
//   loop ── append(): copies the row into a ring of columns ──> writer thread: shuffle, deflate,
//   HDF5 chunk, flush
//
// append() allocates nothing and does no I/O; it waits only when the disk has fallen a whole ring
// (16,384 steps) behind. Rows reach the file at least every half second of wall time, so kill -9
// loses less than the last second: between flushes nothing that the file on disk refers to is
// touched (metadata is held back, freed space is never used again). Memory does not grow with the
// run.
//
// A run can go on in the log of an earlier one, whatever ended that one: append_to().
#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/control/arm_terms.h"
#include "impedraw/log/log_settings.h"

namespace impedraw {

inline constexpr int kMaxTorqueTerms = 12;

// Plain data of one control step: n joints, terms in the order of RunLogHeader::torque_terms.
struct LogRow {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  static Eigen::Vector3d no_vector() { return Eigen::Vector3d::Constant(kNone); }

  double time = 0.0;  // t_i [s]
  JointVector joint_position, joint_velocity,
      joint_torque;  // [rad], [rad/s], [Nm]; torque after limits
  std::array<JointVector, kMaxTorqueTerms>
      torque_terms;  // [Nm]; their sum is the torque before limits
  Eigen::Vector3d tip_position = Eigen::Vector3d::Zero();               // p_WE, true [m]
  Eigen::Quaterniond tip_orientation = Eigen::Quaterniond::Identity();  // R_WE, true
  Vector6 tip_velocity = Vector6::Zero();  // V_WE, true, linear first [m/s, rad/s]
  Eigen::Vector3d desired_position = Eigen::Vector3d::Zero();  // p_WD, compensation included [m]
  Eigen::Quaterniond desired_orientation = Eigen::Quaterniond::Identity();  // R_WD
  // true force of the canvas on the tip [N]
  Eigen::Vector3d contact_force = Eigen::Vector3d::Zero();
  // of the canvas, closest to the tip sphere's centre [m]; or NaN
  Eigen::Vector3d contact_point = no_vector();
  // the canvas's outward unit normal there; NaN out of contact
  Eigen::Vector3d contact_normal = no_vector();
  Vector6 wrench_measured = Vector6::Zero();  // F_ext as the controller was given it, at E [N, Nm]
  // the scenario's push on the pen [N]
  Eigen::Vector3d disturbance_force = Eigen::Vector3d::Zero();
  // the controller's estimate, outward; NaN without one
  Eigen::Vector3d surface_normal = no_vector();
  // of E to the estimated surface, > 0 outside [m]; NaN without one
  double surface_distance = kNone;
  double push = 0.0;  // normal force asked for [N]
  int mode = 0;       // index into RunLogHeader::mode_names
  int stroke = -1;    // from the plan alone; −1 between strokes; may come back later
  // length of the stroke in the drawing plane, from its first point to the desired one [m]; NaN
  // where stroke < 0
  double stroke_along = kNone;
  double step_time = 0.0;  // wall time of the controller step [s]

  explicit LogRow(int joints)
      : joint_position(JointVector::Zero(joints)),
        joint_velocity(joint_position),
        joint_torque(joint_position) {
    torque_terms.fill(joint_position);
  }
};

// What does not change while the run lasts.
struct RunLogHeader {
  std::vector<std::string> joint_names;  // n, 1 … kMaxJoints
  Eigen::VectorXd joint_lower, joint_upper,
      torque_limit;  // n; [rad], [rad], [Nm]; ± inf where there is none
  std::vector<std::string>
      torque_terms;  // at most kMaxTorqueTerms, each the name of a dataset /torque/<term>
  std::vector<std::string> mode_names;           // of LogRow::mode
  std::vector<Eigen::Vector3d> canvas_vertices;  // the true canvas [m]
  std::vector<Eigen::Vector3i> canvas_triangles;
  std::vector<Eigen::Vector3d> cloud_points,
      cloud_normals;              // as the controller has it [m]; empty without perception
  std::vector<int> cloud_camera;  // which camera saw the point
  std::vector<Eigen::Vector3d> target_points;     // the artwork projected on the true canvas [m]
  std::vector<int> target_stroke;                 // whose stroke each point is; non-decreasing
  std::map<std::string, std::string> attributes;  // of the file's root: scenario, seed, version …
  LogRate rate = LogRate::full;
  double dt = 1e-3;  // of a control step [s]
};

// Wall seconds of the parts of a run [s]; NaN where not measured. `writing` is what close() still
// had to write after the loop.
struct WallTimes {
  double start_up = LogRow::kNone, loop = LogRow::kNone, writing = LogRow::kNone;
};

// The log could not be written: disk full, folder gone. The message names the file and the cause;
// rows flushed before remain readable.
class LogError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class RunLog {
 public:
  // Creates `path` (replacing a file that is there). Throws LogError when it cannot,
  // std::invalid_argument for a header that contradicts itself.
  RunLog(const std::filesystem::path& path, const RunLogHeader& header);
  // Goes on in the log at `path`: rows are appended after those that are whole there (a killed run
  // may lack its last ones). `header` must be that of the log (joints and their limits, terms,
  // contact states; sizes of canvas, cloud and target): InputError, also for what is no log, naming
  // what differs. LogError when the file cannot be written. What the log holds of canvas, cloud,
  // target and attributes stays, and so does its rate. The caller sees to it that times go on
  // rising.
  static RunLog append_to(const std::filesystem::path& path, const RunLogHeader& header);
  ~RunLog();  // closes without wall times, if close() was not called; says nothing of errors
  RunLog(RunLog&&) noexcept;
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;

  // Takes the row (one thread only). Throws LogError once the writer has failed,
  // std::invalid_argument when joint counts differ.
  void append(const LogRow& row);

  // Writes what is left, then the wall times as root attributes wall_start_up, wall_loop,
  // wall_writing, and closes the file. Throws LogError when anything could not be written. Returns
  // `wall` with `writing` filled in. In a log that was appended to, the attributes are sums over
  // its runs, NaN when one of them was killed.
  WallTimes close(WallTimes wall = {});

  long steps() const noexcept;  // of the log so far, those found by append_to() included

 private:
  struct Writer;
  explicit RunLog(std::unique_ptr<Writer> writer);
  std::unique_ptr<Writer> writer_;
};

}  // namespace impedraw
