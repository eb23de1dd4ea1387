// The control loop: follows an experiment's path with the arm of a driver (driver.h) and logs every
// step.
//
// After the last stroke, parts without ink by the arm's own signals (remaining.h) are redrawn once.
// Parts that still have no ink are reported.
//
// A run lifts the pen before it ends if it is interrupted or its control steps come too late. It
// ends at once if control is lost: the motion went unstable, or the joint state has been bad for
// longer than kBadStateTime. A later run can draw what an interrupted run left (Resumption).
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/experiment/experiment.h"
#include "impedraw/log/log.h"
#include "impedraw/metrics/ending.h"
#include "impedraw/run/drawing_task.h"
#include "impedraw/run/driver.h"
#include "impedraw/run/remaining.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

// One control step of the record of a run's last seconds (run/incident.h).
struct IncidentRow {
  double time = 0.0;         // driver's clock, as in the log [s]
  double force = 0.0;        // on the tip [N]: measured, else the simulator's; NaN: unknown
  double speed = 0.0;        // tip speed [m/s]
  double joint_speed = 0.0;  // largest share of a joint's speed limit
  double torque = 0.0;       // largest share of a joint's torque limit
  double state_age = 0.0;    // age of the joint state [s]
  double step_time = 0.0;    // duration of the control step [s]
};

struct RunProgress {
  double time;  // from the run's beginning, also after a resume [s]
  int stroke;   // number of strokes begun in the pass
  int strokes;
  double drawn;   // pen-down length drawn in the pass, on the surface [m]
  double length;  // total pen-down length of the pass [m]
  double share;   // fraction of the pass's time
  bool again;     // the pass redraws what got no ink in the first pass
  // The pen waits for this, and has waited so long [s]; null: it draws or travels.
  const char* waits_for = nullptr;
  double waited = 0.0;
};

struct RunHooks {
  std::function<void()> begun;  // called once the log is on the disk, before the first step
  std::function<void(const RunProgress&)> progress;  // called every ten control steps
  std::function<bool()> interrupted;                 // polled as often
  // Called after each control step with its row. Must neither wait nor allocate.
  std::function<void(const LogRow&)> row;
  // Asked before each control step, with the driver's time [s], until it returns false: pauses and
  // paces the run. It sleeps a little itself where it returns true. For a driver in lock-step.
  std::function<bool(double)> held;
  // The same for a driver on a wall clock, which cannot wait: while it is true, the plan's clock
  // stands, and the pen keeps its place and its push. Asked in each control step; must not wait.
  std::function<bool()> paused;
  // Called where the drawing asks for a person, with the pen up, and what for: from here on `held`
  // or `paused` is true until the person lets it go on. Empty: the run does not wait there.
  std::function<void(const std::string& asks)> pause;
  // Called when that person has answered elsewhere than where `pause` asked: lets the run go on.
  std::function<void()> go_on;
  // Called when the arm holds another pen, or the length of its pen was found, before it moves on.
  std::function<void(const HeldPen&)> holds_pen;
  // Asked in each control step; must not wait. True: the motion is damped and the run ends where
  // the pen is, without lifting it.
  std::function<bool()> emergency;
  // Called after the run, before its results are made.
  std::function<void()> ended;
};

inline constexpr double kIncidentTime = 2.0;  // [s]

// Noise of a joint's positions that lowered the bandwidth of its velocity's estimate.
struct SlowVelocity {
  double bandwidth = 0.0;  // the lowest of the run [rad/s]
  double noise = 0.0;      // standard deviation of the joint's readings then, as measured [rad]
  int joint = 0;           // with the most noise
};

// Record of the control loop, for the run's outcome.
struct LoopRecord {
  // The reason that the loop's thread has no real-time priority; empty: it has, or needs none.
  std::string not_real_time;
  // Duration of each controller status: limits met, bad inputs [s].
  std::map<std::string, double> met;
  std::optional<SlowVelocity> slow_velocity;
  double stamp_lag = 0.0;  // of frames, as it was found while drawing (stamp_lag.h) [s]
  std::string frames;      // FrameSource::remark()
  std::string silence;     // CanvasWatch's, where the run ends without knowing the canvas
};

// `end` is never nothing_drawn or far_off: those are judged from the log.
struct RunOutcome : Ending, DrawingRecord, LoopRecord {
  std::vector<IncidentRow> last;  // the last kIncidentTime of a stopped run, oldest first
  double simulated = 0.0;         // duration by the driver's clock [s]
  double first_time = 0.0;        // where an earlier run left off [s]
  SolverCutoffs cutoffs;          // a simulator's; zero without ground truth
  // Motions that were damped, and why; the drawing went on beyond each.
  std::vector<std::string> damped;
  // Parts without ink at the end of a finished run.
  std::vector<StrokePart> lacking;
  WallTimes wall;
};

// The state in which an earlier run left the log. The run continues from it.
struct Resumption {
  InkWatch ink;                     // from the log's rows
  JointVector q;                    // last posture [rad]
  bool touches = false;             // the pen was on the canvas then
  Pose X_WK;                        // canvas, as last estimated
  double time = 0.0;                // first free time in the log [s]
  std::optional<HeldPen> pen = {};  // absent: not known; that of the last ink
  struct Score {
    Eigen::Vector3d p_WE, n_W;
    double f_n;  // [N]
  };
  std::vector<Score> scores = {};  // where a cutter found the surface
};

// Reads the state from a log; none if the log has no step. Throws InputError if the log cannot be
// continued.
std::optional<Resumption> read_resumption(const Experiment& experiment,
                                          const std::filesystem::path& log_file);

// Returns true if the pen writes, by contact state and measured force along the estimated normal
// [N] (remaining.h). push: force asked for; 0 where the law has none [N].
bool writes(const Experiment& experiment, ContactMode mode, double normal_force, double push);

// Runs the experiment. The arm must be at the beginning of the plan's path, or at the last posture
// of a resumption. Streams to `log_file`; empty: keeps no log. start_up: wall time already spent
// [s]. Throws LogError if the log cannot be written, InputError if the driver does not match the
// arm, and what Driver::start() throws.
RunOutcome run(const Experiment& experiment, Driver& driver, const std::filesystem::path& log_file,
               double start_up, const RunHooks& hooks = {}, const Resumption* resumption = nullptr);

}  // namespace impedraw
