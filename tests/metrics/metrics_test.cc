// Each metric on a made-up run whose answer is known by hand.
#include "impedraw/metrics/metrics.h"

#include <numbers>

#include <gtest/gtest.h>

#include "impedraw/metrics/ending.h"
#include "impedraw/metrics/pens.h"
#include "impedraw/metrics/statistics.h"
#include "made_up_rows.h"

namespace impedraw {
namespace {

using namespace testing;

TEST(Metrics, PlainRun) {
  const Json m = metrics_of(plain_run());
  const auto expect = [&](const char* name, double expected) {
    EXPECT_NEAR(m.at(name).get<double>(), expected, 1e-9) << name;
  };
  expect("contact_fraction", 1.0);
  expect("strokes_missed", 0);
  for (const char* name :
       {"ink_error_rms", "ink_error_p95", "ink_error_max", "tracking_error_rms",
        "tracking_error_max", "gaps", "longest_gap", "ink_outside", "ink_up", "force_sd",
        "force_rms_error", "tilt_mean", "tilt_p95", "tilt_max", "torque_saturated"}) {
    expect(name, 0.0);
  }
  for (const char* name : {"force_mean", "force_peak", "touchdown_peak", "contact_force_max"})
    expect(name, 5.0);
  expect("coverage", 1.0);
  expect("speed_mean", 50.0);
  expect("speed_p95", 50.0);
  expect("draw_time", 1.0);
  expect("joint_margin_min", 1.0);
  expect("joint_speed_share_max", 0.0);
  expect("step_time_p50", 10.0);
  // Every name of docs/metrics.md is there, and each null has its reason.
  EXPECT_EQ(metric_definitions().size(), 46u);
  for (const MetricDefinition& d : metric_definitions()) {
    ASSERT_TRUE(m.contains(d.name));
    EXPECT_EQ(m.at(d.name).is_null(), m.at("reasons").contains(d.name)) << d.name;
  }
}

TEST(Metrics, WhatWasPromisedIsReadFromTheLog) {
  MadeUp run = plain_run();
  EXPECT_TRUE(metrics_of(run).at("length_promised").is_null());
  Promise promise;
  promise.asked = 0.1;
  promise.promised = 0.06;
  promise.undrawable = 0.039;
  promise.unnamed = 0.001;
  promise.reachable = 0.08;
  promise.problems = {{"too_steep", 2}, {"fold", 1}};
  promise.slope = 30 * kDegree;
  promise.time = 12.5;
  run.attributes[kPromiseAttribute] = promise_text(promise);
  const Json m = metrics_of(run);
  EXPECT_NEAR(m.at("length_asked").get<double>(), 100.0, 1e-9);
  EXPECT_NEAR(m.at("length_promised").get<double>(), 60.0, 1e-9);
  EXPECT_NEAR(m.at("length_undrawable").get<double>(), 39.0, 1e-9);
  EXPECT_NEAR(m.at("length_unnamed").get<double>(), 1.0, 1e-9);
  EXPECT_NEAR(m.at("length_reachable").get<double>(), 80.0, 1e-9);
  EXPECT_NEAR(m.at("slope_max").get<double>(), 30.0, 1e-9);
  EXPECT_EQ(m.at("planned_time"), 12.5);
  EXPECT_EQ(m.at("not_drawn"), (Json{{"fold", 1}, {"too_steep", 2}}));
  promise.reachable.reset();
  run.attributes[kPromiseAttribute] = promise_text(promise);
  EXPECT_TRUE(metrics_of(run).at("length_reachable").is_null());
  run.attributes[kPromiseAttribute] = "{\"asked\": 1}";
  EXPECT_TRUE(metrics_of(run).at("length_promised").is_null());
}

// The canvas: level for x ≤ 25 mm, 60° steep beyond it and 5 mm lower, in two pieces, so that no
// normal is between them. The ink is 1 mm beside the target on the level half, and far below it on
// the steep one.
TEST(Metrics, GentleInkErrorLeavesSteepSlopesOut) {
  MadeUp run = plain_run();
  const double fall = std::tan(60 * kDegree), low = -5e-3 - 0.475 * fall;
  run.canvas_vertices = {{-1, -1, 0},        {0.025, -1, 0}, {0.025, 1, 0}, {-1, 1, 0},
                         {0.025, -1, -5e-3}, {0.5, -1, low}, {0.5, 1, low}, {0.025, 1, -5e-3}};
  run.canvas_triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  for (std::size_t i = 1000; i < 2000; ++i) {
    const double x = 1e-3 * 0.05 * (static_cast<double>(i) - 1000.0);
    run.contact_point[i] = {x, 1e-3, x > 0.025 ? -5e-3 - (x - 0.025) * fall : 0.0};
  }
  EXPECT_TRUE(metrics_of(run).at("ink_error_rms_to_45").is_null());
  run.attributes[kPromiseAttribute] = promise_text({});
  const double all = metrics_of(run).at("ink_error_rms").get<double>();
  const double gentle = metrics_of(run).at("ink_error_rms_to_45").get<double>();
  EXPECT_NEAR(gentle, 1.0, 1e-9);
  EXPECT_GT(all, 2.0);
  run.canvas_triangles.resize(2);  // all level: nothing is left out, though the ink is off it
  EXPECT_DOUBLE_EQ(metrics_of(run).at("ink_error_rms_to_45").get<double>(), all);
}

TEST(Metrics, ContactFractionCountsPenDownSamplesWithInk) {
  MadeUp run = plain_run();
  for (std::size_t i = 1100; i < 1200; ++i) lift(run, i);
  for (std::size_t i = 1200; i < 1250; ++i) touch(run, i, 5.0, 0.0, 0.1);  // not above 0.1 N
  EXPECT_DOUBLE_EQ(value(run, "contact_fraction"), 0.85);
  // A second stroke of 1000 rows never touched counts in full.
  MadeUp two = empty_run(5000);
  for (std::size_t i = 1000; i < 2000; ++i) two.stroke[i] = 0, touch(two, i, 0.05 * (i - 1000.0));
  for (std::size_t i = 3000; i < 4000; ++i) two.stroke[i] = 1;
  add_target(two, 0, 0, 50);
  add_target(two, 1, 0, 50, 20);
  EXPECT_DOUBLE_EQ(value(two, "contact_fraction"), 0.5);
  EXPECT_EQ(value(two, "strokes_missed"), 1);
  EXPECT_NEAR(value(two, "coverage"), 0.5, 1e-12);
  EXPECT_EQ(value(two, "gaps"), 1);
  EXPECT_NEAR(value(two, "longest_gap"), 50.0, 1e-9);
  add_target(two, 2, 0, 50, 40);  // a stroke that the run never came to
  EXPECT_EQ(value(two, "strokes_missed"), 2);
  expect_null(empty_run(100), {"contact_fraction"}, "no pen-down sample");
  expect_null(empty_run(100), {"strokes_missed"}, "no stroke");
}

TEST(Metrics, InkErrorIsToTheStrokesOwnTarget) {
  MadeUp run = plain_run();
  add_target(run, 1, 0.0, 50.0, 0.3);  // another stroke's line under the ink counts for nothing
  for (std::size_t i = 1000; i < 2000; ++i)
    touch(run, i, 0.05 * (i - 1000.0), i < 1900 ? 0.3 : 0.4);
  for (std::size_t i = 900; i < 1000; ++i) touch(run, i, 0.0, 30.0);  // not pen-down
  EXPECT_NEAR(value(run, "ink_error_rms"), std::sqrt(0.9 * 0.09 + 0.1 * 0.16), 1e-12);
  EXPECT_NEAR(value(run, "ink_error_p95"), 0.4, 1e-12);
  EXPECT_NEAR(value(run, "ink_error_max"), 0.4, 1e-12);
  // Beyond the end of the line the distance is to its end.
  touch(run, 1999, 53.0, 4.0);
  EXPECT_NEAR(value(run, "ink_error_max"), 5.0, 1e-9);
  MadeUp up = plain_run();
  for (std::size_t i = 0; i < up.rows(); ++i) lift(up, i);
  expect_null(up, {"ink_error_rms", "ink_error_p95", "ink_error_max", "ink_outside"},
              "no pen-down ink");
  MadeUp aimless = plain_run();
  aimless.target_points.clear();
  aimless.target_stroke.clear();
  expect_null(aimless, {"ink_error_rms", "ink_error_p95", "ink_error_max"}, "no target");
  expect_null(aimless, {"coverage", "gaps", "longest_gap"}, "no target");
}

TEST(Metrics, CoverageAndGaps) {
  MadeUp run = plain_run();
  for (std::size_t i = 1200; i < 1500; ++i)
    lift(run, i);  // ink ends at 9.95 mm and begins again at 25
  for (std::size_t i = 1700; i < 1730; ++i)
    lift(run, i);  // 34.95 to 36.5: uncovered 0.55 mm, no gap
  EXPECT_NEAR(value(run, "coverage"), 1.0 - (14.05 + 0.55) / 50.0, 1e-9);
  EXPECT_EQ(value(run, "gaps"), 1);
  EXPECT_NEAR(value(run, "longest_gap"), 14.05, 1e-9);
}

TEST(Metrics, InkOfOtherStrokesCoversNothing) {
  MadeUp run = plain_run();
  add_target(run, 1, 0.0, 50.0, 0.2);
  EXPECT_NEAR(value(run, "coverage"), 0.5, 1e-12);
}

TEST(Metrics, InkOutside) {
  MadeUp run = plain_run();
  // 10 of its 50 mm along the stroke run 2 mm beside it; the jumps there and back are 2 mm each,
  // across 0.05 mm, half of them outside.
  for (std::size_t i = 1000; i < 2000; ++i)
    touch(run, i, 0.05 * (i - 1000.0), i >= 1400 && i < 1600 ? 2.0 : 0.0);
  const double jump = std::hypot(2.0, 0.05), beside = 199 * 0.05, on = 399 * 0.05 * 2;
  EXPECT_NEAR(value(run, "ink_outside"), (beside + jump) / (beside + on + 2 * jump), 1e-9);
}

TEST(Metrics, InkUpSparesHalfASecondAroundAStrokesEnds) {
  MadeUp run = plain_run();
  for (std::size_t i = 0; i < 3000; ++i) {
    if (i < 1000 || i >= 2000) touch(run, i, 0.1 * static_cast<double>(i));  // 0.1 mm a row
  }
  // Free: rows 500 … 999 and 2000 … 2500. Left: 0 … 499 and 2501 … 2999, so 499 and 498 pieces.
  EXPECT_NEAR(value(run, "ink_up"), 99.7, 1e-9);
  EXPECT_EQ(value(plain_run(), "ink_up"), 0.0);
}

TEST(Metrics, ForceAfterSettling) {
  MadeUp run = plain_run();
  // First touch at row 900; rows 900 … 1100 settle (0.2 s), so 1101 … 1999 count: 899 rows.
  for (std::size_t i = 900; i < 1000; ++i) touch(run, i, 0.0, 0.0, 9.0);
  for (std::size_t i = 1000; i <= 1100; ++i) touch(run, i, 0.0, 0.0, 8.0);
  for (std::size_t i = 1101; i < 2000; ++i) touch(run, i, 0.0, 0.0, i < 1101 + 100 ? 7.0 : 4.0);
  const double n = 899.0, m = (100 * 7.0 + 799 * 4.0) / n;
  EXPECT_NEAR(value(run, "force_mean"), m, 1e-12);
  EXPECT_NEAR(value(run, "force_sd"),
              std::sqrt((100 * (7 - m) * (7 - m) + 799 * (4 - m) * (4 - m)) / n), 1e-12);
  EXPECT_NEAR(value(run, "force_rms_error"), std::sqrt((100 * 4.0 + 799 * 1.0) / n), 1e-12);
  EXPECT_EQ(value(run, "force_peak"), 7.0);
  EXPECT_EQ(value(run, "touchdown_peak"), 9.0);
  // The boundary itself: row 1100 is 0.2 s after the touch, no later; the peak's window includes
  // it.
  touch(run, 1100, 0.0, 0.0, 20.0);
  EXPECT_EQ(value(run, "force_peak"), 7.0);
  EXPECT_EQ(value(run, "touchdown_peak"), 20.0);
  touch(run, 1101, 0.0, 0.0, 30.0);
  EXPECT_EQ(value(run, "force_peak"), 30.0);
  EXPECT_EQ(value(run, "touchdown_peak"), 20.0);
}

// A pen of 1 mm at 5 N and 0.2 mm/N: 7 N draw 1.4 mm, 4 N 0.8 mm, where 5 N ask for 1 mm.
TEST(Metrics, WidthErrorIsThatOfThePensModel) {
  MadeUp run = plain_run();
  for (std::size_t i = 900; i < 2000; ++i) touch(run, i, 0.0, 0.0, i < 1101 + 100 ? 7.0 : 4.0);
  expect_null(run, {"width_error_rms"}, "no pen whose width changes");
  DrawnPens pens{{{{.width_per_newton = 0.2}, "red", 0xff0000u}}, {0}};
  run.attributes[kPensAttribute] = pens_text(pens);
  EXPECT_NEAR(value(run, "width_error_rms"), std::sqrt((100 * 0.16 + 799 * 0.04) / 899), 1e-12);
  const std::optional<DrawnPens> again = read_pens(run.attributes);
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->of(0).name, "red");
  EXPECT_EQ(again->of(7).colour, 0xff0000u);
  pens.of_stroke = {1};
  run.attributes[kPensAttribute] = pens_text(pens);
  EXPECT_FALSE(read_pens(run.attributes).has_value()) << "there is no second pen";
}

TEST(Metrics, ForcesArePooledOverStrokes) {
  MadeUp run = empty_run(4000);
  for (std::size_t i = 1000; i < 1400; ++i)
    run.stroke[i] = 0, touch(run, i, 0, 0, 4.0);  // 201 … 399 after the touch: 199 rows
  for (std::size_t i = 2000; i < 2800; ++i)
    run.stroke[i] = 1, touch(run, i, 0, 0, 6.0);  // 599 rows
  for (std::size_t i = 2000; i < 2010; ++i) touch(run, i, 0, 0, 11.0);
  EXPECT_NEAR(value(run, "force_mean"), (199 * 4.0 + 599 * 6.0) / 798, 1e-12);
  EXPECT_EQ(value(run, "touchdown_peak"), 11.0);
}

TEST(Metrics, ForceIsNullWithoutContact) {
  MadeUp run = plain_run();
  for (std::size_t i = 0; i < run.rows(); ++i) lift(run, i);
  expect_null(run, {"force_mean", "force_sd", "force_rms_error", "force_peak"}, "no pen-down ink");
  expect_null(run, {"touchdown_peak"}, "no stroke was touched");
  MadeUp unasked = plain_run();
  std::fill(unasked.push.begin(), unasked.push.end(), kNone);
  expect_null(unasked, {"force_rms_error"}, "asked for");
}

TEST(Metrics, Tilt) {
  MadeUp run = plain_run();
  for (std::size_t i = 0; i < 3000; ++i) run.tip_orientation[i] = pen(45.0);
  for (std::size_t i = 1000; i < 2000; ++i) run.tip_orientation[i] = pen(i < 1900 ? 1.0 : 3.0);
  EXPECT_NEAR(value(run, "tilt_mean"), 1.2, 1e-9);
  EXPECT_NEAR(value(run, "tilt_p95"), 3.0, 1e-9);
  EXPECT_NEAR(value(run, "tilt_max"), 3.0, 1e-9);
}

// 3 mm ahead and 4 mm aside is 5 mm; what is along the normal, and rows without ink, do not count.
TEST(Metrics, TrackingError) {
  MadeUp run = plain_run();
  for (std::size_t i = 0; i < 3000; ++i) run.tip_position[i] = {1.0, 1.0, 1.0};
  for (std::size_t i = 1000; i < 2000; ++i) {
    run.desired_position[i] = {0.1, 0.2, 0.3};
    run.tip_position[i] = run.desired_position[i] + Eigen::Vector3d(3e-3, 4e-3, 0.5);
    if (i >= 1500) run.tip_position[i] = run.desired_position[i];
  }
  EXPECT_NEAR(value(run, "tracking_error_max"), 5.0, 1e-9);
  EXPECT_NEAR(value(run, "tracking_error_rms"), 5.0 / std::numbers::sqrt2, 1e-9);
  for (std::size_t i = 1000; i < 1500; ++i) run.time_scale[i] = 0.1;  // the plan stands
  EXPECT_EQ(value(run, "tracking_error_max"), 0.0);
  for (std::size_t i = 0; i < run.rows(); ++i) lift(run, i);
  expect_null(run, {"tracking_error_rms", "tracking_error_max"}, "no pen-down ink");
}

TEST(Metrics, NormalError) {
  MadeUp run = plain_run();
  expect_null(run, {"normal_error_mean", "normal_error_p95"}, "no estimate");
  for (std::size_t i = 0; i < 3000; ++i) {
    const double angle = (i < 1000 ? 50.0 : i < 1500 ? 0.2 : 0.4) * kDegree;
    run.surface_normal[i] = {std::sin(angle), 0.0, std::cos(angle)};
    run.surface_distance[i] = 0.0;
  }
  EXPECT_NEAR(value(run, "normal_error_mean"), 0.3, 1e-9);
  EXPECT_NEAR(value(run, "normal_error_p95"), 0.4, 1e-9);
  for (std::size_t i = 1500; i < 2000; ++i)
    run.surface_distance[i] = kNone;  // no estimate: the normal means nothing
  EXPECT_NEAR(value(run, "normal_error_mean"), 0.2, 1e-9);
}

TEST(Metrics, CloudBias) {
  MadeUp run = plain_run();
  expect_null(run, {"cloud_bias_mean", "cloud_bias_sd"}, "no cloud");
  run.cloud_points = {{0.1, 0.1, 0.001}, {0.2, 0.1, 0.003}, {0.1, 0.3, -0.001}, {0.3, 0.3, 0.001}};
  expect_null(run, {"cloud_bias_mean", "cloud_bias_sd"}, "no canvas");
  run.canvas_vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  run.canvas_triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_NEAR(value(run, "cloud_bias_mean"), 1.0, 1e-9);
  EXPECT_NEAR(value(run, "cloud_bias_sd"), std::sqrt(2.0), 1e-9);
}

TEST(Metrics, SpeedAndDrawTime) {
  MadeUp run = plain_run();
  double x = 0.0;
  for (std::size_t i = 1000; i < 2000; ++i) {
    touch(run, i, x);
    x += i < 1899 ? 0.05 : 0.1;  // 899 pieces at 50 mm/s, 100 at 100 mm/s
  }
  EXPECT_NEAR(value(run, "speed_mean"), (899 * 50.0 + 100 * 100.0) / 999, 1e-9);
  EXPECT_NEAR(value(run, "speed_p95"), 100.0, 1e-9);
  for (std::size_t i = 1500; i < 1700; ++i) lift(run, i);  // across a gap no speed is taken
  EXPECT_LT(value(run, "speed_p95"), 100.0 + 1e-9);
  EXPECT_NEAR(value(run, "draw_time"), 1.0, 1e-9);
  MadeUp cut = plain_run();  // a run that stops inside a stroke
  std::fill(cut.stroke.begin() + 2000, cut.stroke.end(), 0);
  EXPECT_NEAR(value(cut, "draw_time"), 2.0, 1e-9);
  expect_null(empty_run(100), {"speed_mean", "speed_p95"}, "no pen-down ink");
  EXPECT_EQ(value(empty_run(100), "draw_time"), 0.0);
}

TEST(Metrics, TorqueAndJointMargin) {
  MadeUp run = plain_run();
  run.torque_before_limits.col(0).head(300).setConstant(12.0);
  run.joint_torque.col(0).head(300).setConstant(10.0);
  run.torque_before_limits.col(1).head(600).setConstant(-15.0);
  run.joint_torque.col(1).head(600).setConstant(-15.0 - 1e-14);  // rounding is no clipping
  EXPECT_DOUBLE_EQ(value(run, "torque_saturated"), 0.1);
  run.joint_position(1234, 1) = -1.75;
  EXPECT_DOUBLE_EQ(value(run, "joint_margin_min"), 0.25);
  run.torque_before_limits.resize(0, 2);
  expect_null(run, {"torque_saturated"}, "no torque terms");
  run.joint_lower.setConstant(-std::numeric_limits<double>::infinity());
  run.joint_upper.setConstant(std::numeric_limits<double>::infinity());
  expect_null(run, {"joint_margin_min"}, "no joint limits");
}

// Limits of 2 and 0.5 rad/s.
TEST(Metrics, JointSpeedShare) {
  MadeUp run = plain_run();
  run.joint_velocity(200, 0) = -1.0;
  EXPECT_DOUBLE_EQ(value(run, "joint_speed_share_max"), 0.5);
  run.joint_velocity(1234, 1) = -0.6;
  EXPECT_DOUBLE_EQ(value(run, "joint_speed_share_max"), 1.2);
  run.joint_speed_limit[1] = std::numeric_limits<double>::infinity();
  EXPECT_DOUBLE_EQ(value(run, "joint_speed_share_max"), 0.5);
  run.joint_speed_limit.resize(0);
  expect_null(run, {"joint_speed_share_max"}, "no joint speed limits");
}

TEST(Metrics, StepTimeAndRealTimeFactor) {
  MadeUp run = plain_run();
  for (std::size_t i = 0; i < 3000; ++i)
    run.step_time[i] = 1e-6 * static_cast<double>((i * 7) % 3000);  // 0 … 2999, shuffled
  EXPECT_NEAR(value(run, "step_time_p50"), 1499.5, 1e-9);
  EXPECT_NEAR(value(run, "step_time_p99"), 0.99 * 2999, 1e-9);
  EXPECT_NEAR(value(run, "step_time_p999"), 0.999 * 2999, 1e-9);
  expect_null(run, {"real_time_factor"}, "not closed");
  run.wall = {5.0, 0.05, 0.01};
  EXPECT_NEAR(value(run, "real_time_factor"), 3.0 / 0.06, 1e-9);
  EXPECT_EQ(metrics_of(run).at("wall_seconds").at("start_up"), 5.0);
  std::fill(run.step_time.begin(), run.step_time.end(), kNone);
  expect_null(run, {"step_time_p50", "step_time_p99", "step_time_p999"}, "no step was timed");
}

// Where the plan waits, rows count towards its mean and their ink towards its error.
TEST(Metrics, RowsOfAWaitingPlanDoNotCount) {
  EXPECT_EQ(value(plain_run(), "time_scale_mean"), 1.0);
  MadeUp run = plain_run();
  for (std::size_t i = 1300; i < 1400; ++i) {  // off the line, hard, and then without ink
    touch(run, i, 0.05 * (i - 1000.0), 0.2, i < 1350 ? 9.0 : 0.05);
    run.time_scale[i] = 0.1;
  }
  EXPECT_NEAR(value(run, "time_scale_mean"), 0.91, 1e-6);
  EXPECT_EQ(value(run, "contact_fraction"), 1.0);
  // Of 950 rows with ink, 50 lie 0.2 mm off: a pen that waits while it is down leaves ink.
  EXPECT_NEAR(value(run, "ink_error_max"), 0.2, 1e-9);
  EXPECT_NEAR(value(run, "ink_error_rms"), 0.2 * std::sqrt(50.0 / 950.0), 1e-9);
  EXPECT_EQ(value(run, "force_peak"), 5.0);
  EXPECT_EQ(value(run, "force_sd"), 0.0);
  EXPECT_NEAR(value(run, "draw_time"), 1.0, 1e-9);
  for (double& scale : run.time_scale)  // slow, but it runs
    if (scale < 1.0) scale = 0.25;
  EXPECT_NEAR(value(run, "contact_fraction"), 0.95, 1e-12);
  EXPECT_EQ(value(run, "force_peak"), 9.0);
  expect_null(empty_run(100), {"time_scale_mean"}, "no pen-down sample");
}

TEST(Metrics, EveryFieldIsDefinedOnce) {
  Metrics m;
  for (const MetricDefinition& d : metric_definitions()) {
    EXPECT_FALSE((m.*d.member).value()) << d.name << " has the field of another";
    m.*d.member = 1.0;
  }
  EXPECT_EQ(metric_definitions().size() * sizeof(Metric) + sizeof(m.not_drawn) +
                sizeof(m.not_drawn_mm) + sizeof(Ending) + sizeof(WallTimes),
            sizeof(Metrics));
  EXPECT_EQ(metrics_json(m).size(), metric_definitions().size() + 5) << "two share a name";
}

TEST(Metrics, WithoutAMeasuredWrenchContactIsUnknown) {
  MadeUp run = plain_run();
  for (auto& f : run.contact_force) f = LogRow::no_vector();
  expect_null(run, {"force_mean", "coverage", "ink_error_rms", "drawn"}, "no wrench was measured");
}

TEST(Metrics, NoRowsAtAll) {
  const Json m = metrics_of(empty_run(0));
  for (const MetricDefinition& d : metric_definitions())
    EXPECT_TRUE(m.at(d.name).is_null()) << d.name;
}

TEST(Statistics, PercentilesInterpolateLinearly) {
  EXPECT_DOUBLE_EQ(percentile({4, 1, 3, 2}, 0.95), 3.85);
  EXPECT_DOUBLE_EQ(percentile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(percentile({4, 1, 3, 2}, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(percentile({4, 1, 3, 2}, 1.0), 4.0);
  EXPECT_DOUBLE_EQ(percentile({7}, 0.95), 7.0);
}

// 20 minutes of drawing, 1.2 million rows against 150,000 points of target, in strokes of 30 mm.
TEST(Metrics, TwentyMinutesOfDrawing) {
  constexpr std::size_t kRows = 1200000, kPerStroke = 600;
  MadeUp run = empty_run(kRows);
  for (std::size_t i = 0; i < kRows; ++i) {
    const int stroke = static_cast<int>(i / kPerStroke);
    touch(run, i, 0.05 * static_cast<double>(i % kPerStroke), stroke % 100 + 0.03);
    run.stroke[i] = stroke;
  }
  for (int stroke = 0; stroke < 2000; ++stroke) add_target(run, stroke, 0.0, 37.5, stroke % 100);
  ASSERT_GT(run.target_points.size(), 150000u);
  const Json m = metrics_of(run);
  EXPECT_NEAR(m.at("ink_error_rms").get<double>(), 0.03, 1e-9);
  EXPECT_NEAR(m.at("coverage").get<double>(), (29.95 + std::sqrt(0.25 - 0.0009)) / 37.5, 1e-9);
}

}  // namespace
}  // namespace impedraw
