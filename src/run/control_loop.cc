#include "impedraw/run/control_loop.h"

#include <cmath>

namespace impedraw {

double time_at(const Experiment& e, double share) {
  const auto& strokes = e.path.strokes();
  return strokes.front().start + share * (strokes.back().end - strokes.front().start);
}

const FaultSettings* fault_at(const Experiment& e, double time, FaultKind kind) {
  for (const FaultSettings& fault : e.scenario.faults) {
    const double start = time_at(e, fault.start);
    if (fault.kind == kind && time >= start && time < start + fault.duration) return &fault;
  }
  return nullptr;
}

ControlLoop::ControlLoop(Experiment& e, bool faults)
    : e_(e),
      faults_(faults),
      controller_(e.control, e.arm.joints()),
      wrench_(e.scenario.control.source, e.estimator, e.sensor, e.control.timing.dt,
              static_cast<std::uint64_t>(e.scenario.seed)),
      terms_(e.arm.joints()),
      q_(e.start_q),
      v_(JointVector::Zero(e.arm.joints())) {}

const ImpedanceTorque& ControlLoop::step(const World& world,
                                         const TipReference& reference) noexcept {
  const double t = world.state().time;
  wrench_.sample(world);
  InputAges ages;
  if (!fault(t, FaultKind::stale_state)) {
    q_ = world.state().q;
    v_ = world.state().v;
    state_time_ = t;
  }
  ages.state = t - state_time_;
  if (fault(t, FaultKind::nan_state)) v_[0] = std::nan("");

  e_.arm.compute(q_, v_, &terms_);
  if (e_.perception) {
    const bool coupled = e_.control.inertia != InertiaShaping::shaped;
    surface_ = e_.perception->estimate(
        coupled && on_surface_ ? surface_query(terms_.X_WE.p, reference.p_WD, n_) : terms_.X_WE.p);
  }
  if (e_.perception && fault(t, FaultKind::no_cloud)) surface_.status = SurfaceStatus::too_few;
  if (!fault(t, FaultKind::stale_wrench)) {
    F_ext_ = wrench_.estimate(terms_.X_WE, terms_.V_WE);
    wrench_time_ = t;
  }
  ages.wrench = t - wrench_time_;
  if (fault(t, FaultKind::nan_wrench)) F_ext_[2] = std::nan("");
  const ImpedanceTorque& out = controller_.step(terms_, reference, surface_, F_ext_, ages);
  on_surface_ = out.mode == ContactMode::approach || out.mode == ContactMode::contact;
  n_ = out.n_WD;
  return out;
}

}  // namespace impedraw
