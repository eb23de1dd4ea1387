#include "impedraw/run/calibrate_tool.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "impedraw/common/errors.h"

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

}  // namespace

ToolCalibration calibrate_tool(Experiment& e, int poses, double rest) {
  if (!has_sensor(e.scenario.control.source))
    throw InputError("control.wrench: there is no sensor to read; valid are sensor, realistic");
  const int n = e.arm.joints();
  if (n < 3)
    throw InputError(
        fmt::format("arm.urdf: {} joints cannot turn the tool; at least 3 are needed", n));
  const double dt = e.scenario.world.dt;
  WrenchSensor sensor(e.sensor, dt, static_cast<std::uint64_t>(e.scenario.seed));
  World& world = *e.world;
  world.set_state(e.start_q, JointVector::Zero(n));
  ArmTerms terms(n);

  ToolCalibration calibration;
  JointVector from = e.start_q;
  for (int i = 0; i < poses; ++i) {
    JointVector to = e.start_q;
    to.tail<3>() += wrist_turn(i);
    to = to.cwiseMax(JointVector(e.arm.limits().lower).array().matrix() +
                     JointVector::Constant(n, 0.1))
             .cwiseMin(JointVector(e.arm.limits().upper) - JointVector::Constant(n, 0.1));
    Vector6 sum = Vector6::Zero();
    int count = 0;
    const long moving = std::lround(kMoveTime / dt), steps = moving + std::lround(rest / dt),
               averaging = steps - std::lround(0.5 * rest / dt);
    for (long k = 0; k < steps; ++k) {
      const double s = std::min(1.0, static_cast<double>(k) / moving),
                   ds = s < 1.0 ? 1.0 / kMoveTime : 0.0;
      const JointVector q_d = from + s * s * s * (10.0 + s * (6.0 * s - 15.0)) * (to - from);
      const JointVector v_d = 30.0 * s * s * (1.0 - s) * (1.0 - s) * ds * (to - from);
      const WorldState& state = world.state();
      e.arm.compute(state.q, state.v, &terms);
      const JointVector damping = 1.4 * (kStiffness * terms.M.diagonal()).cwiseSqrt();
      const JointVector tau =
          terms.g + kStiffness * (q_d - state.q) + damping.cwiseProduct(v_d - state.v);
      const Vector6 reading = sensor.sample(world.flange_wrench());
      if (k >= averaging) {
        sum += reading;
        ++count;
      }
      world.step(tau, Eigen::Vector3d::Zero().eval());
      if (world.failure()) throw std::runtime_error(*world.failure());
    }
    if (world.state().v.cwiseAbs().maxCoeff() > kAtRest)
      throw std::runtime_error(fmt::format(
          "pose {} of {}: the arm did not come to rest within {:.1f} s", i + 1, poses, rest));
    calibration.poses.push_back({e.arm.tip_pose(world.state().q).R, sum / count});
    from = to;
  }
  calibration.found = identify_tool(calibration.poses, {0.0, 0.0, -e.scenario.world.gravity});
  return calibration;
}

}  // namespace impedraw
