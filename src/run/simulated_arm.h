// The simulated world as a driver, in lock-step: the arm with its true masses and drives, its pen
// on the true canvas, the wrench sensor, and the scenario's disturbances (loop_sources.h).
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/common/exchange.h"
#include "impedraw/common/seeded_normals.h"
#include "impedraw/experiment/prepare.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/perception/canvas_tracker.h"
#include "impedraw/perception/depth_camera.h"
#include "impedraw/run/draw_into.h"
#include "impedraw/run/driver.h"
#include "impedraw/run/loop_sources.h"
#include "impedraw/simulation/joint_sensor.h"
#include "impedraw/simulation/world.h"
#include "impedraw/simulation/wrench_sensor.h"

namespace impedraw {

// Cameras that keep capturing a canvas that moves: its frames appear at their simulated time.
//
// Camera c exposes its frame k at k / rate + c · skew, at the next cycle of the world. Each mark
// that is in its image, and that neither arm nor canvas hide, is found with noise. The frame
// arrives after `latency`, normally distributed with `latency_jitter` and never before the
// exposure, or, with probability `drop`, never. With perception.frames.depth it has the depth of
// each pixel on the canvas, or on the arm before it.
//
// A second thread renders the depths between exposure and arrival; what it has not begun by then,
// this one does. The images are the same with any number of threads, and with or without
// frames.region_of_interest, which leaves out rays that cannot meet the canvas.
class SimulatedCameras {
 public:
  // Refers to world and canvas. threads: 1 or 2; 0: 2, where the machine has as many.
  SimulatedCameras(const Scenario& scenario, World& world, const Canvas& canvas,
                   const ArmModel& arm, int threads = 0);
  ~SimulatedCameras();
  SimulatedCameras(const SimulatedCameras&) = delete;
  SimulatedCameras& operator=(const SimulatedCameras&) = delete;

  // Once per cycle, at the world's state. lost: what is exposed now never arrives.
  void expose(bool lost) noexcept;
  // The next of the frames that have arrived by `time`. Returns false if there is none. Waits until
  // its depths are rendered.
  bool next(double time, CanvasFrame* frame) noexcept;

 private:
  struct Camera {
    DepthCamera believed, actual;
    std::uint64_t exposed = 0;  // frames
    std::uint64_t seed = 0;
    SeededNormals noise;
  };
  // The data that its image needs stay as it was at the exposure.
  struct Coming {
    double arrives = 0.0;
    CanvasFrame frame;
    bool has_depth = false;
    std::uint64_t seed = 0;
    Pose X_WK;
    PosedBody body;
    std::vector<Capsule> arm;
    DepthImage image;
    // State of the image: whoever turns waiting into begun renders it.
    enum Stage { waiting, begun, done };
    std::atomic<int> stage = done;
  };

  void capture(int camera, double time, bool lost) noexcept;
  bool sees(const DepthCamera& camera, const Eigen::Vector3d& p_W, const Pose& X_WK) const noexcept;
  Coming* unused();
  void render_if_waiting(Coming* coming) const noexcept;
  void render_what_is_queued() noexcept;  // the second thread

  World& world_;
  const Canvas& canvas_;
  ArmModel arm_;
  DepthNoise noise_;
  double depth_scale_, time_stamp_;
  FrameSettings frames_;
  FiducialSettings fiducials_;
  std::vector<Camera> cameras_;
  std::vector<std::unique_ptr<Coming>> all_;
  std::vector<Coming*> unused_, coming_;  // coming_: in order of arrival
  Coming* given_ = nullptr;               // the last that next() gave

  Queue<Coming*, 1024> queue_;
  std::atomic<unsigned> posted_ = 0;  // changes with the queue, and at the end
  std::atomic<bool> ends_ = false;
  std::thread second_;
};

class SimulatedArm : public Driver {
 public:
  // Refers to the drawing, its truth included. start() puts the arm at rest at start_q.
  // first_time: of the run, where an earlier one left off: the canvas's motion goes on from there,
  // and messages count from the first run's beginning [s].
  SimulatedArm(Prepared& drawing, const JointVector& start_q, Disturbances disturbances,
               double first_time = 0.0);

  DriverInfo info() const override;
  void start() override;
  const ArmState& read() noexcept override;
  void command(const JointVector& tau, const JointVector& gravity) noexcept override;
  // Set when the motion becomes unstable (not finite, or faster than any such arm can move), and
  // when a link touches the canvas.
  const std::string& fault() const noexcept override { return fault_; }
  void stop() noexcept override {}
  bool next_frame(CanvasFrame* frame) noexcept override {
    return cameras_ && cameras_->next(world_.state().time, frame);
  }
  const GroundTruth* truth() const noexcept override { return &truth_; }
  void put_in(int number) noexcept override;
  bool true_canvas(double time, FrameMotion* motion) const noexcept override;

 private:
  void read_joints(const WorldState& now) noexcept;
  void read_wrench(double time) noexcept;
  void look_for_faults();
  bool feels_shaft();

  const Scenario& scenario_;
  World& world_;
  const Canvas& canvas_;
  const ArmModel& arm_;
  JointVector start_q_;
  std::vector<std::string> joint_names_;
  double dt_, first_time_;
  Disturbances disturbances_;
  WrenchSource source_;
  WrenchSensorSettings sensor_settings_;
  std::uint64_t seed_;
  std::optional<WrenchSensor> sensor_;
  std::optional<SimulatedCameras> cameras_;  // absent: one snapshot before the run
  JointSensorSettings joint_sensor_settings_;
  std::optional<JointSensor> joint_sensor_;  // absent: exact
  std::vector<int> pushed_links_;            // of disturbances_.link_pushes()
  ArmState state_;
  GroundTruth truth_;
  Vector6 tip_wrench_ = Vector6::Zero();  // true, over the last step, at the previous E
  double stalled_ = 0.0;                  // [s]
  double brushed_ = 0.0;                  // how long the shaft has touched [s]
  std::string fault_;
};

// A drawing that is prepared with its truth, by the simulated arm. Its scenario's pushes and faults
// occur in the first run only, not in a resumed one.

// As run() of run.h. Throws InputError if the scenario names another arm.
RunOutcome run(Prepared& drawing, const std::filesystem::path& log_file, double start_up,
               const RunHooks& hooks = {}, const Resumption* resumption = nullptr);

// As draw_into() of draw_into.h. make_driver: another arm that draws; empty: the simulated one.
Drawing draw_into(const std::filesystem::path& folder, Prepared& drawing, double start_up,
                  bool resume = false, const RunHooks& watch = {},
                  const DriverMaker& make_driver = {});

// Like prepare(), and prepare_plan() with Unreachable::tell whose control is set up, too, with a
// progress line on a terminal.
Prepared prepare_visibly(const Scenario& scenario, const Places& places);
PreparedPlan prepare_plan_visibly(const Scenario& scenario, const Places& places);

}  // namespace impedraw
