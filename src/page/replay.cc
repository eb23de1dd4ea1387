#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "impedraw/common/pose.h"
#include "impedraw/ink/segments.h"
#include "impedraw/log/log.h"
#include "impedraw/log/run_rows.h"
#include "impedraw/metrics/statistics.h"
#include "impedraw/page/page.h"
#include "impedraw/page/page_json.h"

namespace impedraw {
namespace {

using Json = nlohmann::json;
using Points = std::vector<Eigen::Vector3d>;

constexpr double kDegrees = 180.0 / std::numbers::pi;
// A point of the target is covered by ink of its own stroke within this distance (as metrics).
constexpr double kCoverReach = 0.5e-3;     // [m]
constexpr double kTargetSpacing = 0.4e-3;  // [m]
constexpr std::size_t kStepBins = 20000, kJointBins = 4000, kTermBins = 2000;
constexpr double kLong = 300.0;  // [s]; longer runs are replayed at the lower rate
constexpr double kFine = 1.0 / 100.0, kCoarse = 1.0 / 60.0;  // [s]

// Smallest and largest value of each bin of rows; NaN where a bin has none.
class Envelopes {
 public:
  Envelopes(std::size_t rows, std::size_t most_bins, std::size_t series)
      : rows_(rows),
        bins_(std::min(rows, most_bins)),
        low_(series, std::vector<double>(bins_, LogRow::kNone)),
        high_(low_) {}

  std::size_t bins() const { return bins_; }
  std::size_t bin_of(std::size_t row) const { return row * bins_ / rows_; }
  std::size_t first_row(std::size_t bin) const { return (bin * rows_ + bins_ - 1) / bins_; }

  void add(std::size_t series, std::size_t row, double v) {
    if (!std::isfinite(v)) return;
    double &low = low_[series][bin_of(row)], &high = high_[series][bin_of(row)];
    if (!(low <= v)) low = v;
    if (!(high >= v)) high = v;
  }

  // {low} or {low, high}
  Json json(PackedColumns& columns, std::size_t series, double quantum) const {
    Json out = {{"low", columns.add(low_[series], quantum)}};
    if (bins_ < rows_) out["high"] = columns.add(high_[series], quantum);
    return out;
  }

 private:
  std::size_t rows_, bins_;
  std::vector<std::vector<double>> low_, high_;
};

// The target's points, and which of them have ink of their own stroke.
Json target_json(PackedColumns& columns, const RunData& run, const InkMatch& drawn) {
  Points points;
  std::vector<double> covered, begins;
  for (std::size_t k = 0; k < drawn.targets.size(); ++k) {
    const Points& target = drawn.targets[k];
    std::vector<Points> ink;
    for (const InkLine& line : drawn.lines)
      if (line.stroke == drawn.strokes[k])
        ink.emplace_back(run.contact_point.begin() + static_cast<std::ptrdiff_t>(line.begin),
                         run.contact_point.begin() + static_cast<std::ptrdiff_t>(line.end));
    const Segments segments(ink, 2e-3);
    begins.push_back(static_cast<double>(points.size()));
    bool before = false;
    for (std::size_t i = 0; i < target.size(); ++i) {
      const bool has_ink = !segments.empty() && segments.distance(target[i]) <= kCoverReach;
      if (i > 0 && i + 1 < target.size() && has_ink == before &&
          (target[i] - points.back()).norm() < kTargetSpacing)
        continue;
      before = has_ink;
      points.push_back(target[i]);
      covered.push_back(has_ink);
    }
  }
  return {{"points", points_json(columns, points, 2e-5)},
          {"covered", columns.add(covered, 1.0)},
          {"begins", columns.add(begins, 1.0)},
          {"strokes", drawn.strokes}};
}

struct Steps {
  std::vector<double> speed;  // [m/s]; NaN except on pen-down ink
};

Steps step_speeds(const RunData& run, const InkMatch& drawn) {
  Steps steps{std::vector<double>(run.rows(), LogRow::kNone)};
  for (const InkLine& line : drawn.lines) {
    if (line.stroke < 0) continue;
    for (std::size_t i = line.begin; i + 1 < line.end; ++i)
      steps.speed[i] = (run.contact_point[i + 1] - run.contact_point[i]).norm() /
                       (run.time[i + 1] - run.time[i]);
  }
  return steps;
}

// Points of the ink, in the order of time. A value belongs to the line from its point to the next
// and is the worst of the steps between: the force furthest from the one asked for, the largest
// error and tilt; the speed is the mean.
Json ink_json(PackedColumns& columns, const RunData& run, const InkMatch& drawn, double spacing) {
  std::vector<double> begins, stroke, pass, time, force, error, tilt, speed;
  Points points;
  const auto larger = [](double a, double b) { return std::isnan(a) || b > a ? b : a; };
  for (const InkLine& line : drawn.lines) {
    begins.push_back(static_cast<double>(points.size()));
    stroke.push_back(line.stroke);
    int earlier = 0;
    for (const StrokeSpan& span : drawn.spans)
      if (span.stroke == line.stroke && span.end <= line.begin) ++earlier;
    pass.push_back(earlier + 1);
    for (std::size_t i = line.begin; i < line.end;) {
      std::size_t next = i + 1;
      while (next < line.end && run.time[next] - run.time[i] < spacing - 1e-9) ++next;
      if (next == line.end && i + 1 < line.end) next = line.end - 1;  // the last point is kept
      double f = run.f[i], e = LogRow::kNone, a = LogRow::kNone;
      for (std::size_t k = i; k < std::min(next, line.end); ++k) {
        if (std::abs(run.f[k] - run.push[k]) > std::abs(f - run.push[i])) f = run.f[k];
        e = larger(e, drawn.error[k]);
        a = larger(a, run.tilt[k]);
      }
      time.push_back(run.time[i]);
      points.push_back(run.contact_point[i]);
      force.push_back(f);
      error.push_back(1e3 * e);
      tilt.push_back(kDegrees * a);
      const double dt = next < line.end ? run.time[next] - run.time[i] : 0.0;
      speed.push_back(dt > 0.0 ? 1e3 * (run.contact_point[next] - run.contact_point[i]).norm() / dt
                               : LogRow::kNone);
      i = next;
    }
  }
  return {{"points", points_json(columns, points, 1e-5)},
          {"time", columns.add(time, 1e-3)},
          {"force", columns.add(force, 2e-3)},
          {"error", columns.add(error, 5e-4)},
          {"tilt", columns.add(tilt, 5e-3)},
          {"speed", columns.add(speed, 0.1)},
          {"begins", columns.add(begins, 1.0)},
          {"stroke", columns.add(stroke, 1.0)},
          {"pass", columns.add(pass, 1.0)}};
}

// The plots of every step.
Json step_plots(PackedColumns& columns, const RunData& run, const InkMatch& drawn) {
  const std::vector<double> speed = step_speeds(run, drawn).speed;
  struct Row {
    const char *name, *label, *unit;
    double quantum;
    std::function<double(std::size_t)> value;
  };
  const std::vector<Row> rows = {
      {"force", "normal force", "N", 1e-3, [&](std::size_t i) { return run.f[i]; }},
      {"push", "force asked for", "N", 1e-3, [&](std::size_t i) { return run.push[i]; }},
      {"ink_error", "ink error", "mm", 1e-4, [&](std::size_t i) { return 1e3 * drawn.error[i]; }},
      {"tilt", "tilt", "deg", 1e-3, [&](std::size_t i) { return kDegrees * run.tilt[i]; }},
      {"normal_error", "error of the normal", "deg", 1e-3,
       [&](std::size_t i) { return kDegrees * run.normal_error[i]; }},
      {"speed", "speed of the contact point", "mm/s", 1e-2,
       [&](std::size_t i) { return 1e3 * speed[i]; }},
      {"torque", "largest joint torque", "% of its limit", 1e-2,
       [&](std::size_t i) { return 100.0 * run.torque_share[i]; }},
      {"mode", "contact state", "", 1.0,
       [&](std::size_t i) { return static_cast<double>(run.mode[i]); }},
      {"time_scale", "speed of the plan's clock", "1", 1e-3,
       [&](std::size_t i) { return run.time_scale.empty() ? 1.0 : run.time_scale[i]; }},
      {"step_time", "controller step", "µs", 0.1,
       [&](std::size_t i) { return 1e6 * run.step_time[i]; }},
  };
  Envelopes bins(run.rows(), kStepBins, rows.size());
  for (std::size_t s = 0; s < rows.size(); ++s)
    for (std::size_t i = 0; i < run.rows(); ++i) bins.add(s, i, rows[s].value(i));
  Json out;
  out["time"] = columns.add(
      bins.bins(), [&](std::size_t b) { return run.time[bins.first_row(b)]; }, 1e-3);
  out["rows_per_point"] =
      static_cast<double>(run.rows()) / static_cast<double>(std::max<std::size_t>(1, bins.bins()));
  out["series"] = Json::array();
  for (std::size_t s = 0; s < rows.size(); ++s)
    out["series"].push_back(series_json(rows[s].name, rows[s].label, rows[s].unit,
                                        bins.json(columns, s, rows[s].quantum)));
  return out;
}

// The plots of a moving canvas: the motion of its centre and its turn, true and estimated, and the
// estimate's error at the tip.
class CanvasPlots {
 public:
  static constexpr std::size_t kSeries = 9;

  CanvasPlots(std::size_t rows, const Points& canvas)
      : centre_(canvas.empty() ? Eigen::Vector3d::Zero() : mean(canvas)),
        bins_(std::max<std::size_t>(rows, 1), kJointBins, kSeries) {}

  void add(std::size_t row, const Pose& truth, const Pose& estimated, const Eigen::Vector3d& tip) {
    std::size_t s = 0;
    for (const Pose* pose : {&truth, &estimated}) {
      const Eigen::Vector3d moved = 1e3 * (*pose * centre_ - centre_);
      for (int axis = 0; axis < 3; ++axis) bins_.add(s++, row, moved[axis]);
      bins_.add(s++, row, kDegrees * Eigen::AngleAxisd(pose->R).angle());
    }
    bins_.add(s, row, 1e3 * (truth * (estimated.inverse() * tip) - tip).norm());
  }

  void write(PackedColumns& columns, Json* series) const {
    static constexpr const char* kNames[kSeries] = {
        "canvas_x",           "canvas_y",           "canvas_z",           "canvas_turn",
        "estimated_canvas_x", "estimated_canvas_y", "estimated_canvas_z", "estimated_canvas_turn",
        "canvas_error"};
    for (std::size_t s = 0; s < kSeries; ++s) {
      const bool turn = s == 3 || s == 7;
      series->push_back(series_json(kNames[s], turn ? "turn of the canvas" : "canvas",
                                    turn ? "deg" : "mm", bins_.json(columns, s, 2e-3)));
    }
  }

 private:
  static Eigen::Vector3d mean(const Points& points) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : points) sum += p;
    return sum / static_cast<double>(points.size());
  }

  Eigen::Vector3d centre_;
  Envelopes bins_;
};

// The rows of the scene, and what the log's rows say of the joints.
void add_rows(PackedColumns& columns, const ReplayLog& log, const RunData& run,
              const PageContext& context, Json* out) {
  const std::size_t n = log.rows(), j = static_cast<std::size_t>(log.joints());
  const std::vector<std::string>& terms = log.torque_terms();
  Envelopes joints(std::max<std::size_t>(n, 1), kJointBins, 3 * j + 1),
      torques(std::max<std::size_t>(n, 1), kTermBins, terms.size() * j);
  std::vector<double> joint_time, term_time;
  std::vector<double> time, mode, stroke;
  std::vector<std::vector<double>> q(j);
  Points tip, pen_axis, force, normal;
  std::vector<std::vector<double>> canvas(log.canvas_moves() ? 7 : 0);
  std::optional<CanvasPlots> canvas_plots;
  if (log.canvas_moves()) canvas_plots.emplace(n, run.canvas_vertices);

  const double duration = run.time.empty() ? 0.0 : run.time.back() - run.time.front();
  const double spacing = duration > kLong ? kCoarse : kFine;
  constexpr std::size_t kBlock = 4096;
  std::size_t read = 0;
  log.visit([&](const LogRow& now) {
    const std::size_t row = read++;
    if (row % kBlock == 0 && context.check) context.check();
    if (joints.first_row(joint_time.size()) == row) joint_time.push_back(now.time);
    if (torques.first_row(term_time.size()) == row) term_time.push_back(now.time);
    for (std::size_t a = 0; a < j; ++a) {
      const auto c = static_cast<Eigen::Index>(a);
      joints.add(3 * a, row, now.joint_position[c]);
      joints.add(3 * a + 1, row, now.joint_velocity[c]);
      joints.add(3 * a + 2, row, now.joint_torque[c]);
      for (std::size_t t = 0; t < terms.size(); ++t)
        torques.add(t * j + a, row, now.torque_terms[t][c]);
    }
    joints.add(3 * j, row, 1e3 * now.surface_distance);
    if (canvas_plots)
      canvas_plots->add(row, now.canvas_pose, now.estimated_canvas_pose, now.tip_position);
    if (!time.empty() && row + 1 < n && now.time < time.back() + spacing - 1e-9) return;
    time.push_back(now.time);
    for (std::size_t a = 0; a < j; ++a)
      q[a].push_back(now.joint_position[static_cast<Eigen::Index>(a)]);
    tip.push_back(now.tip_position);
    pen_axis.push_back(now.tip_orientation.toRotationMatrix().col(2));
    force.push_back(now.contact_force);
    normal.push_back(now.surface_normal);
    if (!canvas.empty()) {
      const Eigen::Quaterniond turn(now.canvas_pose.R);
      Eigen::Matrix<double, 7, 1> pose;
      pose << now.canvas_pose.p, turn.w(), turn.vec();
      // q and −q are the same turn: without jumps, so that it can be interpolated and packed.
      double same = 0.0;
      for (int a = 3; a < 7; ++a)
        if (const auto& q_a = canvas[static_cast<std::size_t>(a)]; !q_a.empty())
          same += q_a.back() * pose[a];
      if (same < 0.0) pose.tail<4>() *= -1.0;
      for (std::size_t a = 0; a < 7; ++a) canvas[a].push_back(pose[static_cast<Eigen::Index>(a)]);
    }
    mode.push_back(now.mode);
    stroke.push_back(now.stroke);
  });
  // A log that breaks off: the bins beyond have no time.
  while (joint_time.size() < joints.bins())
    joint_time.push_back(joint_time.empty() ? 0.0 : joint_time.back() + 1e-3);
  while (term_time.size() < torques.bins())
    term_time.push_back(term_time.empty() ? 0.0 : term_time.back() + 1e-3);

  Json scene;
  scene["time"] = columns.add(time, 1e-3);
  scene["joints"] = Json::array();
  for (std::size_t a = 0; a < j; ++a) scene["joints"].push_back(columns.add(q[a], 1e-5));
  scene["tip"] = points_json(columns, tip, 1e-5);
  scene["pen_axis"] = points_json(columns, pen_axis, 1e-4);
  scene["force"] = points_json(columns, force, 5e-3);
  scene["normal"] = points_json(columns, normal, 1e-3);
  if (!canvas.empty()) {
    scene["canvas"] = Json::array();
    for (const std::vector<double>& values : canvas)
      scene["canvas"].push_back(columns.add(values, 1e-5));
  }
  scene["mode"] = columns.add(mode, 1.0);
  scene["stroke"] = columns.add(stroke, 1.0);
  (*out)["scene"] = std::move(scene);

  Json plots;
  plots["time"] = columns.add(joint_time, 1e-3);
  plots["rows_per_point"] = static_cast<double>(n) / static_cast<double>(joints.bins());
  plots["series"] = Json::array();
  for (std::size_t a = 0; a < j; ++a) {
    const std::string number = std::to_string(a);
    plots["series"].push_back(
        series_json("position_" + number, "position", "rad", joints.json(columns, 3 * a, 1e-4)));
    plots["series"].push_back(
        series_json("velocity_" + number, "speed", "rad/s", joints.json(columns, 3 * a + 1, 2e-4)));
    plots["series"].push_back(
        series_json("torque_" + number, "torque", "Nm", joints.json(columns, 3 * a + 2, 1e-2)));
  }
  plots["series"].push_back(series_json("surface_distance", "distance to the estimated surface",
                                        "mm", joints.json(columns, 3 * j, 1e-3)));
  if (canvas_plots) canvas_plots->write(columns, &plots["series"]);
  (*out)["joint_plots"] = std::move(plots);

  Json torque_plots;
  torque_plots["time"] = columns.add(term_time, 1e-3);
  torque_plots["rows_per_point"] = static_cast<double>(n) / static_cast<double>(torques.bins());
  torque_plots["terms"] = terms;
  torque_plots["series"] = Json::array();
  for (std::size_t t = 0; t < terms.size(); ++t)
    for (std::size_t a = 0; a < j; ++a)
      torque_plots["series"].push_back(series_json(terms[t] + "_" + std::to_string(a), terms[t],
                                                   "Nm", torques.json(columns, t * j + a, 1e-2)));
  (*out)["torque_plots"] = std::move(torque_plots);
  (*out)["rows_read"] = read;
}

// Steps by their wall time: equal bins up to the 99.9th percentile; the last has all slower ones.
Json step_times(const RunData& run) {
  std::vector<double> micros;
  for (const double s : run.step_time)
    if (std::isfinite(s)) micros.push_back(1e6 * s);
  if (micros.empty()) return nullptr;
  constexpr int kBins = 80;
  const double low = *std::min_element(micros.begin(), micros.end()),
               high = std::max(percentile(micros, 0.999), low + 1e-3);
  std::vector<double> edges;
  std::vector<long> counts(kBins, 0);
  for (int k = 0; k <= kBins; ++k) edges.push_back(low + (high - low) * k / kBins);
  for (const double m : micros)
    ++counts[std::min(kBins - 1, static_cast<int>((m - low) / (high - low) * kBins))];
  return {{"edges", edges}, {"counts", counts}};
}

}  // namespace

PagePayload make_payload(const PageRun& page, const RunData& run, const InkMatch& drawn,
                         const Metrics& metrics, const PageContext& context) {
  const auto step = [&context] {
    if (context.check) context.check();
  };
  PackedColumns columns;
  Json out = begun_page(
      columns, "run", page.title, run, context,
      context.canvas ? *context.canvas : canvas_mesh(run.canvas_vertices, run.canvas_triangles));
  if (!page.name.empty()) out["name"] = page.name;
  step();
  out["definitions"] = Json::array();
  for (const MetricDefinition& d : metric_definitions())
    out["definitions"].push_back({{"name", d.name}, {"unit", d.unit}, {"meaning", d.meaning}});
  out["metrics"] = metrics_json(metrics);
  out["limits"] = Json::parse(page.limits);
  out["scenario"] = text_of_file(page.scenario_file);
  const std::string strokes = text_of_file(page.strokes_file);
  // A run that was killed leaves neither wall times nor strokes.json. (One that went on after a
  // kill has no wall times either.)
  out["closed"] = std::isfinite(run.wall.loop) || !strokes.empty();
  out["strokes"] = Json::parse(strokes.empty() ? "{}" : strokes, nullptr, false);
  if (out["strokes"].is_discarded()) out["strokes"] = Json::object();
  out["spans"] = Json::array();
  for (const StrokeSpan& span : drawn.spans)
    out["spans"].push_back({span.stroke, run.time[span.begin], run.time[span.end - 1]});

  out["target"] = target_json(columns, run, drawn);
  step();
  const double duration = run.time.empty() ? 0.0 : run.time.back() - run.time.front();
  out["duration"] = duration;
  out["ink"] = ink_json(columns, run, drawn, duration > kLong ? kCoarse : kFine);
  step();
  out["step_plots"] = step_plots(columns, run, drawn);
  out["step_times"] = step_times(run);
  step();
  const ReplayLog log(page.log);
  add_rows(columns, log, run, context, &out);
  out["complete"] = out["rows_read"] == log.rows() && !log.cut_short();
  out["pictures"] =
      pictures_json(columns, page.pictures ? page.pictures() : std::vector<PagePicture>());
  // Text that others wrote need not be UTF-8.
  return {out.dump(-1, ' ', false, Json::error_handler_t::replace), columns.bytes()};
}

}  // namespace impedraw
