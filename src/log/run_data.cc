#include "impedraw/log/run_data.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "impedraw/log/log_checks.h"
#include "impedraw/log/log_file.h"
#include "impedraw/log/log_reader.h"
#include "impedraw/log/log_step.h"

namespace impedraw {
namespace {

RunConstants constants(const LogReader& log) {
  RunConstants c{log.header(), log.wall(), log.cut_short()};
  c.canvas_vertices = log.points("/canvas/vertices");
  c.canvas_triangles = log.triples("/canvas/triangles");
  c.cloud_points = log.points("/cloud/points");
  if (log.has("/cloud/colour")) c.cloud_colour = log.integers("/cloud/colour");
  if (!c.cloud_colour.empty() && c.cloud_colour.size() != c.cloud_points.size())
    log.fail("/cloud/points and /cloud/colour differ in length");
  c.target_points = log.points("/target/points");
  c.target_stroke = log.integers("/target/stroke");
  if (c.target_stroke.size() != c.target_points.size())
    log.fail("/target/points and /target/stroke differ in length");
  require_valid(log, c);
  return c;
}

void reserve(RunData* run, std::size_t n) {
  for (auto* column : {&run->time, &run->f, &run->tilt, &run->normal_error, &run->tracking_error,
                       &run->push, &run->step_time})
    column->reserve(n);
  run->contact_point.reserve(n);
  run->torque_share.reserve(n);
  run->time_scale.reserve(n);
  run->stroke_along.reserve(n);
  run->stroke.reserve(n);
  run->mode.reserve(n);
}

}  // namespace

void add_rows(const RunRows& rows, RunData* run) {
  const std::size_t n = rows.rows();
  if (n == 0) return;
  const auto append = [](const auto& from, auto& to) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(rows.time, run->time);
  append(rows.contact_point, run->contact_point);
  append(rows.push, run->push);
  append(rows.step_time, run->step_time);
  append(rows.time_scale, run->time_scale);
  append(rows.stroke_along, run->stroke_along);
  append(rows.stroke, run->stroke);
  const bool terms = rows.torque_before_limits.rows() == static_cast<Eigen::Index>(n);
  if (terms) run->clipped = run->clipped.value_or(0);
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const Eigen::Vector3d& normal = rows.contact_normal[i];
    const int stroke = rows.stroke[i];
    const double f = normal_force(rows.contact_force[i], normal);
    run->f.push_back(f);
    run->tilt.push_back(tilt_angle(rows.tip_orientation[i], normal, stroke, f));
    run->normal_error.push_back(
        normal_error_angle(rows.surface_normal[i], rows.surface_distance[i], normal, stroke, f));
    run->tracking_error.push_back(
        tracking_distance(rows.tip_position[i], rows.desired_position[i], normal, stroke, f));
    run->mode.push_back(static_cast<std::int8_t>(rows.mode[i]));
    const JointReference torque = rows.joint_torque.row(k).transpose();
    run->torque_share.push_back(static_cast<float>(torque_share(torque, run->torque_limit)));
    run->joint_margin = std::min(
        run->joint_margin,
        joint_margin(rows.joint_position.row(k).transpose(), run->joint_lower, run->joint_upper));
    run->joint_speed_share = std::fmax(
        run->joint_speed_share,
        joint_speed_share(rows.joint_velocity.row(k).transpose(), run->joint_speed_limit));
    if (terms && is_clipped(rows.torque_before_limits.row(k).transpose(), torque)) ++*run->clipped;
  }
}

namespace {

// `terms`: the log has torque terms.
void add_step(const LogStep& step, bool terms, RunData* run) {
  run->time.push_back(step.time);
  run->f.push_back(step.force);
  run->contact_point.push_back(step.contact_point);
  run->tilt.push_back(step.tilt);
  run->normal_error.push_back(step.normal_error);
  run->tracking_error.push_back(step.tracking_error);
  run->push.push_back(step.push);
  run->step_time.push_back(step.step_time);
  run->torque_share.push_back(static_cast<float>(step.torque_share));
  run->time_scale.push_back(static_cast<float>(step.time_scale));
  run->stroke_along.push_back(static_cast<float>(step.stroke_along));
  run->stroke.push_back(step.stroke);
  run->mode.push_back(static_cast<std::int8_t>(step.mode));
  run->joint_margin = std::min(run->joint_margin, step.joint_margin);
  run->joint_speed_share = std::fmax(run->joint_speed_share, step.joint_speed_share);
  if (terms) run->clipped = run->clipped.value_or(0) + static_cast<std::size_t>(step.clipped > 0);
}

// Adds steps [begin, begin + n) of a reduced log; false if they exist but cannot be read.
bool add_steps(const LogReader& log, std::size_t begin, std::size_t n, StepChecks* checks,
               RunData* run) {
  // Column by column, as they are stored in the file.
  std::vector<LogStep> steps(n);
  std::vector<std::byte> values;
  for (std::size_t c = 0; c < step_columns().size(); ++c) {
    const LogColumn& column = step_columns()[c];
    if (!log.has(column.name)) continue;  // an older log: its default
    values.resize(n * column.row_bytes());
    if (!log.read(column, begin, n, values.data())) return false;
    for (std::size_t i = 0; i < n; ++i) {
      std::size_t k = 0;
      visit_step(steps[i], "", [&](const char*, auto& value, const auto&...) {
        put_value(value, [&](void* to, int, std::size_t) {
          if (k++ == c) std::memcpy(to, values.data() + i * column.row_bytes(), column.row_bytes());
        });
      });
    }
  }
  std::vector<int> modes(n);
  std::transform(steps.begin(), steps.end(), modes.begin(), [](auto& step) { return step.mode; });
  checks->modes(modes);
  for (const LogStep& step : steps) {
    add_step(step, !log.header().torque_terms.empty(), run);
  }
  return true;
}

}  // namespace

RunRecorder::RunRecorder(const RunLogHeader& header)
    : steps_(header), terms_(!header.torque_terms.empty()) {
  static_cast<RunDescription&>(run_) = header;
}

void RunRecorder::add(const LogRow& row) { add_step(steps_.measure(row), terms_, &run_); }

RunData RunRecorder::take(const WallTimes& wall) {
  run_.wall = wall;
  return std::move(run_);
}

RunData read_run(const std::filesystem::path& path) {
  const LogReader log(path);
  try {
    RunData run;
    static_cast<RunConstants&>(run) = constants(log);
    reserve(&run, log.steps());
    RunRows chunk;
    StepChecks checks(log);
    for (std::size_t begin = 0; begin < log.steps(); begin += LogFile::kChunkRows) {
      const std::size_t n = std::min(LogFile::kChunkRows, log.steps() - begin);
      if (log.rate() == LogRate::reduced) {
        if (!add_steps(log, begin, n, &checks, &run)) break;
      } else {
        // unreadable from here on
        if (!read_rows(log, begin, n, Columns::of_results, &chunk)) break;
        checks.modes(chunk.mode);
        add_rows(chunk, &run);
      }
      checks.times(std::span(run.time).last(n));
      checks.strokes(std::span(run.stroke).last(n));
      checks.contact_points(std::span(run.contact_point).last(n));
      checks.next(n);
    }
    return run;
  } catch (const h5::Error& e) {
    log.fail(e.what());
  } catch (const std::bad_alloc&) {
    log.fail(fmt::format("{} steps do not fit into memory", log.steps()));
  }
}

}  // namespace impedraw
