#include "impedraw/metrics/metrics.h"

namespace impedraw {

const std::vector<MetricDefinition>& metric_definitions() {
  static const std::vector<MetricDefinition> definitions = {
      {"contact_fraction", "1", "pen-down samples with ink / all pen-down samples"},
      {"strokes_missed", "1", "strokes without any ink"},
      {"ink_error_rms", "mm", "distance of the ink to its own target line, root mean square"},
      {"ink_error_p95", "mm", "the same, 95th percentile"},
      {"ink_error_max", "mm", "the same, largest"},
      {"coverage", "1", "share of the target's length with ink within 0.5 mm"},
      {"gaps", "1", "uncovered spans longer than 1 mm"},
      {"longest_gap", "mm", "the longest of them"},
      {"ink_outside", "1", "share of the ink's length further than 1 mm from its target"},
      {"ink_up", "mm", "ink while the pen had to be up"},
      {"force_mean", "N", "normal force, from 0.2 s after the first touch on"},
      {"force_sd", "N", "the same, standard deviation"},
      {"force_rms_error", "N", "the same against the force asked for, root mean square"},
      {"force_peak", "N", "the same, largest"},
      {"touchdown_peak", "N", "largest normal force in the 0.2 s from a first touch"},
      {"tilt_mean", "deg", "pen against the canvas's normal, mean"},
      {"tilt_p95", "deg", "the same, 95th percentile"},
      {"tilt_max", "deg", "the same, largest"},
      {"normal_error_mean", "deg", "estimated against true normal, mean"},
      {"normal_error_p95", "deg", "the same, 95th percentile"},
      {"cloud_bias_mean", "mm", "cloud above the true canvas, mean"},
      {"cloud_bias_sd", "mm", "the same, standard deviation"},
      {"speed_mean", "mm/s", "speed of the contact point along the ink, mean"},
      {"speed_p95", "mm/s", "the same, 95th percentile"},
      {"draw_time", "s", "pen-down time"},
      {"torque_saturated", "1", "share of steps in which a joint's torque was clipped"},
      {"joint_margin_min", "rad", "smallest distance to a joint limit"},
      {"step_time_p50", "µs", "controller step, median"},
      {"step_time_p99", "µs", "the same, 99th percentile"},
      {"step_time_p999", "µs", "the same, 99.9th percentile"},
      {"real_time_factor", "1", "simulated seconds per wall second of the loop, logging included"},
  };
  return definitions;
}

}  // namespace impedraw
