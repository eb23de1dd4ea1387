// A rigid body of point masses waved along analytic sines, and what a force-torque sensor reads of
// it: the momentum of each mass, its position differenced numerically. Knows nothing of
// Newton–Euler.
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "impedraw/sensing/wrench_estimator.h"

namespace impedraw::waved_tool {

inline const Eigen::Vector3d kGravity(0.0, 0.0, -9.81);
inline constexpr double kDt = 1e-3;

struct PointMass {
  double mass;
  Eigen::Vector3d p_S;
};

// 0.5 kg about (0.01, −0.02, 0.13) in S, every product of inertia there.
inline std::vector<PointMass> point_masses() {
  std::mt19937 rng(11);
  std::uniform_real_distribution<double> place(-0.08, 0.08), share(0.5, 1.5);
  std::vector<PointMass> points(8);
  double mass = 0.0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (PointMass& point : points) {
    point = {share(rng), {place(rng), place(rng), place(rng)}};
    mass += point.mass;
    moment += point.mass * point.p_S;
  }
  for (PointMass& point : points) {
    point.p_S += Eigen::Vector3d(0.01, -0.02, 0.13) - moment / mass;
    point.mass *= 0.5 / mass;
  }
  return points;
}

inline Tool tool_of(const std::vector<PointMass>& points) {
  Tool tool;
  for (const PointMass& point : points) tool.mass += point.mass;
  for (const PointMass& point : points) tool.p_SC += point.mass * point.p_S / tool.mass;
  for (const PointMass& point : points) {
    const Eigen::Vector3d d = point.p_S - tool.p_SC;
    tool.I_SC += point.mass * (d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose());
  }
  return tool;
}

inline Pose tip_in_sensor() {
  return {{0.005, -0.01, 0.18},
          (Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()) *
           Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()))
              .matrix()};
}

// At rest until t = 0, then 3 m/s² and ± 60° of tilt at 3 rad/s (up to 3.1 rad/s), while the tool
// turns about the vertical and its own axis.
inline Pose sensor_pose(double t) {
  t = std::max(t, 0.0);
  const double degree = std::numbers::pi / 180.0, w = 3.0;
  Pose X;
  X.p << 0.5 - 3.0 / (w * w) * std::cos(w * t), 0.05 * (1.0 - std::cos(4.0 * t)),
      0.6 + 0.1 * (1.0 - std::cos(2.0 * t));
  X.R = (Eigen::AngleAxisd(0.5 * (1.0 - std::cos(2.0 * t)), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(std::numbers::pi - 60.0 * degree * std::cos(w * t),
                           Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(0.3 * (1.0 - std::cos(2.5 * t)), Eigen::Vector3d::UnitZ()))
            .matrix();
  return X;
}

inline constexpr double kDifference = 1e-5;  // [s]

// [v; ω] of sensor ∘ X_SF at F's origin, in W.
inline Vector6 velocity(double t, const Pose& X_SF) {
  const Pose before = sensor_pose(t - kDifference) * X_SF,
             after = sensor_pose(t + kDifference) * X_SF;
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(after.R * before.R.transpose()));
  Vector6 V;
  V << (after.p - before.p) / (2.0 * kDifference), turn.axis() * turn.angle() / (2.0 * kDifference);
  return V;
}

// The sensor's reading over the step that ends at t: weight less rate of momentum of the masses,
// plus a wrench on the tip, constant in W.
inline Vector6 reading(double t, const std::vector<PointMass>& points,
                       const Vector6& F_tip_W = Vector6::Zero()) {
  constexpr int kParts = 10;
  constexpr double h = kDt / kParts;
  const auto momenta = [&](double time) {
    const Pose before = sensor_pose(time - kDifference), after = sensor_pose(time + kDifference);
    std::vector<Eigen::Vector3d> all;
    for (const PointMass& point : points)
      all.push_back(point.mass * (after * point.p_S - before * point.p_S) / (2.0 * kDifference));
    return all;
  };
  Vector6 mean = Vector6::Zero();
  std::vector<Eigen::Vector3d> start = momenta(t - kDt);
  for (int part = 0; part < kParts; ++part) {
    const double end_time = t - kDt + (part + 1) * h;
    const std::vector<Eigen::Vector3d> end = momenta(end_time);
    const Pose X_WS = sensor_pose(end_time - 0.5 * h);
    Eigen::Vector3d force = F_tip_W.head<3>();
    Eigen::Vector3d torque = F_tip_W.tail<3>() + (X_WS * tip_in_sensor().p - X_WS.p).cross(force);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d one = points[i].mass * kGravity - (end[i] - start[i]) / h;
      force += one;
      torque += (X_WS * points[i].p_S - X_WS.p).cross(one);
    }
    mean.head<3>() += X_WS.R.transpose() * force / kParts;
    mean.tail<3>() += X_WS.R.transpose() * torque / kParts;
    start = end;
  }
  return mean;
}

inline WrenchEstimatorSettings settings_for(const Tool& tool) {
  WrenchEstimatorSettings settings;
  settings.dt = kDt;
  settings.tool = tool;
  settings.X_ES = tip_in_sensor().inverse();
  settings.gravity_W = kGravity;
  return settings;
}

}  // namespace impedraw::waved_tool
