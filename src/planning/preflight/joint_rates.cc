#include "impedraw/planning/preflight/joint_rates.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "impedraw/arm/inverse_kinematics.h"

namespace impedraw {

namespace {

constexpr double kRelax = 0.05;  // tip path over which the redundant joints settle [m]

}  // namespace

JointRates::JointRates(ArmModel& arm, const PathSettings& settings, const JointVector& start_q,
                       const JointVector& rest_q)
    : arm_(&arm),
      X_WP_(settings.X_WP),
      vertical_pen_(settings.vertical_pen),
      limit_(settings.joint_speed_share * arm.limits().speed),
      rest_(rest_q),
      q_(start_q),
      terms_(arm.joints()) {}

// Moves q_ to the pen placement at a point of the spline; the redundant joints relax towards rest.
bool JointRates::follow(const SplinePoint& at, double moved) {
  arm_->compute(q_, JointVector::Zero(q_.size()), &terms_);
  const TipJacobian& J = terms_.J;
  const JointVector d = rest_ - q_;
  const Matrix6 A = J * J.transpose() + 1e-9 * Matrix6::Identity();
  const JointVector drift = d - J.transpose() * A.llt().solve(J * d);
  const JointVector seed = q_ + (1.0 - std::exp(-moved / kRelax)) * drift;
  const Eigen::Vector3d n = vertical_pen_ ? Eigen::Vector3d(Eigen::Vector3d::UnitZ()) : at.n;
  IkSettings settings;
  settings.position_tolerance = settings.axis_tolerance = 1e-7;
  settings.max_steps = 40;
  settings.posture_gain = 0.0;
  const IkResult found = find_posture(*arm_, {X_WP_ * at.p, -(X_WP_.R * n)}, seed, settings);
  if (found.reached) q_ = found.q;
  return found.reached;
}

void JointRates::operator()(const PathSpline& spline, std::vector<SpeedSpan>* spans) {
  bool known = follow(spline.at(0.0), kRelax);
  // Settle: the arm comes from elsewhere.
  for (int i = 0; known && i < 5; ++i) known = follow(spline.at(0.0), kRelax);
  const int steps = std::max(1, static_cast<int>(std::ceil(spline.length() / kStep)));
  const double du = spline.length() / steps;
  std::size_t span = 0;
  JointVector before = q_;
  for (int k = 1; k <= steps; ++k) {
    const double u = k * du;
    const bool reached = follow(spline.at(u), du);
    double speed = 1e9;
    if (known && reached) {
      const double fastest = ((q_ - before).cwiseAbs().array() / limit_.array()).maxCoeff() / du;
      if (fastest > 0.0) speed = 1.0 / fastest;
    }
    before = q_;
    known = reached;
    // Every span that the step meets.
    while (span > 0 && spline.start(span) > u - du) --span;
    for (; span < spans->size() && spline.start(span) < u; ++span)
      (*spans)[span].speed = std::min((*spans)[span].speed, speed);
    if (span > 0) --span;
  }
}

}  // namespace impedraw
