// Description of the pre-flight's settings (preflight.h).
// See control/describe_control.h.
#pragma once

#include "impedraw/planning/preflight/clearance.h"
#include "impedraw/planning/preflight/preflight.h"

namespace impedraw {

template <class F>
void describe(F& f, PreflightSettings& s) {
  f.field("arm", s.arm,
          "Checks the arm's reach, joints, torques and collisions; off: only the surface is "
          "checked.");
  f.constant("step", s.step, {1e-4, 0.1}, "m");
  f.constant("edge_tolerance", s.edge_tolerance, {1e-6, 0.01}, "m");
  f.constant("edge_margin", s.edge_margin, {0.0, 0.1}, "m");
  f.constant("shortest", s.shortest, {0.0, 1.0}, "m");
  f.field("least_speed", s.least_speed, {0.0, 1.0}, "m/s",
          "Mean speed of the drawing, but at most half of path.draw_speed. What the surface or the "
          "joints slow down too far for it is not drawn; 0: all is drawn.");
  f.field("roughest", s.roughest, {1e-5, 0.01}, "m",
          "RMS height that the cameras do not resolve, beyond which a place is not drawn on: ink "
          "would lie over 0.5 mm off the line. 8e-4: only steps are kept off.");
  f.constant("max_slope", s.max_slope_deg, {1.0, 89.0}, "deg");
  f.constant("fold_height", s.fold_height, {1e-6, 0.1}, "m");
  f.constant("joint_margin", s.joint_margin, {0.0, 1.0}, "rad");
  f.constant("max_joint_step", s.max_joint_step, {0.001, 3.0}, "rad");
  f.field("clearance", s.clearance, {0.0, kFarEnough / 2}, "m",
          "Distance that arm and pen keep from canvas and table; the pen's grows from zero at the "
          "tip.");
  f.field("table_z", s.table_z, {-2.0, 2.0}, "m", "Height of a table; null: there is none.");
}

}  // namespace impedraw
