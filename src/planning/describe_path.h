// Description of the tip path's settings (path/tip_planner.h).
// See control/describe_control.h.
#pragma once

#include "impedraw/planning/path/tip_planner.h"

namespace impedraw {

inline constexpr Range kDrawSpeedRange{1e-4, 1.0};             // [m/s]
inline constexpr Range kNormalAccelerationRange{0.01, 100.0};  // [m/s²]
inline constexpr Range kTiltSpeedRange{0.01, 20.0};            // [rad/s]
inline constexpr Range kTiltAccelerationRange{0.1, 1000.0};    // [rad/s²]

template <class F>
void describe(F& f, PathSettings& s) {
  f.constant("start_hold", s.start_hold, {0.0, 120.0}, "s");  // a tare of up to 60 s included
  f.constant("hover_height", s.hover_height, Range::positive_to(0.1), "m");
  f.field("approach_speed", s.approach_speed, {1e-4, 0.2}, "m/s",
          "Speed of the approach to the first point.");
  f.constant("settle_time", s.settle_time, {0.0, 10.0}, "s");
  f.field("draw_speed", s.draw_speed, kDrawSpeedRange, "m/s",
          "Speed along a stroke, on the surface.")
      .for_users();
  f.field("draw_acceleration", s.draw_acceleration, {0.01, 20.0}, "m/s²",
          "Largest acceleration of the desired tip along a stroke.");
  f.constant("end_hold", s.end_hold, {0.0, 10.0}, "s");
  f.constant("dot_time", s.dot_time, {0.0, 10.0}, "s");
  f.field("travel_speed", s.travel_speed, {1e-3, 2.0}, "m/s", "Speed between strokes.");
  f.field("travel_acceleration", s.travel_acceleration, {0.01, 20.0}, "m/s²",
          "Largest acceleration between strokes.");
  f.field("turn_speed", s.turn_speed, {0.01, 10.0}, "rad/s",
          "Angular speed of the pen axis between strokes.");
  f.field("turn_acceleration", s.turn_acceleration, {0.01, 100.0}, "rad/s²",
          "Angular acceleration of the pen axis between strokes, and of a led tool along them.");
  f.field("safe_height", s.safe_height, Range::positive_to(1.0), "m",
          "Height of travel above the highest point of the drawing.");
  f.field("smoothing_time", s.smoothing_time, {0.0, 1.0}, "s",
          "Time over which an acceleration builds up.");
  f.constant("corner_angle", s.corner_angle_deg, Range::to_below(1.0, 90.0), "deg");
  f.constant("normal_smoothing", s.normal_smoothing, {0.0, 0.1}, "m");
  f.field("normal_acceleration", s.normal_acceleration, kNormalAccelerationRange, "m/s²",
          "Largest acceleration across the surface, which its curvature makes: a rough surface is "
          "drawn on slower.");
  f.constant("force_rate", s.force_rate, {1.0, 1e4}, "N/s");
  f.constant("normal_speed", s.normal_speed, {1e-4, 1.0}, "m/s");
  f.constant("joint_speed_share", s.joint_speed_share, {0.01, 1.0}, "");
  f.constant("joint_acceleration", s.joint_acceleration, {0.1, 1000.0}, "rad/s²");
  f.constant("joint_torque_share", s.joint_torque_share, {0.01, 1.0}, "");
  f.field("tilt_allowance", s.tilt_allowance_deg, {0.0, 45.0}, "deg",
          "Largest angle by which the pen's axis may leave the surface normal where it would "
          "otherwise turn faster than 1.5 rad/s, or with more than 20 rad/s².");
  f.field("lean", s.lean_deg, {0.0, 30.0}, "deg",
          "The pen leans off the surface normal towards the drawing plane's axis: by half of the "
          "angle between them, but at most by this. A wrist then need not turn as far round an "
          "object, nor go as low beside it. --place surface tries 20 and 30.");
  f.constant("tilt_speed", s.tilt_speed, kTiltSpeedRange, "rad/s");
  f.constant("tilt_acceleration", s.tilt_acceleration, kTiltAccelerationRange, "rad/s²");
  f.constant("tolerance", s.tolerance, {1e-7, 1e-2}, "m");
  f.constant("rounding", s.rounding, {0.0, 1e-2}, "m");
}

}  // namespace impedraw
