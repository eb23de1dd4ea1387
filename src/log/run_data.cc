#include "impedraw/log/run_data.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "impedraw/log/log_checks.h"
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
    const bool terms = !log.header().torque_terms.empty();
    // A column that is unreadable from some step on ends there.
    visit_steps(log, [&](const LogStep& step) { add_step(step, terms, &run); });
    return run;
  } catch (const h5::Error& e) {
    log.fail(e.what());
  } catch (const std::bad_alloc&) {
    log.fail(fmt::format("{} steps do not fit into memory", log.steps()));
  }
}

}  // namespace impedraw
