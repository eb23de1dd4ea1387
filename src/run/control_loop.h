// The controller and all that feeds it, with the faults that the scenario puts in between.
#pragma once

#include "impedraw/control/impedance.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/experiment/faults.h"
#include "impedraw/experiment/wrench_input.h"

namespace impedraw {

// When that share of the way from the plan's first stroke's start to its last one's end is over
// [s].
double time_at(const Experiment& e, double share);

// The scenario's fault of that kind that is on at that time, or none.
const FaultSettings* fault_at(const Experiment& e, double time, FaultKind kind);

class ControlLoop {
 public:
  // `faults`: whether those of the scenario come; their times are the plan's.
  ControlLoop(Experiment& e, bool faults);

  // One control step on the world as it is. The answer is the controller's own.
  const ImpedanceTorque& step(const World& world, const TipReference& reference) noexcept;

  WrenchInput& wrench() { return wrench_; }
  const Wrench& F_ext() const { return F_ext_; }
  const SurfaceEstimate& surface() const { return surface_; }

 private:
  const FaultSettings* fault(double time, FaultKind kind) const {
    return faults_ ? fault_at(e_, time, kind) : nullptr;
  }

  Experiment& e_;
  bool faults_;
  ImpedanceController controller_;
  WrenchInput wrench_;
  ArmTerms terms_;
  SurfaceEstimate surface_;
  Wrench F_ext_ = Wrench::Zero();
  Eigen::Vector3d n_ = Eigen::Vector3d::UnitZ();  // of the last step
  bool on_surface_ = false;
  JointVector q_, v_;
  double state_time_ = 0.0, wrench_time_ = 0.0;
};

}  // namespace impedraw
