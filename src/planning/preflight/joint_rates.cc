#include "impedraw/planning/preflight/joint_rates.h"

#include <algorithm>
#include <cmath>

#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/arm/least_energy_step.h"
#include "impedraw/planning/preflight/posture_check.h"

namespace impedraw {

namespace {

// A step that turns a joint by more than kLongTurn [rad] is walked in pieces of kPieceTurn.
constexpr double kLongTurn = 0.05, kPieceTurn = 0.01;
constexpr int kMostPieces = 100;
constexpr double kBendShare = 0.8;  // of acceleration and torque, for the path's bend

}  // namespace

JointRates::JointRates(const ArmModel& arm, const PathSettings& settings,
                       const JointVector& start_q, const JointVector& rest_q,
                       const DrawingLoad& load)
    : arm_(arm),
      X_WP_(settings.X_WP),
      vertical_pen_(settings.vertical_pen),
      yaw_(settings.heading ? std::optional(settings.heading->yaw) : std::nullopt),
      limit_(settings.joint_speed_share * arm.limits().speed),
      acceleration_(settings.joint_acceleration),
      torque_(settings.joint_torque_share * load.torque_share * arm.limits().torque),
      load_(load),
      rest_(rest_q),
      q_(start_q),
      terms_(arm.joints()) {}

PenPlacement JointRates::placement(const SplinePoint& at) const {
  const Eigen::Vector3d n = vertical_pen_ ? Eigen::Vector3d(Eigen::Vector3d::UnitZ()) : at.n;
  PenPlacement pen{X_WP_ * at.p, -(X_WP_.R * n)};
  if (yaw_) pen.x_WE = X_WP_.R * turned_about(n, heading_at(at).t, *yaw_);
  return pen;
}

// Moves q_ to the pen placement at a point of the spline as the controller does: by the motion of
// least kinetic energy, q̇ = J̄ V, without turning about the pen; the redundant joints relax towards
// rest.
bool JointRates::follow(const SplinePoint& at, double moved) {
  constexpr int kMostSteps = 12;
  constexpr double kReached = 1e-7;  // [m], [rad]
  const PenPlacement pen = placement(at);
  JointVector q = q_;
  double relax = 1.0 - std::exp(-moved / kRelax);
  for (int i = 0; i < kMostSteps; ++i) {
    arm_.compute(q, JointVector::Zero(q.size()), &terms_);
    const Vector6 off = tip_displacement(terms_.X_WE, pen.p_WE, pen.z_WE, pen.x_WE);
    if (i > 0 && off.cwiseAbs().maxCoeff() < kReached) {
      q_ = q;
      return true;
    }
    // A share of the way at each posture, as it is stable for any; over one stroke it winds nothing
    // up.
    const JointVector pull = terms_.M * (relax * (rest_ - q));
    const LeastEnergyStep step = least_energy_step(terms_, off, pull, 1e-9);
    q += step.task + step.redundant;
    relax = 0.0;
  }
  return false;
}

void JointRates::operator()(const PathSpline& spline, std::vector<SpeedSpan>* spans) {
  // The arm comes from elsewhere, and settles.
  const SplinePoint first = spline.at(0.0);
  const PenPlacement at_first = placement(first);
  IkResult begun = find_posture(arm_, at_first, q_);
  // The part before may have wound the joints up beyond their limits.
  if (!begun.reached) begun = find_posture(arm_, at_first, rest_);
  q_ = begun.q;
  bool known = follow(first, kRelax);
  for (int i = 0; known && i < 5; ++i) known = follow(spline.at(0.0), kRelax);
  const int steps = std::max(1, static_cast<int>(std::ceil(spline.length() / kStep)));
  const double du = spline.length() / steps;
  std::vector<double> steepest(spans->size(), 0.0), sharpest(spans->size(), 0.0);
  // of a joint's torque that is left, per u̇² and per ü
  std::vector<double> torque_of_speed(spans->size(), 0.0), torque_of_thrust(spans->size(), 0.0);
  std::size_t span = 0;
  JointVector before = q_, slope_before = JointVector::Zero(q_.size()),
              slope_earlier = slope_before;
  int slopes_known = 0;
  for (int k = 1; k <= steps; ++k) {
    const double u = k * du;
    bool reached = follow(spline.at(u), du);
    double speed = 1e9, slope_most = 0.0, bend_most = 0.0, of_speed = 0.0, of_thrust = 0.0;
    if (known && reached) {
      JointVector steepest_slope = (q_ - before).cwiseAbs() / du;
      // Near a singular posture the joints turn by much within the step, and not evenly: slope and
      // bend there are those of the pieces.
      const double turned = du * steepest_slope.maxCoeff();
      if (turned > kLongTurn) {
        const int pieces = std::min(kMostPieces, static_cast<int>(std::ceil(turned / kPieceTurn)));
        q_ = before;
        JointVector q = before, slope_of_last;
        for (int i = 1; reached && i <= pieces; ++i) {
          reached = follow(spline.at(u - du + i * du / pieces), du / pieces);
          const JointVector slope = (q_ - q) * pieces / du;
          steepest_slope = steepest_slope.cwiseMax(slope.cwiseAbs());
          if (i > 1)
            bend_most =
                std::max(bend_most, (slope - slope_of_last).cwiseAbs().maxCoeff() * pieces / du);
          slope_of_last = slope;
          q = q_;
        }
      }
      const double share = (steepest_slope.array() / limit_.array()).maxCoeff();
      if (share > 0.0) speed = 1.0 / share;
      slope_most = steepest_slope.maxCoeff();
      const JointVector slope = (q_ - before) / du;
      // over two steps: the bend of less is that of the normals' noise
      const JointVector bend = slopes_known > 1 ? JointVector((slope - slope_earlier) / (2.0 * du))
                                                : JointVector::Zero(slope.size());
      bend_most = std::max(bend_most, bend.cwiseAbs().maxCoeff());
      arm_.compute(q_, slope, &terms_);
      const JointVector left = torque_ - holding_torque(terms_, -(X_WP_.R * spline.at(u).n),
                                                        load_.normal_force, load_.friction);
      if (left.minCoeff() > 0.0) {
        const JointVector speeding = terms_.M * bend + terms_.Cv;
        of_speed = (speeding.cwiseAbs().array() / left.array()).maxCoeff();
        of_thrust = ((terms_.M * slope).cwiseAbs().array() / left.array()).maxCoeff();
      }
      slope_earlier = slope_before;
      slope_before = slope;
      ++slopes_known;
    } else {
      slopes_known = 0;
    }
    before = q_;
    known = reached;
    // Every span that the step meets, and for the bend, the two before.
    const double from = u - 3.0 * du;
    while (span > 0 && spline.start(span) > from) --span;
    for (; span < spans->size() && spline.start(span) < u; ++span) {
      (*spans)[span].speed = std::min((*spans)[span].speed, speed);
      steepest[span] = std::max(steepest[span], slope_most);
      sharpest[span] = std::max(sharpest[span], bend_most);
      torque_of_speed[span] = std::max(torque_of_speed[span], of_speed);
      torque_of_thrust[span] = std::max(torque_of_thrust[span], of_thrust);
    }
    if (span > 0) --span;
  }
  for (std::size_t i = 0; i < spans->size(); ++i) {
    SpeedSpan& limited = (*spans)[i];
    if (sharpest[i] > 0.0)
      limited.speed = std::min(limited.speed, std::sqrt(kBendShare * acceleration_ / sharpest[i]));
    if (torque_of_speed[i] > 0.0)
      limited.speed = std::min(limited.speed, std::sqrt(kBendShare / torque_of_speed[i]));
    const double squared = limited.speed * limited.speed;
    if (steepest[i] > 0.0)
      limited.acceleration =
          std::min(limited.acceleration, (acceleration_ - sharpest[i] * squared) / steepest[i]);
    if (torque_of_thrust[i] > 0.0)
      limited.acceleration = std::min(limited.acceleration,
                                      (1.0 - torque_of_speed[i] * squared) / torque_of_thrust[i]);
  }
}

}  // namespace impedraw
