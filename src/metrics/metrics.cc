#include "impedraw/metrics/metrics.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "impedraw/canvas/canvas.h"
#include "impedraw/common/errors.h"
#include "impedraw/metrics/pens.h"
#include "impedraw/metrics/statistics.h"

namespace impedraw {
namespace {

constexpr double kReach = 0.5e-3;      // within which ink covers the target [m]
constexpr double kShortestGap = 1e-3;  // [m]
constexpr double kOutside = 1e-3;      // [m]
// after the first touch [s]; the margin absorbs the rounding of times
constexpr double kSettling = 0.2 + 1e-9;
constexpr double kGentle = std::numbers::pi / 4;  // slope [rad]
constexpr double kDegrees = 180.0 / std::numbers::pi;

// Gives several missing metrics the same reason.
void lack(Metrics& metrics, std::initializer_list<Metric Metrics::*> members,
          const std::string& reason) {
  for (const auto member : members) metrics.*member = Metric::missing(reason);
}

Metric value_or(bool known, double value, const char* reason) {
  return known ? Metric(value) : Metric::missing(reason);
}

// Statistics of x, or the reason for which there is no x.
using Statistic = double (*)(const std::vector<double>&);
void fill(Metrics& m, const std::vector<double>& x, const std::string& reason,
          std::initializer_list<std::pair<Metric Metrics::*, Statistic>> of) {
  for (const auto& [member, statistic] : of)
    m.*member = x.empty() ? Metric::missing(reason) : Metric(statistic(x));
}

template <int kPerMille>
double percentile_of(const std::vector<double>& x) {
  return percentile(x, kPerMille / 1000.0);
}

std::vector<double> finite(const std::vector<double>& x, double scale) {
  std::vector<double> out;
  for (const double value : x) {
    if (std::isfinite(value)) out.push_back(scale * value);
  }
  return out;
}

double length_of(const RunData& run, std::size_t i) {
  return (run.contact_point[i + 1] - run.contact_point[i]).norm();
}

float time_scale(const RunData& run, std::size_t i) {
  return run.time_scale.empty() ? 1.0f : run.time_scale[i];
}

// The plan runs, so that the row counts towards statistics of contact, path and force.
bool counts(const RunData& run, std::size_t i) { return !(time_scale(run, i) < kStands); }

// On a stroke, wherever it lies.
bool has_ink(const InkMatch& d) {
  return std::any_of(d.lines.begin(), d.lines.end(),
                     [](const InkLine& line) { return line.stroke >= 0; });
}

void contact(const RunData& run, const InkMatch& d, Metrics& m) {
  std::size_t down = 0, ink = 0;
  for (std::size_t i = 0; i < run.rows(); ++i) {
    if (!counts(run, i)) continue;
    down += run.stroke[i] >= 0;
    ink += run.stroke[i] >= 0 && is_ink(run.f[i]);
  }
  m.contact_fraction = value_or(down > 0, static_cast<double>(ink) / static_cast<double>(down),
                                "no pen-down sample");
  if (d.strokes.empty()) {
    lack(m, {&Metrics::strokes_missed}, "no stroke in target or plan");
    return;
  }
  std::set<int> inked;
  for (const InkLine& line : d.lines) inked.insert(line.stroke);
  const auto missed = std::count_if(d.strokes.begin(), d.strokes.end(),
                                    [&](int stroke) { return !inked.contains(stroke); });
  m.strokes_missed = static_cast<double>(missed);
}

void accuracy(const RunData& run, const InkMatch& d, Metrics& m) {
  fill(m, finite(d.error, 1e3),
       has_ink(d) ? "no target for the strokes with ink" : "no pen-down ink",
       {{&Metrics::ink_error_rms, root_mean_square},
        {&Metrics::ink_error_p95, percentile_of<950>},
        {&Metrics::ink_error_max, maximum}});
  double length = 0.0, outside = 0.0;
  for (const InkLine& line : d.lines) {
    if (line.stroke < 0) continue;
    for (std::size_t i = line.begin; i + 1 < line.end; ++i) {
      const double near = std::min(d.error[i], d.error[i + 1]),
                   far = std::max(d.error[i], d.error[i + 1]);
      if (!std::isfinite(near + far)) continue;
      const double piece = length_of(run, i);
      length += piece;
      if (far > kOutside)
        outside += near >= kOutside ? piece : piece * (far - kOutside) / (far - near);
    }
  }
  m.ink_outside =
      value_or(length != 0.0, outside / length, "no pen-down ink of any length with a target");
}

void tracking(const RunData& run, Metrics& m) {
  std::vector<double> error;
  for (std::size_t i = 0; i < run.rows(); ++i)
    if (counts(run, i) && std::isfinite(run.tracking_error[i]))
      error.push_back(1e3 * run.tracking_error[i]);
  fill(m, error, "no pen-down ink, or a log of an older version",
       {{&Metrics::tracking_error_rms, root_mean_square}, {&Metrics::tracking_error_max, maximum}});
}

void coverage(const RunData& run, const InkMatch& d, Metrics& m) {
  double length = 0.0, uncovered = 0.0, longest = 0.0;
  std::size_t gaps = 0;
  std::map<int, std::vector<RunData::Points>> ink_of;
  for (const InkLine& line : d.lines)
    ink_of[line.stroke].emplace_back(run.contact_point.begin() + line.begin,
                                     run.contact_point.begin() + line.end);
  for (std::size_t s = 0; s < d.strokes.size(); ++s) {
    const std::vector<RunData::Points>& ink = ink_of[d.strokes[s]];
    const Coverage c = cover(d.targets[s], Segments(ink, kSampleSpacing), kReach);
    length += c.length;
    for (const double span : c.uncovered_spans) {
      uncovered += span;
      if (span <= kShortestGap) continue;
      ++gaps;
      longest = std::max(longest, span);
    }
  }
  if (length == 0.0) {
    lack(m, {&Metrics::coverage, &Metrics::gaps, &Metrics::longest_gap}, "no target of any length");
    return;
  }
  m.coverage = 1.0 - uncovered / length;  // exactly 1 if nothing is uncovered
  m.gaps = static_cast<double>(gaps);
  m.longest_gap = 1e3 * longest;
}

void stray_ink(const RunData& run, const InkMatch& d, Metrics& m) {
  if (run.rows() == 0) return lack(m, {&Metrics::ink_up}, "no rows");
  const std::vector<bool> up = pen_must_be_up(run, d);
  double length = 0.0;
  for (const InkLine& line : d.lines) {
    for (std::size_t i = line.begin; i + 1 < line.end; ++i) {
      if (up[i] && up[i + 1]) length += length_of(run, i);
    }
  }
  m.ink_up = 1e3 * length;
}

void force(const RunData& run, const InkMatch& d, Metrics& m) {
  fill(m, finite(run.f, 1.0), "no rows", {{&Metrics::contact_force_max, maximum}});
  const std::optional<DrawnPens> pens = read_pens(run.attributes);
  std::vector<double> settled, error, width_error;
  double touchdown = -1.0;
  for (const StrokeSpan& span : d.spans) {  // each pass over a stroke has its own touchdown
    if (!span.first_touch) continue;
    const double touched = run.time[*span.first_touch];
    for (std::size_t i = *span.first_touch; i < run.rows() && run.time[i] - touched <= kSettling;
         ++i) {
      touchdown = std::max(touchdown, run.f[i]);
    }
    for (std::size_t i = span.begin; i < span.end; ++i) {
      if (!counts(run, i) || !is_ink(run.f[i]) || run.time[i] - touched <= kSettling) continue;
      settled.push_back(run.f[i]);
      if (std::isfinite(run.push[i])) error.push_back(run.f[i] - run.push[i]);
      if (!pens || !pens->of(run.stroke[i]).line.presses() || !(run.push[i] > 0.0)) continue;
      const PenSettings& pen = pens->of(run.stroke[i]).line;
      width_error.push_back(pen.width_at(run.f[i]) / pen.width_at(run.push[i]) - 1.0);
    }
  }
  fill(m, width_error, "no pen whose width changes with its force has ink",
       {{&Metrics::width_error_rms, root_mean_square}});
  m.touchdown_peak = value_or(touchdown >= 0.0, touchdown, "no stroke was touched");
  const char* const no_ink = "no pen-down ink later than 0.2 s after a first touch";
  fill(m, settled, no_ink,
       {{&Metrics::force_mean, mean},
        {&Metrics::force_sd, standard_deviation},
        {&Metrics::force_peak, maximum}});
  fill(m, error, settled.empty() ? no_ink : "no normal force was asked for",
       {{&Metrics::force_rms_error, root_mean_square}});
}

void angles(const RunData& run, Metrics& m) {
  const std::vector<double> tilt = finite(run.tilt, kDegrees);
  fill(m, tilt, "no pen-down ink",
       {{&Metrics::tilt_mean, mean},
        {&Metrics::tilt_p95, percentile_of<950>},
        {&Metrics::tilt_max, maximum}});
  fill(m, finite(run.normal_error, kDegrees),
       tilt.empty() ? "no pen-down ink" : "the controller had no estimate of the surface",
       {{&Metrics::normal_error_mean, mean}, {&Metrics::normal_error_p95, percentile_of<950>}});
}

// The canvas of the log, made where a metric needs it.
class LoggedCanvas {
 public:
  LoggedCanvas(const RunData& run, const Canvas* known) : run_(run), known_(known) {}
  // Throws InputError where the log holds none, or a faulty one.
  const Canvas& get() {
    if (known_) return *known_;
    if (!canvas_) {
      if (run_.canvas_triangles.empty()) throw InputError("the log holds no canvas");
      canvas_.emplace(TriangleMesh{run_.canvas_vertices, run_.canvas_triangles});
    }
    return *canvas_;
  }

 private:
  const RunData& run_;
  const Canvas* known_;
  std::optional<Canvas> canvas_;
};

void cloud(const RunData& run, LoggedCanvas& canvas, Metrics& m) {
  if (run.cloud_points.empty())
    return lack(m, {&Metrics::cloud_bias_mean, &Metrics::cloud_bias_sd},
                "no cloud: the run had no perception");
  try {
    std::vector<double> distance;
    for (const Eigen::Vector3d& p : run.cloud_points)
      distance.push_back(1e3 * canvas.get().closest(p).distance);
    m.cloud_bias_mean = mean(distance);
    m.cloud_bias_sd = standard_deviation(distance);
  } catch (const InputError& e) {
    lack(m, {&Metrics::cloud_bias_mean, &Metrics::cloud_bias_sd}, e.what());
  }
}

// No normal of the canvas, interpolated between its triangles' or not, leans by kGentle or more.
bool is_gentle(const RunData& run, const Eigen::Vector3d& axis_W) {
  const auto& p = run.canvas_vertices;
  return std::all_of(run.canvas_triangles.begin(), run.canvas_triangles.end(),
                     [&](const Eigen::Vector3i& t) {
                       const Eigen::Vector3d n = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
                       return n.dot(axis_W) > std::cos(kGentle) * n.norm();
                     });
}

void gentle_ink(const RunData& run, const InkMatch& d, const std::optional<Promise>& promise,
                LoggedCanvas& canvas, Metrics& m) {
  if (!promise)
    return lack(m, {&Metrics::ink_error_rms_to_45}, "the log does not hold the drawing axis");
  try {
    std::vector<double> error;
    const bool all = !run.canvas_triangles.empty() && is_gentle(run, promise->axis_W);
    for (std::size_t i = 0; i < d.error.size(); ++i) {
      if (!std::isfinite(d.error[i])) continue;
      if (!all) {
        const auto there = canvas.get().closest(run.contact_point[i], 1e-3);
        if (!there || there->n_W.dot(promise->axis_W) <= std::cos(kGentle)) continue;
      }
      error.push_back(1e3 * d.error[i]);
    }
    fill(m, error, "no ink with a target on slopes below 45°",
         {{&Metrics::ink_error_rms_to_45, root_mean_square}});
  } catch (const InputError& e) {
    lack(m, {&Metrics::ink_error_rms_to_45}, e.what());
  }
}

void promised(const RunData& run, const std::optional<Promise>& promise, Metrics& m) {
  if (!promise)
    return lack(m,
                {&Metrics::length_asked, &Metrics::length_promised, &Metrics::length_undrawable,
                 &Metrics::length_unnamed, &Metrics::length_reachable, &Metrics::slope_max,
                 &Metrics::planned_time, &Metrics::drawn},
                "the log does not say what the pre-flight promised");
  m.length_asked = 1e3 * promise->asked;
  m.length_promised = 1e3 * promise->promised;
  m.length_undrawable = 1e3 * promise->undrawable;
  m.length_unnamed = 1e3 * promise->unnamed;
  if (promise->reachable)
    m.length_reachable = 1e3 * *promise->reachable;
  else
    lack(m, {&Metrics::length_reachable}, "the drawing is wrapped, or the log is an older one");
  m.slope_max = kDegrees * promise->slope;
  m.planned_time = promise->time;
  m.not_drawn = promise->problems;
  const bool placed = std::any_of(run.stroke_along.begin(), run.stroke_along.end(),
                                  [](float along) { return std::isfinite(along); });
  const bool down = std::any_of(run.stroke.begin(), run.stroke.end(), [](int s) { return s >= 0; });
  if (!promise->asks_ink || !(promise->asked > 0.0) || (down && !placed))
    return lack(m, {&Metrics::drawn},
                !promise->asks_ink        ? "a dry run, without ink"
                : !(promise->asked > 0.0) ? "the artwork has no length"
                                          : "the log does not say where on a stroke a row is");
  const DrawnLengths lengths = drawn_lengths(run, *promise, m.ending);
  m.drawn = lengths.drawn / lengths.asked;
  for (const auto& [reason, length] : lengths.not_drawn) m.not_drawn_mm[reason] = 1e3 * length;
}

void clock(const RunData& run, Metrics& m) {
  std::vector<double> scale;
  for (std::size_t i = 0; i < run.rows(); ++i)
    if (run.stroke[i] >= 0) scale.push_back(time_scale(run, i));
  fill(m, scale, "no pen-down sample", {{&Metrics::time_scale_mean, mean}});
}

void motion(const RunData& run, const InkMatch& d, Metrics& m) {
  std::vector<double> speed;
  for (const InkLine& line : d.lines) {
    if (line.stroke < 0) continue;
    for (std::size_t i = line.begin; i + 1 < line.end; ++i) {
      const double dt = run.time[i + 1] - run.time[i];
      if (dt > 0.0) speed.push_back(1e3 * length_of(run, i) / dt);
    }
  }
  fill(m, speed, "no pen-down ink of two rows",
       {{&Metrics::speed_mean, mean}, {&Metrics::speed_p95, percentile_of<950>}});
  const std::size_t n = run.rows();
  if (n < 2) {
    lack(m, {&Metrics::draw_time, &Metrics::real_time_factor}, "fewer than two rows");
    return;
  }
  const double last_step = run.time[n - 1] - run.time[n - 2];
  double drawing = 0.0;
  for (const StrokeSpan& span : d.spans) {
    drawing +=
        (span.end < n ? run.time[span.end] : run.time[n - 1] + last_step) - run.time[span.begin];
  }
  m.draw_time = drawing;
  const double wall = run.wall.loop + (std::isfinite(run.wall.writing) ? run.wall.writing : 0.0);
  m.real_time_factor = value_or(std::isfinite(wall) && wall > 0.0,
                                (run.time[n - 1] + last_step - run.time[0]) / wall,
                                "the log was not closed, or the loop not timed");
}

void arm(const RunData& run, Metrics& m) {
  if (run.rows() == 0)
    return lack(
        m,
        {&Metrics::torque_saturated, &Metrics::joint_margin_min, &Metrics::joint_speed_share_max},
        "no rows");
  m.torque_saturated =
      value_or(run.clipped.has_value(),
               static_cast<double>(run.clipped.value_or(0)) / static_cast<double>(run.rows()),
               "the log holds no torque terms");
  m.joint_margin_min =
      value_or(std::isfinite(run.joint_margin), run.joint_margin, "the arm has no joint limits");
  m.joint_speed_share_max = value_or(std::isfinite(run.joint_speed_share), run.joint_speed_share,
                                     "the log holds no joint speed limits");
}

void step_time(const RunData& run, Metrics& m) {
  fill(m, finite(run.step_time, 1e6), "no step was timed",
       {{&Metrics::step_time_p50, percentile_of<500>},
        {&Metrics::step_time_p99, percentile_of<990>},
        {&Metrics::step_time_p999, percentile_of<999>}});
}

}  // namespace

Metrics compute_metrics(const RunData& run) { return compute_metrics(run, match_ink(run)); }

Metrics compute_metrics(const RunData& run, const InkMatch& drawn, const Canvas* canvas_of_log) {
  Metrics m;
  m.ending = read_ending(run.attributes);
  contact(run, drawn, m);
  accuracy(run, drawn, m);
  tracking(run, m);
  coverage(run, drawn, m);
  stray_ink(run, drawn, m);
  force(run, drawn, m);
  angles(run, m);
  const std::optional<Promise> promise = read_promise(run.attributes);
  LoggedCanvas canvas(run, canvas_of_log);
  cloud(run, canvas, m);
  gentle_ink(run, drawn, promise, canvas, m);
  promised(run, promise, m);
  motion(run, drawn, m);
  clock(run, m);
  arm(run, m);
  step_time(run, m);
  // A run of an arm that is not simulated here, and whose wrench nobody measured.
  if (run.rows() > 0 &&
      std::all_of(run.f.begin(), run.f.end(), [](double f) { return std::isnan(f); })) {
    lack(m, {&Metrics::contact_fraction,   &Metrics::strokes_missed, &Metrics::ink_error_rms,
             &Metrics::ink_error_p95,      &Metrics::ink_error_max,  &Metrics::tracking_error_rms,
             &Metrics::tracking_error_max, &Metrics::coverage,       &Metrics::gaps,
             &Metrics::longest_gap,        &Metrics::ink_outside,    &Metrics::ink_up,
             &Metrics::force_mean,         &Metrics::force_sd,       &Metrics::force_rms_error,
             &Metrics::force_peak,         &Metrics::touchdown_peak, &Metrics::tilt_mean,
             &Metrics::tilt_p95,           &Metrics::tilt_max,       &Metrics::normal_error_mean,
             &Metrics::normal_error_p95,   &Metrics::speed_mean,     &Metrics::speed_p95,
             &Metrics::contact_force_max,  &Metrics::drawn,          &Metrics::width_error_rms},
         "contact is unknown: the arm was not simulated here, and no wrench was measured");
    m.not_drawn_mm.erase("no_ink");
  } else if (!drawn.strokes.empty()) {
    m.ending = judged(m.ending, m, has_ink(drawn), promise.value_or(Promise()));
  }
  m.wall = run.wall;
  return m;
}

}  // namespace impedraw
