#include "impedraw/run/calibrate_tool.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/minimum_jerk.h"

namespace impedraw {

namespace {

constexpr double kMoveTime = 1.5;     // from pose to pose [s]
constexpr double kStiffness = 150.0;  // of each joint [Nm/rad]
constexpr double kTurn = 1.0;         // of each wrist joint from the start posture, at most [rad]
constexpr double kAtRest = 0.05;      // joint speed [rad/s]

// Orientations spread over the ball of wrist turns: a low-discrepancy sequence (Roberts' R3), so
// that any number of poses is well placed.
Eigen::Vector3d wrist_turn(int i) {
  const Eigen::Vector3d step(0.8191725134, 0.6710436067, 0.5497004779);
  Eigen::Vector3d x = 0.5 * Eigen::Vector3d::Ones() + i * step;
  for (double& c : x) c = 2.0 * (c - std::floor(c)) - 1.0;
  return kTurn * x;
}

// Holds the arm by joint stiffness, and averages what the sensor reads.
class Mover {
 public:
  Mover(const ArmModel& arm, Driver& driver)
      : arm_(arm),
        driver_(driver),
        dt_(driver.info().period),
        terms_(arm.joints()),
        state_(&driver.read()) {}

  // From rest to rest, then still for `rest` seconds; the mean reading over the last half of them.
  Vector6 move(const JointVector& from, const JointVector& to, double rest) {
    Vector6 sum = Vector6::Zero();
    int count = 0;
    const long moving = std::lround(kMoveTime / dt_), steps = moving + std::lround(rest / dt_),
               averaging = steps - std::lround(0.5 * rest / dt_);
    for (long k = 0; k < steps; ++k) {
      const MinimumJerk jerk =
          MinimumJerk::at(std::min(1.0, static_cast<double>(k) / moving), kMoveTime);
      const JointVector q_d = from + jerk.share * (to - from);
      const JointVector v_d = jerk.rate * (to - from);
      arm_.compute(state_->q, state_->v, &terms_);
      const JointVector damping = 1.4 * (kStiffness * terms_.M.diagonal()).cwiseSqrt();
      const JointVector tau =
          terms_.g + kStiffness * (q_d - state_->q) + damping.cwiseProduct(v_d - state_->v);
      if (k >= averaging) {
        sum += state_->wrench;
        ++count;
      }
      driver_.command(tau, terms_.g);
      state_ = &driver_.read();
      if (!driver_.fault().empty()) throw std::runtime_error(driver_.fault());
    }
    return sum / count;
  }
  const ArmState& state() const { return *state_; }

 private:
  ArmModel arm_;
  Driver& driver_;
  double dt_;
  ArmTerms terms_;
  const ArmState* state_;
};

JointVector within_range(const JointVector& q, const ArmLimits& limits) {
  const JointVector margin = JointVector::Constant(q.size(), 0.1);
  return q.cwiseMax(JointVector(limits.lower) + margin)
      .cwiseMin(JointVector(limits.upper) - margin);
}

}  // namespace

ToolCalibration calibrate_tool(const Experiment& e, Driver& driver, int poses, double rest) {
  if (driver.info().wrench != WrenchReading::sensor)
    throw InputError("control.wrench: there is no sensor to read; valid are sensor, realistic");
  ArmModel arm = e.belief.arm;
  if (arm.joints() < 3)
    throw InputError(fmt::format("arm.urdf: {} joints cannot turn the tool; at least 3 are needed",
                                 arm.joints()));
  const StartedDriver started(driver);
  Mover mover(arm, driver);

  ToolCalibration calibration;
  JointVector from = e.belief.start_q;
  for (int i = 0; i < poses; ++i) {
    JointVector to = e.belief.start_q;
    to.tail<3>() += wrist_turn(i);
    to = within_range(to, arm.limits());
    const Vector6 reading = mover.move(from, to, rest);
    if (mover.state().v.cwiseAbs().maxCoeff() > kAtRest)
      throw std::runtime_error(fmt::format(
          "pose {} of {}: the arm did not come to rest within {:.1f} s", i + 1, poses, rest));
    calibration.poses.push_back({arm.tip_pose(mover.state().q).R, reading});
    from = to;
  }
  calibration.found = identify_tool(calibration.poses, {0.0, 0.0, -e.scenario.world.gravity});
  return calibration;
}

}  // namespace impedraw
