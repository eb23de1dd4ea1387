#include "impedraw/experiment/experiment.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include "impedraw/arm/arm_model.h"
#include "impedraw/common/per_joint.h"
#include "impedraw/control/impedance.h"
#include "impedraw/experiment/plan_notes.h"
#include "impedraw/settings/setting_error.h"
#include "impedraw/simulation/describe_world.h"
#include "impedraw/simulation/joint_springs.h"

namespace impedraw {
namespace {

// The rotor inertia that the arm's model may lack, or have too much of, by what the law bears.
//
// Rehearsal   the set-up's own controller and joint estimator hold the pen on a plane across it:
//               M' v̇ + C v + g = τ(t − delay) + Jᵀ F,     M' = M + diag(unknown)
//             With joint springs, τ(t − delay) is what the arm's torque loop is told.
//             F: of a tip spring, as late as the set-up says. No friction and no noise: what is
//             left of a kick is the loop's own.
// Borne       at most kMostLeft of the joints' motion is left 0.8 s after it
struct RotorRehearsal {
  ControlSetup setup;  // complete
  JointVector q;       // where the pen is on the drawing [rad]
  double delay = 0.0;  // of the torque [s]
  JointSpringSettings springs{};
  bool lifted = false;  // the pen hangs in the air
};

constexpr double kMostLeft = 0.7;
constexpr double kMostRotor = 2.0;     // [kg m²]
constexpr double kHeight = 5e-4;       // of the tip above the plane at first [m]
constexpr double kLifted = 0.1;        // and of a pen that is to hang there [m]
constexpr double kSettled = 0.6;       // then the kick [s]
constexpr double kTime = 0.8;          // after it [s]
constexpr double kWindow = 0.1;        // at both ends of it [s]
constexpr double kKick = 0.02;         // of every joint, up and down in turn [rad/s]
constexpr double kTooFast = 10.0;      // of a joint: it is lost [rad/s]
constexpr double kLeastRotor = 0.005;  // that is asked about [kg m²]

constexpr double kLost = 1e3;  // left

// As it was some steps ago.
template <class T>
T late(std::deque<T>* line, const T& now, double time, double dt) {
  line->push_back(now);
  if (static_cast<long>(line->size()) > std::lround(time / dt) + 1) line->pop_front();
  return line->front();
}

// The share of a kick that is left; more than 1 for a motion that grows. unknown: true rotor
// inertia less the model's, per joint [kg m²].
double kick_left(const RotorRehearsal& rehearsal, ArmModel arm, const Eigen::VectorXd& unknown) {
  const ControlSetup& setup = rehearsal.setup;
  const ImpedanceSettings& s = setup.impedance;
  const double dt = s.timing.dt;
  const int n = arm.joints();
  ImpedanceController controller(s, n);
  std::optional<JointStateEstimator> estimator;
  if (setup.joint_estimator) estimator.emplace(*setup.joint_estimator, n);
  ArmTerms truth(n), seen(n);
  JointVector q = rehearsal.q, v = JointVector::Zero(n);
  arm.compute(q, v, &truth);
  TipReference reference;
  reference.n_WD = -truth.X_WE.R.col(2);
  const Eigen::Vector3d n_W = reference.n_WD;
  const Eigen::Vector3d p_WS = truth.X_WE.p - (rehearsal.lifted ? kLifted : kHeight) * n_W;
  reference.p_WD = rehearsal.lifted ? truth.X_WE.p : p_WS;
  reference.pen_down = !rehearsal.lifted;
  SurfaceEstimate surface{SurfaceStatus::ok, n_W, 0.0};
  const double k =
      s.tip.stiffness > 0.0 ? s.tip.stiffness : s.stability_check.contact_stiffness_max;
  const double b = 2e-3 * k;
  std::deque<JointVector> torques, positions, velocities;
  std::deque<Wrench> wrenches;
  Wrench F = Wrench::Zero();
  const auto steps = [dt](double time) { return std::lround(time / dt); };
  const long kick = steps(kSettled), end = kick + steps(kTime), window = steps(kWindow);
  std::optional<JointSprings> springs;
  if (rehearsal.springs.on()) {
    const JointVector none = JointVector::Zero(n);
    springs.emplace(rehearsal.springs, none, GearFriction({}, none), dt);
    springs->reset(q, v, truth.g);
  }
  double first = 0.0, last = 0.0;
  for (long i = 0; i < end; ++i) {
    if (i == kick)
      for (int j = 0; j < n; ++j) v[j] += j % 2 ? -kKick : kKick;
    const Wrench F_seen = late(&wrenches, F, s.timing.wrench_delay - dt, dt);
    if (estimator) {
      estimator->update(late(&positions, q, setup.joint_estimator->sensor_delay, dt));
      arm.compute(estimator->q(), estimator->v(), &seen);
    } else {
      arm.compute(q, late(&velocities, v, s.timing.velocity_age, dt), &seen);
    }
    surface.distance = n_W.dot(seen.X_WE.p - p_WS);
    const JointVector& tau = controller.step(seen, reference, surface, F_seen).tau;
    if (estimator) estimator->commanded(seen, F_seen, tau, controller.space());
    arm.compute(q, v, &truth);
    JointMatrix M = truth.M;
    M.diagonal() += unknown;
    const JointVector acts = late(&torques, tau, rehearsal.delay, dt);
    const double depth = -n_W.dot(truth.X_WE.p - p_WS), rate = -n_W.dot(truth.V_WE.head<3>());
    const double f = depth > 0.0 ? std::max(0.0, k * depth + b * rate) : 0.0;
    F << f * n_W, Eigen::Vector3d::Zero();
    JointVector excess = truth.J.transpose() * F - truth.Cv - truth.g;
    if (springs) {
      M.diagonal() += dt * springs->link_damping();
      excess += springs->begin(acts, q, v) - springs->link_damping().cwiseProduct(v);
    } else {
      excess += acts;
    }
    v += dt * M.ldlt().solve(excess);
    q += dt * v;
    if (springs) springs->finish(v);
    if (!v.allFinite() || v.cwiseAbs().maxCoeff() > kTooFast) return kLost;
    const double motion = v.squaredNorm();
    if (i >= kick && i < kick + window) first += motion;
    if (i >= end - window) last += motion;
  }
  return std::sqrt(last / first);
}

// The greatest unknown rotor inertia, the same on every joint, up to which every kick dies away
// [kg m²]; 0 if the least that is asked about is not borne; at most kMostRotor.
double rotor_inertia_borne(const RotorRehearsal& rehearsal, const ArmModel& arm) {
  const auto holds = [&](double x) {
    return kick_left(rehearsal, arm, Eigen::VectorXd::Constant(arm.joints(), x)) <= kMostLeft;
  };
  double borne = 0.0;
  for (double x = kLeastRotor; x <= kMostRotor && holds(x); x *= 1.25) borne = x;
  return borne;
}

// For a simulated arm, throws InputError if its true rotors differ from the model's by more than
// the law bears. A note says what the law bears, for an arm whose rotors differ or are not
// simulated.
void check_rotors(const Scenario& s, const ControlSetup& setup, const ArmModel& arm,
                  const Eigen::VectorXd& q, std::vector<std::string>* notes,
                  const SettingErrors& setting_errors) {
  const bool simulated = s.arm.driver == ArmDriver::sim;
  Eigen::VectorXd unknown = Eigen::VectorXd::Zero(arm.joints());
  if (simulated && !s.world.errors.rotor_inertia.empty())
    unknown = per_joint("world.errors.rotor_inertia", s.world.errors.rotor_inertia, arm.joints()) -
              arm.rotor_inertia();
  if (!s.control.check_rotors || (simulated && unknown.isZero())) return;
  const RotorRehearsal rehearsal{setup, q, simulated ? s.world.errors.loop_delay : s.arm.delay};
  const double borne = rotor_inertia_borne(rehearsal, arm);
  const std::string law = fmt::format(
      "with this inertia, wrench and delay, the law bears {:.2g} kg m² of rotor inertia on every "
      "joint beyond arm.rotor_inertia",
      borne);
  if (simulated && kick_left(rehearsal, arm, unknown) > kMostLeft)
    setting_errors.raise(
        {"world.errors.rotor_inertia", "arm.rotor_inertia"},
        fmt::format("world.errors.rotor_inertia: the true rotors differ from arm.rotor_inertia by "
                    "up to {:.2g} kg m²; {}; valid is an arm.rotor_inertia that is nearer, or "
                    "control.check_rotors: false",
                    unknown.cwiseAbs().maxCoeff(), law));
  notes->push_back(law);
}

JointSpringSettings springs_as_stated(const ArmSettings& s, const ArmModel& arm, double softer,
                                      double faster) {
  constexpr double kRotors = 10.0;  // true ones over what a torque loop leaves of them
  JointSpringSettings springs;
  for (const double K : s.joint_stiffness) springs.stiffness.push_back(K / softer);
  springs.loop_bandwidth = faster * s.torque_bandwidth;
  for (const double B : arm.rotor_inertia())
    springs.rotor_inertia.push_back(
        std::min(kSpringRotorRange.highest, s.torque_bandwidth > 0.0 ? kRotors * B : B));
  return springs;
}

// Nothing takes the springs' deflection off readings of the motors' side.
void refuse_motor_readings(const Scenario& s, ArmModel arm, const Eigen::VectorXd& q,
                           const SettingErrors& setting_errors) {
  constexpr double kMost = 2e-4;  // by which weight may shift the tip [m]
  if (s.arm.driver != ArmDriver::sim || !s.world.joint_spring.on()) return;
  const JointSpringValues springs = joint_spring_values(s.world.joint_spring, arm.joints());
  if (!springs.motor_side) return;
  ArmTerms terms(arm.joints());
  arm.compute(q, JointVector::Zero(arm.joints()), &terms);
  const JointVector bent = terms.g.cwiseQuotient(springs.stiffness);
  const double off = (terms.J.topRows<3>() * bent).norm();
  if (off <= kMost) return;
  setting_errors.raise(
      {"world.joint_spring.reading", "world.joint_spring"},
      fmt::format(
          "world.joint_spring.reading: motor: the arm's weight bends joints by up to {:.2g} "
          "mrad behind what is read, which puts the tip {:.2g} mm off, and nothing takes it "
          "off the readings; valid is link, or springs that bend it by {:.1g} mm at most",
          1e3 * bent.cwiseAbs().maxCoeff(), 1e3 * off, 1e3 * kMost));
}

// The springs in an arm's joints, and the torque loop of its own, that the law bears, given what
// the arm is said to have (arm.joint_stiffness, arm.torque_bandwidth).
//
// To the law, a joint with a torque loop is a rigid one with what the loop leaves of its rotor,
// K/ω² (arm.rotor_inertia). The loop's lag, 1.4/ω with the link held, is no delay of the torque:
// told as one, it made the force's deviation twice as large. What springs and loop bear is asked of
// a rehearsal (kick_left): the observer's bandwidth is lowered to the highest with which a kick
// dies away, in the air and on the drawing, with springs and loop as they are said to be, with a
// tenth softer springs and a faster loop, and the other way round.
//
// Lowers setup->impedance.observer.bandwidth as far as that asks for, with a note. Throws
// InputError if no bandwidth does, and for a simulated arm whose motors' side is read while its
// weight bends the springs by more than 0.2 mm at the tip. Else nothing happens for an arm without
// arm.joint_stiffness.
void bear_joint_springs(const Scenario& s, const ArmModel& arm, const Eigen::VectorXd& start_q,
                        const Eigen::VectorXd& q, ControlSetup* setup,
                        std::vector<std::string>* notes, const SettingErrors& setting_errors) {
  constexpr double kStep = 0.8;       // from one bandwidth to the next
  constexpr double kLeast = 5.0;      // that is of use against friction [rad/s]
  constexpr double kOff = 1.1;        // true springs and loop from what is said of them
  constexpr double kMostAfter = 0.4;  // of a kick that may be left after 0.8 s
  refuse_motor_readings(s, arm, q, setting_errors);
  if (s.arm.joint_stiffness.empty()) return;
  const double delay =
      s.arm.driver == ArmDriver::sim ? s.control.torque_delay.value_or(0.0) : s.arm.delay;
  double& bandwidth = setup->impedance.observer.bandwidth;
  const double asked = bandwidth;
  const auto calm = [&](double softer, double faster) {
    const JointSpringSettings springs = springs_as_stated(s.arm, arm, softer, faster);
    const Eigen::VectorXd links = -arm.rotor_inertia();  // the rotors are before the springs
    return kick_left({*setup, start_q, delay, springs, true}, arm, links) <= kMostAfter &&
           kick_left({*setup, q, delay, springs, false}, arm, links) <= kMostAfter;
  };
  setting_errors.locate({"arm.joint_stiffness", "arm.rotor_inertia"}, [&] {
    joint_spring_values(springs_as_stated(s.arm, arm, 1.0, 1.0), arm.joints());
  });
  while (bandwidth >= kLeast &&
         !(calm(1.0, 1.0) && calm(kOff, kOff) && calm(1.0 / kOff, 1.0 / kOff)))
    bandwidth *= kStep;
  const std::string law =
      fmt::format("with joints of {:.3g} Nm/rad and a torque loop of {:.3g} rad/s",
                  s.arm.joint_stiffness[0], s.arm.torque_bandwidth);
  if (bandwidth < kLeast)
    setting_errors.raise(
        {"arm.torque_bandwidth", "arm.joint_stiffness", "control"},
        fmt::format("arm.joint_stiffness: {}, the law does not calm down after a kick, with any "
                    "bandwidth of its observer; valid is a faster torque loop, or less of "
                    "control.stiffness_tangent, rotational_stiffness_tangent and damping_ratio",
                    law));
  if (bandwidth < asked)
    notes->push_back(fmt::format("{}, the law bears an observer of {:.3g} rad/s instead of {:.3g}",
                                 law, bandwidth, asked));
}

}  // namespace

ControlSetup control_for(PlannedDrawing* drawing, const Places& places) {
  const Scenario& given = drawing->scenario;
  ControlSettings& s = drawing->scenario.control;
  // The force tells more than the cloud does of rough ground, and of the surface under a pad. A
  // canvas that moves is followed better by the estimate alone.
  const bool feels =
      drawing->plan.rough || (given.tool.kind == ToolKind::pad && s.source != WrenchSource::none &&
                              !given.perception.frames.enabled);
  const bool leans = given.path.lean_deg > 0.0;
  if (!s.pen_axis) s.pen_axis = feels || leans ? PenAxis::plan : PenAxis::surface;
  if (!s.normal_error_deg) s.normal_error_deg = feels ? kRoughNormalError : 0.0;
  if (!s.felt_normal.share) s.felt_normal.share = feels ? kRoughFeltShare : 0.0;
  const SettingErrors setting_errors(places);
  ControlSetup control =
      make_control_setup(drawing->scenario, drawing->belief, drawing->plan, setting_errors);
  bear_joint_springs(drawing->scenario, drawing->belief.arm, drawing->belief.start_q,
                     drawing->plan.rest_q, &control, &drawing->plan.notes, setting_errors);
  check_rotors(drawing->scenario, control, drawing->belief.arm, drawing->plan.rest_q,
               &drawing->plan.notes, setting_errors);
  return control;
}

std::vector<std::string> notes_of(const PlannedDrawing& drawing) {
  std::vector<std::string> notes = drawing.artwork.notes;
  notes.insert(notes.end(), drawing.belief.notes.begin(), drawing.belief.notes.end());
  notes.insert(notes.end(), drawing.plan.notes.begin(), drawing.plan.notes.end());
  return notes;
}

}  // namespace impedraw
