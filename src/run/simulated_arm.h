// The simulated world as a driver, in lock-step: the arm with its true masses and drives, its pen
// on the true canvas, the wrench sensor, and the scenario's disturbances (loop_sources.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/experiment/prepare.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/run/draw_into.h"
#include "impedraw/run/driver.h"
#include "impedraw/run/loop_sources.h"
#include "impedraw/run/simulated_cameras.h"
#include "impedraw/simulation/joint_sensor.h"
#include "impedraw/simulation/world.h"
#include "impedraw/simulation/wrench_sensor.h"

namespace impedraw {

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
  const std::vector<CameraCorrection>& camera_corrections_;
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
                  const DriverMaker& make_driver = {}, const FolderLock* held = nullptr);

// Like prepare(), and prepare_plan() with Unreachable::tell whose control is set up, too, with a
// progress line on a terminal.
Prepared prepare_visibly(const Scenario& scenario, const Places& places);
PreparedPlan prepare_plan_visibly(const Scenario& scenario, const Places& places);

}  // namespace impedraw
