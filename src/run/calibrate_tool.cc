#include "impedraw/run/calibrate_tool.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/minimum_jerk.h"
#include "impedraw/run/posture_holder.h"

namespace impedraw {

namespace {

constexpr double kMoveTime = 1.5;  // from pose to pose [s]
constexpr double kDelay = 5e-3;    // the longest that the loop may have [s]
constexpr double kTurn = 1.0;      // of each wrist joint from the start posture, at most [rad]
constexpr double kAtRest = 0.05;   // joint speed [rad/s]

// Orientations spread over the ball of wrist turns: a low-discrepancy sequence (Roberts' R3), so
// that any number of poses is well placed.
Eigen::Vector3d wrist_turn(int i) {
  const Eigen::Vector3d step(0.8191725134, 0.6710436067, 0.5497004779);
  Eigen::Vector3d x = 0.5 * Eigen::Vector3d::Ones() + i * step;
  for (double& c : x) c = 2.0 * (c - std::floor(c)) - 1.0;
  return kTurn * x;
}

// From rest to rest, then still for `rest` seconds; the mean reading over the last half of them.
Vector6 move(PostureHolder& holder, double dt, const JointVector& from, const JointVector& to,
             double rest) {
  Vector6 sum = Vector6::Zero();
  int count = 0;
  const long moving = std::lround(kMoveTime / dt), steps = moving + std::lround(rest / dt),
             averaging = steps - std::lround(0.5 * rest / dt);
  for (long k = 0; k < steps; ++k) {
    const MinimumJerk jerk =
        MinimumJerk::at(std::min(1.0, static_cast<double>(k) / moving), kMoveTime);
    const JointVector way = to - from;
    if (k >= averaging) {
      sum += holder.state().wrench;
      ++count;
    }
    holder.step(from + jerk.share * way, jerk.rate * way, JointVector::Zero(way.size()));
  }
  return sum / count;
}

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
  PostureHolder holder(arm, driver, kDelay);

  ToolCalibration calibration;
  JointVector from = e.belief.start_q;
  for (int i = 0; i < poses; ++i) {
    JointVector to = e.belief.start_q;
    to.tail<3>() += wrist_turn(i);
    to = within_range(to, arm.limits());
    const Vector6 reading = move(holder, driver.info().period, from, to, rest);
    if (holder.state().v.cwiseAbs().maxCoeff() > kAtRest)
      throw std::runtime_error(fmt::format(
          "pose {} of {}: the arm did not come to rest within {:.1f} s", i + 1, poses, rest));
    calibration.poses.push_back({arm.tip_pose(holder.state().q).R, reading});
    from = to;
  }
  calibration.found = identify_tool(calibration.poses, {0.0, 0.0, -e.scenario.world.gravity});
  return calibration;
}

}  // namespace impedraw
