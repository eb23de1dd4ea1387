// metrics.json: the metrics of a run, computed from run.h5 alone.
//
// Samples      pen-down: /stroke ≥ 0. f = force · normal. Ink: f > 0.1 N. First touch:
//              ink/ink_lines.h.
//              SD is that of the population. Percentiles interpolate linearly. Forces are pooled
//              over strokes.
// Keys         in the order of metric_definitions(), then `not_drawn`: {problem: findings},
//              `not_drawn_mm`: {reason: length}, `ending`: {end, cause} (ending.h),
//              `reasons`: {name: why it is null} and `wall_seconds`. A metric that cannot be
//              computed is null, not 0.
//
// A stroke may be drawn in several passes. Each pass has its own first touch, settling and
// touchdown. The ink of all passes covers the target.
//
// Rows with a time scale below kStands do not count towards contact_fraction, tracking_error_* and
// force_* but touchdown_peak: the plan waits there, and the pen would be counted for its pause. Ink
// that a waiting pen leaves is ink: it counts towards ink_error_*.
//
// coverage is the covered share of the target's length, computed exactly against the ink line. An
// untouched stroke counts as uncovered. Gaps are measured along one stroke; on a closed stroke they
// may cross its start. ink_outside interpolates the distance between a line's points.
// real_time_factor includes the time to write the rest of the log (wall_loop + wall_writing).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "impedraw/log/run_data.h"
#include "impedraw/metrics/ending.h"
#include "impedraw/metrics/ink_match.h"

namespace impedraw {

class Canvas;

// Below this share of its speed the plan stands still.
inline constexpr float kStands = 0.2f;

// A number, or the reason why there is none.
class Metric {
 public:
  Metric() = default;
  Metric(double value);  // no value if not finite
  static Metric missing(std::string reason);

  const std::optional<double>& value() const { return value_; }
  const std::string& reason() const { return reason_; }  // empty if there is a value
  double or_nan() const;

 private:
  std::optional<double> value_;
  std::string reason_ = "not computed";
};

// Units and meanings: metric_definitions().
struct Metrics {
  Metric contact_fraction, strokes_missed;
  Metric ink_error_rms, ink_error_p95, ink_error_max;
  Metric ink_error_rms_to_45;
  Metric tracking_error_rms, tracking_error_max;
  Metric coverage, gaps, longest_gap, ink_outside, ink_up;
  Metric force_mean, force_sd, force_rms_error, force_peak, touchdown_peak;
  Metric contact_force_max, drawn;
  Metric width_error_rms;
  Metric tilt_mean, tilt_p95, tilt_max, normal_error_mean, normal_error_p95;
  Metric cloud_bias_mean, cloud_bias_sd;
  Metric speed_mean, speed_p95, draw_time, time_scale_mean;
  Metric length_asked, length_promised, length_undrawable, length_unnamed, length_reachable;
  Metric slope_max, planned_time;
  Metric torque_saturated, joint_margin_min, joint_speed_share_max;
  Metric step_time_p50, step_time_p99, step_time_p999, real_time_factor;
  std::map<std::string, int> not_drawn;        // findings of the pre-flight, by problem
  std::map<std::string, double> not_drawn_mm;  // by reason (ending.h)
  Ending ending;                               // judged
  WallTimes wall;
};

struct MetricDefinition {
  const char* name;
  const char* unit;  // "1": dimensionless
  const char* meaning;
  Metric Metrics::*member;
  bool count = false;  // a whole number
};

const std::vector<MetricDefinition>& metric_definitions();

Metrics compute_metrics(const RunData& run);
// drawn: match_ink(run). canvas: that of the log, where the caller has it; null: it is made.
Metrics compute_metrics(const RunData& run, const InkMatch& drawn, const Canvas* canvas = nullptr);

nlohmann::ordered_json metrics_json(const Metrics& metrics);  // content of metrics.json
std::string metrics_table(const Metrics& metrics);            // for the terminal
enum class Trace { line, area, none };  // of what the tool leaves; none: it presses on nothing
// For the terminal: how the run ended, how much was drawn and what was not, and the numbers of the
// drawing itself that make sense for such a tool.
std::string metrics_summary(const Metrics& metrics, Trace trace = Trace::line);

}  // namespace impedraw
