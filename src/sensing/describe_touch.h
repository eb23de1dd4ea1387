// Description of the settings of a surface that is learned from touch: see
// control/describe_control.h.
#pragma once

#include "impedraw/sensing/touch_settings.h"

namespace impedraw {

template <class F>
void describe(F& f, TouchSettings& s) {
  f.constant("slope", s.slope, {0.01, 10.0}, "");
  f.constant("curvature", s.curvature, {0.0, 1000.0}, "1/m");
  f.constant("curvature_length", s.curvature_length, {1e-3, 10.0}, "m");
  f.constant("position_noise", s.position_noise, {1e-7, 1e-2}, "m");
  f.constant("force_noise", s.force_noise, {1e-4, 10.0}, "");
  f.constant("spacing", s.spacing, {1e-6, 1e-2}, "m");
  f.constant("slip_speed", s.slip_speed, {1e-4, 1.0}, "m/s");
  f.field("turn_rate", s.turn_rate, {0.01, 100.0}, "rad/s",
          "Largest angular speed of the learned normal.");
  f.constant("search", s.search, {1e-4, 0.1}, "m");
  f.constant("settle_time", s.settle_time, {0.0, 10.0}, "s");
}

}  // namespace impedraw
