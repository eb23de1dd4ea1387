// run.h5: the log of a run, streamed to disk during the run.
//
// A full log has one row per control step. Row i holds the state at t_i, the torque computed from
// it, and the contact force over [t_i, t_i+1). A reduced log has rows for selected steps only
// (row_selection.h). For every step it holds what metrics, plots and a resumed run need
// (/every_step, log_step.h). Units are SI, vectors are in the world frame W, quaternions are
// w x y z. log_columns.cc defines each dataset; the file holds its unit, frame and description as
// attributes.
//
//   loop ── append(): copies the row into a ring of columns ──> writer thread: run.journal, synced
//                                                               shuffle, deflate, chunk of run.h5
//
// append() allocates nothing and does no I/O. It blocks only when the disk is kMostUnsyncedSteps
// behind. During the run, run.h5 holds what it held when the run began: for a new run, all but
// rows. Rows are synced to the disk in run.journal at least every half second of wall time, so a
// power cut loses less than the last seconds, and kill -9 less than the last second. They are also
// compressed into a copy of run.h5, which replaces it when the run ends. After a kill,
// recover_log() makes that file from the journal. Memory use does not grow with the run.
//
// A run can continue the log of an earlier one, however that one ended: append_to().
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

#include "impedraw/common/pose.h"
#include "impedraw/control/arm_terms.h"
#include "impedraw/log/log_settings.h"

namespace impedraw {

inline constexpr int kMaxTorqueTerms = 12;
// A power cut loses at most this many steps, however fast they are simulated. (The driver of a real
// arm, which must not wait for a disk, gets there only if a sync takes 4 s.)
inline constexpr std::size_t kMostUnsyncedSteps = 4096;

// Data of one control step: n joints, terms in the order of RunLogHeader::torque_terms.
struct LogRow {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  static Eigen::Vector3d no_vector() { return Eigen::Vector3d::Constant(kNone); }

  double time = 0.0;  // t_i [s]
  JointVector joint_position, joint_velocity,
      joint_torque;  // [rad], [rad/s], [Nm]; torque after limits
  // as the controller was given them [rad], [rad/s]; only with RunLogHeader::joint_sensor
  JointVector measured_position, measured_velocity;
  std::array<JointVector, kMaxTorqueTerms>
      torque_terms;  // [Nm]; their sum is the torque before limits
  Eigen::Vector3d tip_position = Eigen::Vector3d::Zero();               // p_WE, true [m]
  Eigen::Quaterniond tip_orientation = Eigen::Quaterniond::Identity();  // R_WE, true
  Vector6 tip_velocity = Vector6::Zero();  // V_WE, true, linear first [m/s, rad/s]
  Eigen::Vector3d desired_position = Eigen::Vector3d::Zero();  // p_WD, compensation included [m]
  Eigen::Quaterniond desired_orientation = Eigen::Quaterniond::Identity();  // R_WD
  // true force of the canvas on the tip [N]
  Eigen::Vector3d contact_force = Eigen::Vector3d::Zero();
  // point of the canvas closest to the tip sphere's centre, in K [m]; NaN out of contact
  Eigen::Vector3d contact_point = no_vector();
  // the canvas's outward unit normal there, in K; NaN out of contact
  Eigen::Vector3d contact_normal = no_vector();
  Vector6 wrench_measured = Vector6::Zero();  // F_ext as passed to the controller, at E [N, Nm]
  // the scenario's push on the pen [N]
  Eigen::Vector3d disturbance_force = Eigen::Vector3d::Zero();
  // the controller's estimate of the outward normal; NaN without one
  Eigen::Vector3d surface_normal = no_vector();
  // signed distance of E from the estimated surface, > 0 outside [m]; NaN without an estimate
  double surface_distance = kNone;
  double push = 0.0;  // desired normal force [N]
  int mode = 0;       // index into RunLogHeader::mode_names
  int stroke = -1;    // planned stroke; −1 between strokes; may recur in a later pass
  // arc length in the drawing plane from the stroke's first point to the desired one [m]; NaN if
  // stroke < 0
  double stroke_along = kNone;
  // that the pen draws with this force [mm]; NaN without ink. Only with RunLogHeader::line_width
  double line_width = kNone;
  // speed of the plan's clock, 0 … 1; 1: as planned
  double time_scale = 1.0;
  double step_time = 0.0;  // wall time of the controller step [s]
  // The canvas's frame K in W, true and as the controller estimates it; its estimated twist, of the
  // origin of K, linear part first [m/s, rad/s]. Only with RunLogHeader::moving_canvas; else K is
  // W.
  Pose canvas_pose, estimated_canvas_pose;
  Vector6 estimated_canvas_twist = Vector6::Zero();

  Eigen::Vector3d contact_point_W() const { return canvas_pose * contact_point; }
  Eigen::Vector3d contact_normal_W() const { return canvas_pose.R * contact_normal; }

  explicit LogRow(int joints)
      : joint_position(JointVector::Zero(joints)),
        joint_velocity(joint_position),
        joint_torque(joint_position),
        measured_position(joint_position),
        measured_velocity(joint_position) {
    torque_terms.fill(joint_position);
  }
};

// Data that is constant during a run, as a log keeps it and gives it back.
struct RunDescription {
  std::vector<std::string> joint_names;  // n, 1 … kMaxJoints
  std::vector<std::string> mode_names;   // of LogRow::mode
  // n; [rad], [rad], [Nm]; ± inf if unlimited
  Eigen::VectorXd joint_lower, joint_upper, torque_limit;
  Eigen::VectorXd joint_speed_limit;             // n; [rad/s]; inf if unlimited; empty: not known
  std::vector<Eigen::Vector3d> canvas_vertices;  // the true canvas [m]
  std::vector<Eigen::Vector3i> canvas_triangles;
  std::vector<Eigen::Vector3d> cloud_points;      // the controller's [m]; empty without perception
  std::vector<int> cloud_colour;                  // 0xRRGGBB; empty, or one each
  std::vector<Eigen::Vector3d> target_points;     // the artwork projected on the true canvas [m]
  std::vector<int> target_stroke;                 // stroke of each point; non-decreasing
  std::map<std::string, std::string> attributes;  // of the file's root: scenario, seed, version …
};

struct RunLogHeader : RunDescription {
  bool joint_sensor = false;   // the rows have measured joint positions and velocities
  bool line_width = false;     // the rows have the width of the drawn line
  bool moving_canvas = false;  // the rows have the pose of the canvas's frame K
  // At most kMaxTorqueTerms, each the name of a dataset /torque/<term>.
  std::vector<std::string> torque_terms;
  std::vector<Eigen::Vector3d> cloud_normals;
  std::vector<int> cloud_camera;  // index of the camera that saw the point
  LogRate rate = LogRate::full;
  double dt = 1e-3;  // of a control step [s]
};

// Wall time of the parts of a run [s]; NaN if not measured. `writing` is the time close() spends on
// rows left over after the loop.
struct WallTimes {
  double start_up = LogRow::kNone, loop = LogRow::kNone, writing = LogRow::kNone;
};

// The log could not be written, e.g. the disk is full or the folder is gone. The message names the
// file and the cause. Rows synced earlier remain: recover_log().
class LogError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class RunLog {
 public:
  // Creates `path`, which replaces an existing log and its journal. Throws LogError if that fails,
  // std::invalid_argument if the header contradicts itself.
  RunLog(const std::filesystem::path& path, const RunLogHeader& header);
  // Continues the log at `path`, recovered if need be. New rows follow the last complete one; a
  // killed run may lack its last rows. `header` must match the log: joints and their limits, terms,
  // contact states, and the sizes of canvas, cloud and target. Throws InputError naming the
  // difference, or if the file is no log; LogError if the file cannot be written. The log keeps its
  // canvas, cloud, target, attributes and rate. The caller must ensure that times keep increasing.
  static RunLog append_to(const std::filesystem::path& path, const RunLogHeader& header);
  ~RunLog();  // if close() was not called: closes without wall times and ignores errors
  RunLog(RunLog&&) noexcept;
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;

  // Appends the row. Call from one thread only. Throws LogError once the writer has failed,
  // std::invalid_argument if the joint counts differ.
  void append(const LogRow& row);

  // Writes the remaining rows and the wall times (root attributes wall_start_up, wall_loop,
  // wall_writing), then replaces the log and removes the journal. Returns `wall` with `writing`
  // filled in. Throws LogError if anything could not be written. In a continued log, the wall times
  // are sums over its runs, or NaN if one of them was killed. `ending`: text of the root attribute
  // of that name, which a log that goes on loses; empty: none.
  WallTimes close(WallTimes wall = {}, const std::string& ending = {});

  long steps() const noexcept;  // in the log so far, including those found by append_to()

 private:
  friend bool recover_log(const std::filesystem::path& log);
  struct Writer;
  explicit RunLog(std::unique_ptr<Writer> writer);
  std::unique_ptr<Writer> writer_;
};

// Completes the log of a killed run from its journal, which is then removed. Returns false if there
// is nothing to recover. The caller must ensure that no other process writes the log. Throws
// InputError if a file is not what it should be, LogError if the log cannot be written.
bool recover_log(const std::filesystem::path& log);

// The disk space that a run needs while it lasts, at most [bytes]: journal, log and results.
double log_bytes(const RunLogHeader& header, double seconds);

// The following do not read the rows, and change nothing.

// True for a log that impedraw wrote.
bool is_marked_log(const std::filesystem::path& file);
// The root attribute that RunLog::close() writes last: how the run ended.
inline constexpr const char* kEndingAttribute = "ending";

// The text attributes of a log's root. Throws InputError if the file is no HDF5 file.
std::map<std::string, std::string> log_attributes(const std::filesystem::path& log);
// True if the log or its journal holds a step. Throws InputError if the file is no log.
bool has_steps(const std::filesystem::path& log);

}  // namespace impedraw
