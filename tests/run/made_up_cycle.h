// A cycle of a made-up arm with one joint, for monitors. A test sets what it is about.
#pragma once

#include "impedraw/run/cycle.h"

namespace impedraw {

struct MadeUpCycle {
  static constexpr double kDt = 1e-3;

  MadeUpCycle() {
    out.tau = JointVector::Zero(1);
    out.terms.setZero(1, kTorqueTerms);
    arm.M.setIdentity(1, 1);
    arm.g.setZero(1);
    arm.v.setZero(1);
  }
  // The next one, 1 ms later.
  Cycle next() {
    const double begin = state.time;
    state.time += kDt;
    return {.time = begin,
            .run_time = begin,
            .dt = kDt,
            .step_time = step_time,
            .desired = desired,
            .arm = arm,
            .F_ext = F_ext,
            .surface = surface,
            .canvas = canvas,
            .out = out,
            .state = &state,
            .truth = nullptr,
            .tared = tared,
            .inked = inked};
  }

  PathSample desired;
  ArmTerms arm{1};
  Wrench F_ext = Wrench::Zero();
  SurfaceEstimate surface;
  CanvasFollower canvas{CanvasSource()};
  ImpedanceTorque out;
  ArmState state{1};
  double step_time = 0.0;
  bool tared = true, inked = false;
};

}  // namespace impedraw
