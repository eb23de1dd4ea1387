#include "impedraw/metrics/metrics.h"

#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/metrics/ending.h"

namespace impedraw {

Metric::Metric(double value) {
  if (std::isfinite(value)) {
    value_ = value;
    reason_.clear();
  } else {
    reason_ = "not a finite number";
  }
}

Metric Metric::missing(std::string reason) {
  Metric metric;
  metric.reason_ = std::move(reason);
  return metric;
}

double Metric::or_nan() const { return value_.value_or(std::numeric_limits<double>::quiet_NaN()); }

const std::vector<MetricDefinition>& metric_definitions() {
  static const std::vector<MetricDefinition> definitions = {
      {"contact_fraction", "1", "pen-down samples with ink / all pen-down samples",
       &Metrics::contact_fraction},
      {"strokes_missed", "1", "strokes without any ink", &Metrics::strokes_missed, true},
      {"ink_error_rms", "mm", "distance of the ink to its own target line, root mean square",
       &Metrics::ink_error_rms},
      {"ink_error_p95", "mm", "the same, 95th percentile", &Metrics::ink_error_p95},
      {"ink_error_max", "mm", "the same, largest", &Metrics::ink_error_max},
      {"ink_error_rms_to_45", "mm",
       "ink_error_rms where the canvas leans by less than 45° from the drawing axis",
       &Metrics::ink_error_rms_to_45},
      {"tracking_error_rms", "mm",
       "distance of the tip from where the controller wanted it at that instant, along the canvas, "
       "root mean square; a lag along the line counts",
       &Metrics::tracking_error_rms},
      {"tracking_error_max", "mm", "the same, largest", &Metrics::tracking_error_max},
      {"coverage", "1", "share of the target's length with ink within 0.5 mm", &Metrics::coverage},
      {"gaps", "1", "uncovered spans longer than 1 mm", &Metrics::gaps, true},
      {"longest_gap", "mm", "the longest of them", &Metrics::longest_gap},
      {"ink_outside", "1", "share of the ink's length further than 1 mm from its target",
       &Metrics::ink_outside},
      {"ink_up", "mm", "ink while the pen had to be up", &Metrics::ink_up},
      {"force_mean", "N", "normal force, from 0.2 s after the first touch on",
       &Metrics::force_mean},
      {"force_sd", "N", "the same, standard deviation", &Metrics::force_sd},
      {"force_rms_error", "N", "the same against the force asked for, root mean square",
       &Metrics::force_rms_error},
      {"force_peak", "N", "the same, largest", &Metrics::force_peak},
      {"touchdown_peak", "N", "largest normal force in the 0.2 s from a first touch",
       &Metrics::touchdown_peak},
      {"width_error_rms", "1",
       "drawn width of the line against that of the force asked for, as a share of the latter, "
       "root "
       "mean square; from 0.2 s after the first touch on",
       &Metrics::width_error_rms},
      {"contact_force_max", "N", "largest normal force of all rows, also while the pen is up",
       &Metrics::contact_force_max},
      {"tilt_mean", "deg", "pen against the canvas's normal, mean", &Metrics::tilt_mean},
      {"tilt_p95", "deg", "the same, 95th percentile", &Metrics::tilt_p95},
      {"tilt_max", "deg", "the same, largest", &Metrics::tilt_max},
      {"normal_error_mean", "deg", "estimated against true normal, mean",
       &Metrics::normal_error_mean},
      {"normal_error_p95", "deg", "the same, 95th percentile", &Metrics::normal_error_p95},
      {"cloud_bias_mean", "mm", "cloud above the true canvas, mean", &Metrics::cloud_bias_mean},
      {"cloud_bias_sd", "mm", "the same, standard deviation", &Metrics::cloud_bias_sd},
      {"speed_mean", "mm/s", "speed of the contact point along the ink, mean",
       &Metrics::speed_mean},
      {"speed_p95", "mm/s", "the same, 95th percentile", &Metrics::speed_p95},
      {"draw_time", "s", "pen-down time", &Metrics::draw_time},
      {"time_scale_mean", "1", "speed of the plan's clock over pen-down samples, mean",
       &Metrics::time_scale_mean},
      {"drawn", "1", "share of the artwork's length that has ink, wherever it lies",
       &Metrics::drawn},
      {"length_asked", "mm", "length of the artwork, in the drawing plane", &Metrics::length_asked},
      {"length_promised", "mm", "of that, what the pre-flight promised", &Metrics::length_promised},
      {"length_undrawable", "mm", "of that, what the pre-flight named as not drawable",
       &Metrics::length_undrawable},
      {"length_unnamed", "mm", "of that, neither promised nor named; 0 but for a fault",
       &Metrics::length_unnamed},
      {"length_reachable", "mm",
       "of the artwork, where the true canvas leans by less than 75°, within the arm's reach",
       &Metrics::length_reachable},
      {"slope_max", "deg", "steepest slope of the canvas under the target, against the level",
       &Metrics::slope_max},
      {"planned_time", "s", "duration of the planned path", &Metrics::planned_time},
      {"torque_saturated", "1", "share of steps in which a joint's torque was clipped",
       &Metrics::torque_saturated},
      {"joint_margin_min", "rad", "smallest distance to a joint limit", &Metrics::joint_margin_min},
      {"joint_speed_share_max", "1", "largest joint speed as a share of its limit",
       &Metrics::joint_speed_share_max},
      {"step_time_p50", "µs", "controller step, median", &Metrics::step_time_p50},
      {"step_time_p99", "µs", "the same, 99th percentile", &Metrics::step_time_p99},
      {"step_time_p999", "µs", "the same, 99.9th percentile", &Metrics::step_time_p999},
      {"real_time_factor", "1", "simulated seconds per wall second of the loop, logging included",
       &Metrics::real_time_factor},
  };
  return definitions;
}

nlohmann::ordered_json metrics_json(const Metrics& metrics) {
  using Json = nlohmann::ordered_json;
  const auto number = [](const std::optional<double>& value, bool count) {
    if (!value) return Json(nullptr);
    return count ? Json(std::llround(*value)) : Json(*value);
  };
  const auto seconds = [](double s) { return std::isfinite(s) ? Json(s) : Json(nullptr); };
  Json out;
  Json reasons = Json::object();
  for (const MetricDefinition& d : metric_definitions()) {
    const Metric& metric = metrics.*d.member;
    out[d.name] = number(metric.value(), d.count);
    if (!metric.value()) reasons[d.name] = metric.reason();
  }
  out["not_drawn"] = metrics.not_drawn;
  out["not_drawn_mm"] = metrics.not_drawn_mm;
  out["ending"] = {{"end", name_of(metrics.ending.end)}, {"cause", metrics.ending.cause}};
  if (!metrics.ending.incident.empty()) out["ending"]["incident"] = metrics.ending.incident;
  out["reasons"] = reasons;
  // The real-time factor excludes start-up and reports.
  out["wall_seconds"] = {{"start_up", seconds(metrics.wall.start_up)},
                         {"loop", seconds(metrics.wall.loop)},
                         {"writing", seconds(metrics.wall.writing)}};
  return out;
}

std::string metrics_table(const Metrics& metrics) {
  std::string text;
  for (const MetricDefinition& d : metric_definitions()) {
    const auto& value = (metrics.*d.member).value();
    const std::string number = value ? fmt::format("{:.5g}", *value) : "-";
    const std::string unit = std::string_view(d.unit) == "1" ? "" : d.unit;
    text += fmt::format("  {:<20} {:>10} {}\n", d.name, number, unit);
  }
  return text;
}

std::string metrics_summary(const Metrics& m, Trace trace) {
  // Whole only where nothing is missing.
  const auto percent = [](double share) { return std::floor(100.0 * share + 1e-9); };
  std::string text = fmt::format("  end         {}\n", told(m.ending));
  if (m.drawn.value()) {
    const double asked = *m.length_asked.value();
    const std::string rest = rest_text(m.not_drawn_mm);
    text += fmt::format("  drew {} of {}, {:.0f} %{}{}\n", length_text(*m.drawn.value() * asked),
                        length_text(asked), percent(*m.drawn.value()),
                        rest.empty() ? "" : "; the rest: ", rest);
  }
  const auto row = [&](const char* name, const Metric& metric, const auto& value) {
    if (trace != Trace::line && (&metric == &m.ink_error_rms || &metric == &m.coverage)) return;
    if (trace == Trace::none && &metric == &m.force_mean) return;
    text += fmt::format("  {:<11} {}\n", name,
                        metric.value() ? value(*metric.value()) : "none: " + metric.reason());
  };
  row("ink error", m.ink_error_rms, [&](double rms) {
    return fmt::format("{:.2g} mm RMS, {:.2g} mm at most", rms, m.ink_error_max.or_nan());
  });
  row("force", m.force_mean, [&](double mean) {
    // About a constant force the error is no smaller than the standard deviation: where it is, the
    // force that was asked for varied.
    const double sd = m.force_sd.or_nan(), error = m.force_rms_error.or_nan();
    return error < 0.99 * sd
               ? fmt::format("{:.3g} N on average, {:.2g} N RMS from the force asked for", mean,
                             error)
               : fmt::format("{:.3g} ± {:.2g} N", mean, sd);
  });
  row("coverage", m.coverage,
      [&](double share) { return fmt::format("{:.0f} % of the line", percent(share)); });
  row("time", m.draw_time,
      [](double seconds) { return fmt::format("{:.1f} s with the pen down", seconds); });
  return text;
}

}  // namespace impedraw
