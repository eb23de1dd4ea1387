// The datasets of run.h5 that grow with the run: one list for the rows and one for /every_step. The
// writer, the readers and the file's own description take them from here. Private to src/log.
#pragma once

#include <cstddef>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "impedraw/log/log.h"
#include "impedraw/log/log_step.h"

namespace impedraw {

// Logs of older versions lack it.
inline constexpr const char* kSpeedShareColumn = "/every_step/joint_speed_share";
// Only where the canvas moves.
inline constexpr const char* kCanvasPoseColumn = "/canvas/pose";
// Only where a pen's width changes with its force.
inline constexpr const char* kLineWidthColumn = "/ink/width";
inline constexpr const char* kEstimatedCanvasPoseColumn = "/canvas/estimated_pose";

struct LogColumn {
  std::string name;  // path in the file
  int width;         // 1: shape n; otherwise n×width
  bool integer;      // int32 instead of double
  const char* unit;
  const char* frame;
  std::string description;

  std::size_t row_bytes() const {
    return static_cast<std::size_t>(width) * (integer ? sizeof(int) : sizeof(double));
  }
};

// In the order in which visit_row() and visit_step() visit them. The first is the time.
std::vector<LogColumn> log_columns(const RunLogHeader& header);
const std::vector<LogColumn>& step_columns(bool moving_canvas = false);

// Calls put(pointer to the first number, count, size of one number) for a value of a column: a
// number, a vector, a quaternion as w x y z, or a pose as position and quaternion.
template <class Value, class Put>
void put_value(Value& value, Put&& put) {
  if constexpr (std::is_arithmetic_v<std::remove_const_t<Value>>) {
    put(&value, 1, sizeof value);
  } else if constexpr (std::is_same_v<std::remove_const_t<Value>, Eigen::Quaterniond>) {
    const double wxyz[4] = {value.w(), value.x(), value.y(), value.z()};
    put(wxyz, 4, sizeof(double));
  } else if constexpr (std::is_same_v<std::remove_const_t<Value>, Pose>) {
    const Eigen::Quaterniond q(value.R);
    const double all[7] = {value.p.x(), value.p.y(), value.p.z(), q.w(), q.x(), q.y(), q.z()};
    put(all, 7, sizeof(double));
  } else {
    put(value.data(), static_cast<int>(value.size()), sizeof(double));
  }
}

// The same the other way: sets the value from the numbers at `from`, as they are in the file.
template <class Value>
void take_value(Value& value, const std::byte* from) {
  if constexpr (std::is_same_v<Value, Eigen::Quaterniond> || std::is_same_v<Value, Pose>) {
    double x[7];
    std::memcpy(x, from, std::is_same_v<Value, Pose> ? sizeof x : 4 * sizeof *x);
    if constexpr (std::is_same_v<Value, Pose>)
      value = {{x[0], x[1], x[2]}, Eigen::Quaterniond(x[3], x[4], x[5], x[6]).toRotationMatrix()};
    else
      value = Eigen::Quaterniond(x[0], x[1], x[2], x[3]);
  } else {
    put_value(value, [from](void* to, int count, std::size_t size) {
      std::memcpy(to, from, static_cast<std::size_t>(count) * size);
    });
  }
}

// Calls column(name, value, unit, frame, description) for each dataset of the rows; a torque term's
// with the term's name, too. Row is LogRow or const LogRow.
template <class Row, class Column>
void visit_row(Row& row, const RunLogHeader& header, Column&& column) {
  const char* const canvas = header.moving_canvas ? "canvas" : "world";
  column("/time", row.time, "s", "none", "simulated time at the start of the control step");
  column("/joint/position", row.joint_position, "rad", "joint axes", "joint positions");
  column("/joint/velocity", row.joint_velocity, "rad/s", "joint axes", "joint velocities");
  column("/joint/torque", row.joint_torque, "Nm", "joint axes",
         "joint torques commanded, after limits");
  if (header.joint_sensor) {
    column("/joint/measured_position", row.measured_position, "rad", "joint axes",
           "joint positions as the controller was given them");
    column("/joint/measured_velocity", row.measured_velocity, "rad/s", "joint axes",
           "joint velocities as the controller was given them; zero where the sensor gives none");
  }
  for (std::size_t i = 0; i < header.torque_terms.size(); ++i)
    column("/torque/", row.torque_terms[i], "Nm", "joint axes",
           " of the torque; all terms sum to the torque before limits", header.torque_terms[i]);
  column("/tip/position", row.tip_position, "m", "world",
         "true position of E, the apex of the tip sphere");
  column("/tip/orientation", row.tip_orientation, "1", "world",
         "true orientation of E, quaternion w x y z; z_E points out of the pen");
  column("/tip/velocity", row.tip_velocity, "m/s, rad/s", "world",
         "true velocity of E, linear part first");
  column("/desired/position", row.desired_position, "m", "world",
         "desired position of E as the controller was given it, compensation included");
  column("/desired/orientation", row.desired_orientation, "1", "world",
         "desired orientation of E as the controller was given it, quaternion w x y z");
  column("/contact/force", row.contact_force, "N", "world",
         "true force of the canvas on the tip, acting until the next row; zero out of contact");
  column("/contact/point", row.contact_point, "m", canvas,
         "point of the canvas closest to the centre of the tip sphere; NaN out of contact");
  column("/contact/normal", row.contact_normal, "1", canvas,
         "outward normal of the canvas at the contact point; NaN out of contact");
  column("/wrench/measured", row.wrench_measured, "N, Nm", "world",
         "external wrench at E as the controller was given it, force first");
  column("/disturbance/force", row.disturbance_force, "N", "world",
         "push on the pen by the scenario");
  column("/surface/normal", row.surface_normal, "1", "world",
         "outward surface normal as the controller estimates it; NaN without an estimate");
  column("/surface/distance", row.surface_distance, "m", "none",
         "distance of E to the estimated surface, > 0 outside; NaN without an estimate");
  column("/push", row.push, "N", "surface normal", "normal force asked for");
  column("/mode", row.mode, "1", "none",
         "contact state of the controller; attribute names says which");
  column("/stroke", row.stroke, "1", "none",
         "stroke that the plan is drawing, from the plan alone; -1 between strokes");
  column("/stroke_along", row.stroke_along, "m", "drawing plane",
         "length along the stroke, in the drawing plane from the stroke's first point, of the "
         "desired point; NaN between strokes");
  column("/time_scale", row.time_scale, "1", "none",
         "speed of the plan's clock: 1 as planned, 0 where the plan waits for the pen");
  column("/controller/step_time", row.step_time, "s", "none", "wall time of the controller step");
  if (header.line_width)
    column(kLineWidthColumn, row.line_width, "mm", "none",
           "width of the line that the pen draws with the contact's force; NaN without ink");
  if (header.moving_canvas) {
    column(kCanvasPoseColumn, row.canvas_pose, "m, 1", "world",
           "true pose of the canvas's frame, position and quaternion w x y z; the world's at time "
           "0");
    column(kEstimatedCanvasPoseColumn, row.estimated_canvas_pose, "m, 1", "world",
           "the same as the controller estimates it");
    column("/canvas/estimated_twist", row.estimated_canvas_twist, "m/s, rad/s", "world",
           "estimated velocity of that frame's origin, and its angular velocity");
  }
}

// The same for each dataset of /every_step. Step is LogStep or const LogStep. `canvas`: the frame
// of points on it.
template <class Step, class Column>
void visit_step(Step& step, const char* canvas, Column&& column) {
  column("/every_step/time", step.time, "s", "none",
         "simulated time at the start of the control step");
  column("/every_step/normal_force", step.force, "N", "contact normal",
         "true force of the canvas on the tip along the outward normal; zero out of contact");
  column("/every_step/contact_point", step.contact_point, "m", canvas,
         "point of the canvas closest to the centre of the tip sphere; NaN out of contact");
  column("/every_step/tilt", step.tilt, "rad", "none",
         "angle between the pen and the canvas's true normal; NaN but on pen-down ink");
  column("/every_step/normal_error", step.normal_error, "rad", "none",
         "angle between the estimated and the true normal; NaN but on pen-down ink");
  column("/every_step/tracking_error", step.tracking_error, "m", "none",
         "distance of the tip from its desired position, along the canvas; NaN but on pen-down "
         "ink");
  column("/every_step/push", step.push, "N", "surface normal", "normal force asked for");
  column("/every_step/torque_share", step.torque_share, "1", "none",
         "largest joint torque against its limit, to a float's precision");
  column("/every_step/joint_margin", step.joint_margin, "rad", "joint axes",
         "smallest distance of a joint to its limits up to this step");
  column(kSpeedShareColumn, step.joint_speed_share, "1", "joint axes",
         "largest joint speed against its limit up to this step; NaN without limits");
  column("/every_step/clipped", step.clipped, "1", "none", "1 where a joint's torque was limited");
  column("/every_step/mode", step.mode, "1", "none",
         "contact state of the controller; attribute names of /mode says which");
  column("/every_step/stroke", step.stroke, "1", "none",
         "stroke that the plan is drawing, from the plan alone; -1 between strokes");
  column("/every_step/stroke_along", step.stroke_along, "m", "drawing plane",
         "length along the stroke of the desired point; NaN between strokes");
  column("/every_step/felt_force", step.felt_force, "N", "surface normal",
         "measured force along the estimated normal, to a float's precision; NaN without an "
         "estimate");
  column("/every_step/time_scale", step.time_scale, "1", "none",
         "speed of the plan's clock, to a float's precision");
  column("/every_step/step_time", step.step_time, "s", "none",
         "wall time of the controller step, to a float's precision");
}

}  // namespace impedraw
