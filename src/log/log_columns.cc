#include "impedraw/log/log_columns.h"

namespace impedraw {

std::vector<LogColumn> log_columns(const RunLogHeader& header) {
  const int n = static_cast<int>(header.joint_names.size());
  std::vector<LogColumn> columns = {
      {"/time", 1, false, "s", "none", "simulated time at the start of the control step"},
      {"/joint/position", n, false, "rad", "joint axes", "joint positions"},
      {"/joint/velocity", n, false, "rad/s", "joint axes", "joint velocities"},
      {"/joint/torque", n, false, "Nm", "joint axes", "joint torques commanded, after limits"},
  };
  if (header.joint_sensor) {
    columns.push_back({"/joint/measured_position", n, false, "rad", "joint axes",
                       "joint positions as the controller was given them"});
    columns.push_back({"/joint/measured_velocity", n, false, "rad/s", "joint axes",
                       "joint velocities as the controller was given them; zero where the sensor "
                       "gives none"});
  }
  for (const std::string& term : header.torque_terms) {
    columns.push_back(
        {"/torque/" + term, n, false, "Nm", "joint axes",
         "term '" + term + "' of the torque; all terms sum to the torque before limits"});
  }
  const char* const canvas = header.moving_canvas ? "canvas" : "world";
  const std::vector<LogColumn> rest = {
      {"/tip/position", 3, false, "m", "world", "true position of E, the apex of the tip sphere"},
      {"/tip/orientation", 4, false, "1", "world",
       "true orientation of E, quaternion w x y z; z_E points out of the pen"},
      {"/tip/velocity", 6, false, "m/s, rad/s", "world", "true velocity of E, linear part first"},
      {"/desired/position", 3, false, "m", "world",
       "desired position of E as the controller was given it, compensation included"},
      {"/desired/orientation", 4, false, "1", "world",
       "desired orientation of E as the controller was given it, quaternion w x y z"},
      {"/contact/force", 3, false, "N", "world",
       "true force of the canvas on the tip, acting until the next row; zero out of contact"},
      {"/contact/point", 3, false, "m", canvas,
       "point of the canvas closest to the centre of the tip sphere; NaN out of contact"},
      {"/contact/normal", 3, false, "1", canvas,
       "outward normal of the canvas at the contact point; NaN out of contact"},
      {"/wrench/measured", 6, false, "N, Nm", "world",
       "external wrench at E as the controller was given it, force first"},
      {"/disturbance/force", 3, false, "N", "world", "push on the pen by the scenario"},
      {"/surface/normal", 3, false, "1", "world",
       "outward surface normal as the controller estimates it; NaN without an estimate"},
      {"/surface/distance", 1, false, "m", "none",
       "distance of E to the estimated surface, > 0 outside; NaN without an estimate"},
      {"/push", 1, false, "N", "surface normal", "normal force asked for"},
      {"/mode", 1, true, "1", "none",
       "contact state of the controller; attribute names says which"},
      {"/stroke", 1, true, "1", "none",
       "stroke that the plan is drawing, from the plan alone; -1 between strokes"},
      {"/stroke_along", 1, false, "m", "drawing plane",
       "length along the stroke, in the drawing plane from the stroke's first point, of the "
       "desired "
       "point; NaN between strokes"},
      {"/time_scale", 1, false, "1", "none",
       "speed of the plan's clock: 1 as planned, 0 where the plan waits for the pen"},
      {"/controller/step_time", 1, false, "s", "none", "wall time of the controller step"},
  };
  columns.insert(columns.end(), rest.begin(), rest.end());
  if (header.line_width)
    columns.push_back({kLineWidthColumn, 1, false, "mm", "none",
                       "width of the line that the pen draws with the contact's force; NaN without "
                       "ink"});
  if (header.moving_canvas) {
    columns.push_back({kCanvasPoseColumn, 7, false, "m, 1", "world",
                       "true pose of the canvas's frame, position and quaternion w x y z; the "
                       "world's at time 0"});
    columns.push_back({kEstimatedCanvasPoseColumn, 7, false, "m, 1", "world",
                       "the same as the controller estimates it"});
    columns.push_back({"/canvas/estimated_twist", 6, false, "m/s, rad/s", "world",
                       "estimated velocity of that frame's origin, and its angular velocity"});
  }
  return columns;
}

const std::vector<LogColumn>& step_columns(bool moving_canvas) {
  static const auto with_frame = [](const char* canvas) {
    return std::vector<LogColumn>{
        {"/every_step/time", 1, false, "s", "none",
         "simulated time at the start of the control step"},
        {"/every_step/normal_force", 1, false, "N", "contact normal",
         "true force of the canvas on the tip along the outward normal; zero out of contact"},
        {"/every_step/contact_point", 3, false, "m", canvas,
         "point of the canvas closest to the centre of the tip sphere; NaN out of contact"},
        {"/every_step/tilt", 1, false, "rad", "none",
         "angle between the pen and the canvas's true normal; NaN but on pen-down ink"},
        {"/every_step/normal_error", 1, false, "rad", "none",
         "angle between the estimated and the true normal; NaN but on pen-down ink"},
        {"/every_step/tracking_error", 1, false, "m", "none",
         "distance of the tip from its desired position, along the canvas; NaN but on pen-down "
         "ink"},
        {"/every_step/push", 1, false, "N", "surface normal", "normal force asked for"},
        {"/every_step/torque_share", 1, false, "1", "none",
         "largest joint torque against its limit, to a float's precision"},
        {"/every_step/joint_margin", 1, false, "rad", "joint axes",
         "smallest distance of a joint to its limits up to this step"},
        {kSpeedShareColumn, 1, false, "1", "joint axes",
         "largest joint speed against its limit up to this step; NaN without limits"},
        {"/every_step/clipped", 1, true, "1", "none", "1 where a joint's torque was limited"},
        {"/every_step/mode", 1, true, "1", "none",
         "contact state of the controller; attribute names of /mode says which"},
        {"/every_step/stroke", 1, true, "1", "none",
         "stroke that the plan is drawing, from the plan alone; -1 between strokes"},
        {"/every_step/stroke_along", 1, false, "m", "drawing plane",
         "length along the stroke of the desired point; NaN between strokes"},
        {"/every_step/felt_force", 1, false, "N", "surface normal",
         "measured force along the estimated normal, to a float's precision; NaN without an "
         "estimate"},
        {"/every_step/time_scale", 1, false, "1", "none",
         "speed of the plan's clock, to a float's precision"},
        {"/every_step/step_time", 1, false, "s", "none",
         "wall time of the controller step, to a float's precision"},
    };
  };
  static const std::vector<LogColumn> still = with_frame("world"), moving = with_frame("canvas");
  return moving_canvas ? moving : still;
}

}  // namespace impedraw
