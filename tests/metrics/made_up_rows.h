// Rows of a run put down by hand, and their metrics.
//
// The plain run: 3 s at 1 kHz on the plane z = 0. Rows 1000 … 1999 draw stroke 0 along x from 0 at
// 50 mm/s; the tip rests at its start from row 900 on and at its end up to row 2099, pressing with
// 5 N throughout, the pen upright.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "impedraw/metrics/metrics.h"
#include "log/run_columns.h"

namespace impedraw::testing {

using Json = nlohmann::ordered_json;
inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kDegree = std::numbers::pi / 180.0;

inline Eigen::Quaterniond pen(double tilt_deg) {  // z_E down, turned about y
  return Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()) *
                            Eigen::AngleAxisd(tilt_deg * kDegree, Eigen::Vector3d::UnitY()));
}

// The rows as a log holds them, and what does not change.
struct MadeUp : RunRows, RunConstants {};

inline Json metrics_of(const MadeUp& made_up) {
  return metrics_json(compute_metrics(recorded(made_up, made_up)));
}

// n rows without contact, the pen upright and up, nothing asked for.
inline MadeUp empty_run(std::size_t n) {
  MadeUp run;
  for (std::size_t i = 0; i < n; ++i) run.time.push_back(1e-3 * static_cast<double>(i));
  const Eigen::Vector3d none = LogRow::no_vector(), zero = Eigen::Vector3d::Zero();
  run.joint_position = run.joint_velocity = run.joint_torque = run.torque_before_limits =
      RunRows::Joints::Zero(static_cast<Eigen::Index>(n), 2);
  run.contact_force = RunRows::Points(n, zero);
  run.contact_point = run.contact_normal = run.surface_normal = RunRows::Points(n, none);
  run.tip_position = run.desired_position = RunRows::Points(n, zero);
  run.tip_orientation.assign(n, pen(0.0));
  run.surface_distance.assign(n, kNone);
  run.push.assign(n, 0.0);
  run.step_time.assign(n, 1e-5);
  run.time_scale.assign(n, 1.0);
  run.mode.assign(n, 0);
  run.stroke.assign(n, -1);
  run.stroke_along.assign(n, kNone);
  run.joint_lower = Eigen::Vector2d(-1.0, -2.0);
  run.joint_upper = Eigen::Vector2d(1.0, 2.0);
  run.torque_limit = Eigen::Vector2d(10.0, 20.0);
  run.joint_speed_limit = Eigen::Vector2d(2.0, 0.5);
  return run;
}

inline void touch(MadeUp& run, std::size_t i, double x_mm, double y_mm = 0.0, double f = 5.0) {
  run.contact_force[i] = {-0.3 * f, 0.0, f};  // friction is no part of f
  run.contact_point[i] = {1e-3 * x_mm, 1e-3 * y_mm, 0.0};
  run.contact_normal[i] = Eigen::Vector3d::UnitZ();
  run.push[i] = 5.0;
}

inline void lift(MadeUp& run, std::size_t i) {
  run.contact_force[i].setZero();
  run.contact_point[i] = run.contact_normal[i] = LogRow::no_vector();
}

inline void add_target(MadeUp& run, int stroke, double from_mm, double to_mm, double y_mm = 0.0) {
  const int n = static_cast<int>(std::ceil((to_mm - from_mm) / 0.5));
  for (int k = 0; k <= n; ++k) {
    run.target_points.emplace_back(1e-3 * (from_mm + (to_mm - from_mm) * k / n), 1e-3 * y_mm, 0.0);
    run.target_stroke.push_back(stroke);
  }
}

inline MadeUp plain_run() {
  MadeUp run = empty_run(3000);
  for (std::size_t i = 900; i < 2100; ++i)
    touch(run, i, 0.05 * std::clamp(static_cast<double>(i) - 1000.0, 0.0, 1000.0));
  for (std::size_t i = 1000; i < 2000; ++i) {
    run.stroke[i] = 0;
    run.stroke_along[i] = 5e-5 * (static_cast<double>(i) - 1000.0);
  }
  add_target(run, 0, 0.0, 50.0);
  return run;
}

inline double value(const MadeUp& run, const char* name) {
  const Json metrics = metrics_of(run);
  if (metrics.at(name).is_null()) {
    ADD_FAILURE() << name << " is null: " << metrics.at("reasons").at(name);
    return kNone;
  }
  return metrics.at(name).get<double>();
}

inline void expect_null(const MadeUp& run, std::initializer_list<const char*> names,
                        const std::string& reason) {
  const Json metrics = metrics_of(run);
  for (const char* name : names) {
    EXPECT_TRUE(metrics.at(name).is_null()) << name;
    ASSERT_TRUE(metrics.at("reasons").contains(name)) << name;
    EXPECT_NE(metrics.at("reasons").at(name).get<std::string>().find(reason), std::string::npos)
        << metrics.at("reasons").at(name);
  }
}

}  // namespace impedraw::testing
