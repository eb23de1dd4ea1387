#include "impedraw/experiment/control_setup.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "impedraw/control/contact_stability.h"
#include "impedraw/control/damping.h"
#include "impedraw/control/describe_control.h"
#include "impedraw/control/impedance.h"
#include "impedraw/sensing/touch_surface.h"

namespace impedraw {
namespace {

// Settings that the controller's checks look at, the likeliest culprit first.
std::vector<std::string> control_setting_names() {
  std::vector<std::string> names;
  for (const char* name : {"wrench", "inertia", "mass_normal", "contact_stiffness_max",
                           "damping_ratio", "stiffness_normal", "stiffness_tangent"})
    names.push_back(std::string("control.") + name);
  names.push_back("control");
  return names;
}

// A joint's observer.yield_limit where none is given: its dry friction. A hand exceeds it.
constexpr double kFrictionShare = 0.005;  // of the joint's torque limit
constexpr double kLeastFriction = 1.5;    // [Nm]

// Error that cameras which agree may share, by the scale of their depths or by their places: the
// first touch is looked for so far above and beneath the surface as seen [m].
constexpr double kCamerasErr = 0.01;

// A session with a real arm lets 900 Nm/s pass: the law stays below, so that it knows of the limit.
constexpr double kRealTorqueRate = 850.0;  // [Nm/s]

// Bound for a real arm's momentum observer: its bandwidth times the loop's delay. Where rotor
// inertia is not in the model, what the observer adds is itself a part of what it sees, with a
// share of nearly 1 on a light wrist: through the delay that loop rings. With 0.1 kg m² and 2 ms,
// 200 rad/s shook the wrist until the session ended; 50 rad/s and 20 rad/s did not.
constexpr double kRealObserver = 0.1;

// Greatest ratio of the true forces across a cut to the modelled ones.
constexpr double kCutSpread = 1.2;

// Stiffness of a led heading, where no rotational_stiffness_normal is given [Nm/rad].
constexpr double kHeadingStiffness = 30.0;

// The stiffest pad that the force loop must bear, over the modelled one.
constexpr double kPadSpread = 2.0;

// |n·z| below which a face keeps to the plan's own height. It sinks into the surface by tenths of a
// millimetre more or less than planned, and seen along z that would be as much over |n·z| along it.
constexpr double kFaceAxisCosine = 0.5;

double torque_rate(const Scenario& s, const ArmLimits& limits) {
  const double rate = std::min(s.control.torque_rate, limits.torque_rate);
  return s.arm.driver == ArmDriver::sim ? rate : std::min(rate, kRealTorqueRate);
}

ImpedanceSettings impedance_settings(const Scenario& s, const Belief& belief, const Plan& plan,
                                     double wrench_delay, const std::optional<CutForces>& cut) {
  const ArmLimits& limits = belief.arm.limits();
  ImpedanceSettings settings = s.control;
  settings.timing.dt = s.world.dt;
  settings.wrench =
      s.control.source == WrenchSource::none ? WrenchFeedback::none : WrenchFeedback::measured;
  settings.timing.wrench_delay = wrench_delay;
  settings.timing.loop_delay = std::max(s.control.torque_delay.value_or(0.0),
                                        s.arm.driver == ArmDriver::sim ? 0.0 : s.arm.delay) +
                               settings.timing.dt;
  const auto pad = face_of(s);
  if (pad) {
    // Its face lies on the surface at E, and it is softer than a pen.
    settings.tip = {0.0, 0.0};
    settings.surface.min_axis_cosine = kFaceAxisCosine;
    settings.contact.deepest += pad->thickness;
    settings.stability_check.contact_stiffness_max = std::min(
        settings.stability_check.contact_stiffness_max, kPadSpread * pad->stiffness * pad->area());
  }
  settings.surface.pen_axis = s.control.pen_axis.value_or(PenAxis::plan);
  settings.friction.normal_error_deg = s.control.normal_error_deg.value_or(0.0);
  settings.observer = s.control.observer;
  if (s.control.observer.bandwidth) settings.observer.bandwidth = *s.control.observer.bandwidth;
  const GivenFeltNormal& felt = s.control.felt_normal;
  settings.felt_normal = {felt.share.value_or(0.0), felt.deviation, felt.force_error};
  if (pad && is_led(s.tool)) {
    double& stiffness = settings.stiffness.angular.normal;
    if (!(stiffness > 0.0)) stiffness = kHeadingStiffness;
    settings.friction.coefficient = std::min(kFrictionRange.highest, kCutSpread * pad->friction);
    settings.felt_normal.share = 0.0;
    // An edge that stands across its way is pushed aside.
    if (s.tool.yaw_deg != 0.0)
      settings.friction.normal_error_deg =
          std::min(kNormalErrorRange.highest,
                   std::atan(kCutSpread * pad->friction_across) * 180.0 / std::numbers::pi);
  }
  if (cut) {
    // The cut explains a part of the measured wrench, and the push sinks the tip into it.
    settings.tip.stiffness = cut->normal / s.tool.depth;
    settings.contact.deepest += s.tool.depth;
    settings.friction.coefficient = kCutSpread * cut->drag / cut->normal;
    settings.friction.normal_error_deg =
        std::min(kNormalErrorRange.highest,
                 std::atan(kCutSpread * cut->side / cut->normal) * 180.0 / std::numbers::pi);
    settings.felt_normal.share = 0.0;  // it would take the cut's side force for a slope
  }
  settings.surface.drawing_axis_W = plan.path_settings.X_WP.R.col(2);
  settings.limits.torque = s.control.torque_share * limits.torque;
  settings.limits.joint_speed = s.control.joint_speed_share * limits.speed;
  settings.limits.torque_rate =
      Eigen::VectorXd::Constant(limits.torque.size(), torque_rate(s, limits));
  if (s.arm.driver != ArmDriver::sim)
    settings.observer.bandwidth =
        std::min(settings.observer.bandwidth, kRealObserver / settings.timing.loop_delay);
  if (settings.observer.yield_limit.empty())
    for (const double torque : limits.torque)
      settings.observer.yield_limit.push_back(
          std::min(std::max(kLeastFriction, kFrictionShare * torque), settings.observer.limit));
  settings.joint_range.lower = limits.lower;
  settings.joint_range.upper = limits.upper;
  settings.null_space.q_0 = plan.rest_q;
  settings.null_space.stiffness = Eigen::Map<const Eigen::VectorXd>(
      s.control.null_stiffness.data(), static_cast<Eigen::Index>(s.control.null_stiffness.size()));
  return settings;
}

// The lighter the pen along the normal, the steadier the force on a rough surface; how light it may
// be, the delay of the wrench decides. Where no mass is given, the default is raised as far as that
// asks for, and so is the part of the arm's own inertia that light_normal leaves. A canvas that
// moves may jerk: a lighter pen hits it, and leaves it, less.
void choose_mass(const ControlSettings& given, bool follows_canvas, ImpedanceSettings* control) {
  constexpr double kMargin = 1.3;        // over the lightest that is stable
  constexpr double kOnAMovingOne = 0.6;  // [kg]
  if (control->wrench == WrenchFeedback::none) return;
  if (control->inertia == InertiaShaping::light_normal && control->inertia_scale < 1.0)
    control->inertia_scale = std::min(
        1.0, kMargin * lightest_stable_scale(control->inertia_scale / kMargin,
                                             control->damping_stiffness().linear.normal, *control));
  if (control->inertia != InertiaShaping::shaped) return;
  double& mass = control->shaped_inertia.linear.normal;
  if (given.mass_normal) {
    mass = *given.mass_normal;
    return;
  }
  if (follows_canvas) mass = std::min(mass, kOnAMovingOne);
  ImpedanceSettings lighter = *control;
  lighter.shaped_inertia.linear.normal /= kMargin;
  const TipGain damping =
      diagonal_damping(lighter.damping_stiffness(), lighter.shaped_inertia, lighter.damping_ratio);
  mass = kMargin *
         lightest_stable_mass(lighter.shaped_inertia.linear.normal, damping.linear.normal, lighter);
}

// Share of a motion that the arm's model may miss, and that an estimated velocity follows late.
constexpr double kUnexplained = 1.0 / 3.0;

double velocity_lag(const JointStateEstimatorSettings& settings, int joints) {
  return kUnexplained * JointStateEstimator(settings, joints).lag();
}

// The lowest bandwidth, from `estimator.least_bandwidth` on, with which the set-up is stable.
double least_stable_bandwidth(ImpedanceSettings control, JointStateEstimatorSettings estimator,
                              int joints) {
  constexpr double kStep = 1.1;
  const double most = estimator.bandwidth;
  for (double b = estimator.least_bandwidth; b < most; b *= kStep) {
    estimator.bandwidth = b;
    control.timing.velocity_lag = velocity_lag(estimator, joints);
    try {
      control.validate_inertia();
      return b;
    } catch (const InputError&) {
    }
  }
  return most;
}

// The controller's knowledge of the joints' sensors, and the estimator that reads them.
void set_up_joint_sensing(const Scenario& s, int joints, const SettingErrors& setting_errors,
                          ControlSetup* setup) {
  const JointSensingSettings& sensing = s.control.joint_sensing;
  TimingSettings& timing = setup->impedance.timing;
  const double delay = sensing.sensor_delay.value_or(s.world.joint_sensor.delay);
  if (sensing.velocity == VelocitySource::measured) {
    setting_errors.locate({"world.joint_sensor.velocity", "control.joint_sensing"}, [&] {
      if (s.world.joint_sensor.velocity == VelocityReading::none)
        throw InputError(
            "world.joint_sensor.velocity: none needs control.joint_sensing.velocity: estimated");
    });
    const double filter = s.world.joint_sensor.velocity_age(timing.dt) - s.world.joint_sensor.delay;
    timing.velocity_age = delay + filter;
    return;
  }
  setting_errors.locate({"control.joint_sensing"}, [&] {
    setup->joint_estimator.emplace(JointStateEstimatorSettings{
        timing.dt, sensing.bandwidth, delay, timing.torque_delay(), sensing.least_bandwidth});
    timing.velocity_lag = velocity_lag(*setup->joint_estimator, joints);
    setup->joint_estimator->least_bandwidth =
        least_stable_bandwidth(setup->impedance, *setup->joint_estimator, joints);
  });
}

}  // namespace

ControlSetup make_control_setup(const Scenario& s, const Belief& belief, const Plan& plan,
                                const SettingErrors& setting_errors) {
  ControlSetup setup;
  setup.source = s.control.source;
  if (cutter_of(s.tool) && (setup.source == WrenchSource::none || !s.perception.enabled))
    setting_errors.raise(
        {"tool.kind", "control.wrench", "perception.enabled"},
        "tool.kind: an engraver holds its depth by what it feels on a surface that "
        "it sees; valid is a measured control.wrench, and perception.enabled true");
  std::optional<CutForces> cut;
  if (const auto cutter = cutter_of(s.tool)) {
    cut = cut_forces(*cutter, s.tool.depth, 0.0, s.path.draw_speed);
    if (kCutSpread * cut->drag > kFrictionRange.highest * cut->normal)
      setting_errors.raise(
          {"tool.half_angle", "path.draw_speed"},
          fmt::format("tool.half_angle: a cone of {:.3g}° meets {:.1f} times as much drag as force "
                      "along its axis, which cannot be told from a wall above {:.1f}; valid is a "
                      "wider cone",
                      s.tool.half_angle_deg, cut->drag / cut->normal,
                      kFrictionRange.highest / kCutSpread));
  }
  if (is_led(s.tool) && (!s.perception.enabled || s.perception.frames.enabled))
    setting_errors.raise(
        {"tool.kind", "perception.enabled", "perception.frames.enabled"},
        "tool.kind: a blade and a roller are led on a surface that is seen and stands; valid is "
        "perception.enabled true and perception.frames.enabled false");
  setup.sensor =
      setup.source == WrenchSource::realistic ? WrenchSensorSettings::realistic() : s.wrench_sensor;
  setup.estimator =
      estimator_settings(s.control.sensing, setup.sensor, s.world.dt, s.world.gravity);
  double wrench_delay = s.world.dt;
  if (s.arm.driver != ArmDriver::sim) wrench_delay += s.arm.wrench_delay;
  if (has_sensor(setup.source)) {
    setting_errors.locate({"control.sensing", "wrench_sensor", "control.wrench"}, [&] {
      require_valid(setup.sensor, s.world.dt);
      wrench_delay += WrenchEstimator(setup.estimator).group_delay();
    });
  }
  setup.impedance = impedance_settings(s, belief, plan, wrench_delay, cut);
  if (const std::vector<double> depths = depths_of(s.tool); cut)
    setup.cut = {setup.impedance.tip.stiffness, depths[0], depths[1]};
  choose_mass(s.control, s.perception.frames.enabled, &setup.impedance);
  set_up_joint_sensing(s, belief.arm.joints(), setting_errors, &setup);
  choose_mass(s.control, s.perception.frames.enabled,
              &setup.impedance);  // an estimated velocity follows late
  if (belief.perception && !s.perception.frames.enabled &&
      setup.impedance.wrench == WrenchFeedback::measured)
    setup.impedance.contact.first_search_distance = setup.impedance.approach.overtravel =
        kCamerasErr;
  if (belief.by_touch()) {
    ImpedanceSettings& control = setup.impedance;
    // An approach begins at the upper level, or lower, and may have to go down to the lower one.
    control.approach.overtravel =
        std::max(control.approach.overtravel, s.blind.top_z - s.blind.plane_z);
    TouchModel model;
    model.dt = control.timing.dt;
    model.drawing_axis_W = control.surface.drawing_axis_W;
    model.tip_radius = control.tip.radius;
    model.tip_stiffness = control.tip.stiffness;
    model.friction = control.friction.coefficient;
    model.touch_force = control.contact.touch_force;
    setup.touch = ControlSetup::Touch{s.blind.touch, model};
    setting_errors.locate({"blind.touch"}, [&] { TouchSurface(s.blind.touch, model); });
  }
  setting_errors.locate(control_setting_names(), [&] {
    ImpedanceController(setup.impedance, belief.arm.joints());
  });  // its checks, before anything is written
  return setup;
}

}  // namespace impedraw
