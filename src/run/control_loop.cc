#include "impedraw/run/control_loop.h"

#include <utility>

#include <fmt/format.h>

namespace impedraw {
namespace {

const char* name_of(WrenchReading wrench) {
  static constexpr const char* kNames[] = {"no wrench", "a sensor's reading",
                                           "the wrench at the tip"};
  return kNames[static_cast<std::size_t>(wrench)];
}

void require_fit(const ControlSetup& setup, int joints, const DriverInfo& driver) {
  if (driver.joints != joints)
    throw InputError(
        fmt::format("driver: its arm has {} joints, the model {}", driver.joints, joints));
  if (!(std::abs(driver.period - setup.impedance.timing.dt) <= 1e-9))
    throw InputError(fmt::format("driver: its period is {} s, the controller's step {} s",
                                 driver.period, setup.impedance.timing.dt));
  if (!driver.velocity && !setup.joint_estimator)
    throw InputError(
        "driver: it gives no joint velocities, control.joint_sensing.velocity must be estimated");
  const WrenchReading needed = setup.source == WrenchSource::none ? WrenchReading::none
                               : has_sensor(setup.source)         ? WrenchReading::sensor
                                                                  : WrenchReading::tip;
  if (needed != WrenchReading::none && driver.wrench != needed)
    throw InputError(fmt::format("driver: it gives {}, control.wrench needs {}",
                                 name_of(driver.wrench), name_of(needed)));
}

}  // namespace

ControlLoop::ControlLoop(const ControlSetup& setup, const ArmModel& arm, const DriverInfo& driver,
                         SurfaceSource surface, CanvasSource canvas)
    : arm_(arm),
      surface_source_(std::move(surface)),
      canvas_(std::move(canvas)),
      controller_(setup.impedance, arm.joints()),
      period_(driver.period),
      coupled_(setup.impedance.inertia != InertiaShaping::shaped),
      terms_(arm.joints()),
      felt_height_(setup.impedance.surface.drawing_axis_W) {
  require_fit(setup, arm.joints(), driver);
  if (has_sensor(setup.source)) estimator_.emplace(setup.estimator);
  if (setup.joint_estimator) joint_estimator_.emplace(*setup.joint_estimator, arm.joints());
  if (setup.touch) touch_.emplace(setup.touch->settings, setup.touch->model);
  if (setup.cut) depth_.emplace(*setup.cut, driver.period);
}

const ImpedanceTorque& ControlLoop::step(const ArmState& state,
                                         const TipReference& given) noexcept {
  update_arm(state);
  canvas_.update(state.time);
  update_wrench(state);
  avoid_canvas(given, state.time);
  TipReference reference = hit_.of(keep_away_.of(on_canvas(given)));
  const Eigen::Vector3d& p_WE = terms_.X_WE.p;
  const bool ahead = coupled_ && on_surface();
  const Eigen::Vector3d query = ahead ? surface_query(p_WE, reference.p_WD, n_) : p_WE;
  if (surface_source_) {
    const FrameMotion* const carrier = canvas_.carrier();
    if (carrier) {
      surface_ = carried(surface_source_(carrier->X_WK.inverse() * query, state.time), *carrier);
      if (canvas_.lost()) surface_.status = SurfaceStatus::too_few;
    } else if (canvas_.follows()) {
      surface_ = {};  // the pen is up, and watches
    } else {
      surface_ = surface_source_(query, state.time);
    }
  } else if (touch_) {
    touch_->update(terms_.X_WE, terms_.V_WE, F_ext_.head<3>(), reference.pen_down);
    surface_ = touch_->estimate_at(query);
  }
  if (depth_) {
    const Eigen::Matrix3d R_KW = canvas_.pose().R.transpose();
    reference.force = depth_->force(reference, X_KE().p, R_KW * n_, n_.dot(F_ext_.head<3>()),
                                    mode_ == ContactMode::contact);
  }
  const InputAges ages{state.time - state.state_time, state.time - wrench_time_};
  const ImpedanceTorque& out =
      controller_.step(terms_, reference, surface_, F_ext_, ages, canvas_.carrier());
  if (joint_estimator_) joint_estimator_->commanded(terms_, F_ext_, out.tau, controller_.space());
  mode_ = out.mode;
  n_ = out.n_WD;
  if (surface_source_ && !canvas_.follows()) felt_height_.update(surface_, mode_, period_);
  return out;
}

// A lifted pen retreats from a canvas that is followed: as it is seen to come, and as it hits.
void ControlLoop::avoid_canvas(const TipReference& given, double time) noexcept {
  if (!canvas_.follows() || !surface_source_) return;
  hit_.update(F_ext_.head<3>(), !given.pen_down && mode_ == ContactMode::free, period_);
  if (canvas_.joined()) return keep_away_.reset();
  keep_away(time);
}

// The reference in W.
TipReference ControlLoop::on_canvas(const TipReference& given) noexcept {
  TipReference reference = canvas_.in_world(given);
  if (!canvas_.follows()) reference = felt_height_.of(reference);
  if (canvas_.joined())
    return soft_.of(reference, !given.pen_down && mode_ == ContactMode::free, period_);
  soft_.reset();
  return reference;
}

void ControlLoop::keep_away(double time) noexcept {
  const CanvasEstimate& canvas = canvas_.estimate();
  SurfaceEstimate surface;
  if (canvas.status == CanvasStatus::ok || canvas.status == CanvasStatus::undetermined)
    surface =
        carried(surface_source_(canvas.motion.X_WK.inverse() * terms_.X_WE.p, time), canvas.motion);
  keep_away_.update(surface, canvas.motion.velocity_at(terms_.X_WE.p), period_);
}

// The arm's terms, at the measured or the estimated state.
void ControlLoop::update_arm(const ArmState& state) noexcept {
  if (!joint_estimator_) return arm_.compute(state.q, state.v, &terms_);
  // Cycles in which the previous step was still running have held its torque.
  const double cycles = std::round((state.time - time_) / period_);
  const int steps = cycles >= 1.0 && cycles < 1e4 ? static_cast<int>(cycles) : 1;
  if (state.state_time != state_time_)
    joint_estimator_->update(state.q, steps);
  else
    joint_estimator_->coast(steps);
  time_ = state.time;
  state_time_ = state.state_time;
  // The estimator ignores a reading that is not finite, but the controller must see it.
  if (state.q.allFinite() && state.v.allFinite())
    arm_.compute(joint_estimator_->q(), joint_estimator_->v(), &terms_);
  else
    arm_.compute(state.q, state.v, &terms_);
}

const ImpedanceTorque& ControlLoop::brake(const ArmState& state,
                                          const Eigen::Vector3d& v_WD) noexcept {
  update_arm(state);
  update_wrench(state);
  canvas_.update(state.time);
  mode_ = ContactMode::free;
  soft_.reset();
  Eigen::Vector3d v = v_WD;
  if (canvas_.follows() && surface_source_) {
    keep_away(state.time);  // by what cameras see alone: the wrench may be what failed
    v += keep_away_.retreat();
  }
  const ImpedanceTorque& out = controller_.brake(terms_, v);
  if (joint_estimator_) joint_estimator_->commanded(terms_, F_ext_, out.tau, controller_.space());
  return out;
}

// Each reading is used once: a repeated one would look as if nothing moved.
void ControlLoop::update_wrench(const ArmState& state) noexcept {
  if (state.wrench_time != wrench_time_) {
    F_ext_ = estimator_ ? estimator_->update(state.wrench, terms_.X_WE, terms_.V_WE) : state.wrench;
    wrench_time_ = state.wrench_time;
  }
  // The estimator ignores a reading that is not finite, but the controller must see it.
  if (!state.wrench.allFinite()) F_ext_.setConstant(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace impedraw
