#include "impedraw/experiment/rotor_check.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include "impedraw/common/per_joint.h"
#include "impedraw/control/impedance.h"
#include "impedraw/simulation/joint_springs.h"

namespace impedraw {

namespace {

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

}  // namespace

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

double rotor_inertia_borne(const RotorRehearsal& rehearsal, const ArmModel& arm) {
  const auto holds = [&](double x) {
    return kick_left(rehearsal, arm, Eigen::VectorXd::Constant(arm.joints(), x)) <= kMostLeft;
  };
  double borne = 0.0;
  for (double x = kLeastRotor; x <= kMostRotor && holds(x); x *= 1.25) borne = x;
  return borne;
}

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

}  // namespace impedraw
