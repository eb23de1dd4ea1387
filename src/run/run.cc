#include "impedraw/run/run.h"

#include <cmath>
#include <limits>
#include <memory>

#include <fmt/format.h>

#include "impedraw/log/resume_log.h"
#include "impedraw/log/run_rows.h"
#include "impedraw/run/drawings.h"
#include "impedraw/run/driven_arm.h"
#include "impedraw/run/executor.h"
#include "impedraw/run/loop_sources.h"
#include "impedraw/run/pen_changes.h"
#include "impedraw/terminal/clock.h"

namespace impedraw {
namespace {

// A resumed drawing begins with what the earlier run left, from its last posture. Plans before the
// arm is driven.
std::unique_ptr<DrawingTask> drawing_of(const Experiment& e, const Driver& driver,
                                        const Resumption* resumption, const HeldPen& pen) {
  if (follows_canvas(e, driver))
    return std::make_unique<MovingDrawing>(e, resumption ? resumption->time : 0.0);
  std::vector<StrokePart> left;
  if (resumption) left = remaining(e, resumption->ink);
  if (needs_pens(e)) {
    const auto make = [&e](std::vector<StrokePart> parts, const Eigen::Vector3d& p,
                           const Eigen::Vector3d& n, double rest) -> std::unique_ptr<DrawingTask> {
      if (e.belief.by_touch()) return std::make_unique<TouchedDrawing>(e, strokes_of(e, parts));
      return std::make_unique<StandingDrawing>(e, path_without_misses(e, &parts, p, n, rest));
    };
    if (!resumption) left = rest_of(e.plan.strokes, {});
    const JointVector& q = resumption ? resumption->q : e.belief.start_q;
    return std::make_unique<PenChanges>(e, left, pen, ArmModel(e.belief.arm).tip_pose(q), make);
  }
  if (e.belief.by_touch())
    return std::make_unique<TouchedDrawing>(e, resumption ? strokes_of(e, left) : e.plan.strokes);
  if (!resumption) return std::make_unique<StandingDrawing>(e, e.plan.path);
  if (resumption->touches && has_sensor(e.control.source) && !left.empty())
    return std::make_unique<StandingDrawing>(e, std::move(left));
  const Pose X_WE = ArmModel(e.belief.arm).tip_pose(resumption->q);
  BlockedPlaces blocked;
  TipPath path = checked_path(e, &left, X_WE.p, -X_WE.R.col(2), e.plan.path_settings.start_hold,
                              resumption->q, &blocked);
  return std::make_unique<StandingDrawing>(e, std::move(path), std::move(blocked));
}

// The pen that is in at first: the one that draws first, or drew last.
HeldPen first_pen(const Experiment& e, const Resumption* resumption) {
  if (resumption && resumption->pen) return *resumption->pen;
  const bool drawn = resumption && !resumption->ink.parts().empty();
  return pen_of(e, pen_of_stroke(e, drawn ? resumption->ink.parts().back().stroke : 0));
}

// Length that lacks ink, by the reason for which it was given up [m].
std::map<std::string, double> given_up(const Experiment& e, const std::vector<StrokePart>& lacking,
                                       const RunOutcome& outcome) {
  std::vector<StrokePart> unreached;
  for (const UnreachedPart& u : outcome.unreached) unreached.push_back(u.part);
  std::map<std::string, double> lengths;
  if (e.scenario.drawing.dry_run) return lengths;
  for (const StrokePart& part : lacking)
    if (overlaps(part, outcome.walls))
      lengths["wall"] += part.length();
    else if (overlaps(part, unreached))
      lengths["out_of_reach"] += part.length();
  return lengths;
}

}  // namespace

bool writes(const Experiment& e, ContactMode mode, double normal_force, double push) {
  const ImpedanceSettings& control = e.control.impedance;
  const bool measured = control.wrench == WrenchFeedback::measured;
  // A pad's line is one of several on each place, and a second time adds all of its dose: that is
  // nearer to even where the first gave less than half. Somewhat more is done again, as places that
  // lack force may stay untreated. A cutter cuts what it touches.
  const double asked = push > 0.0 ? push : control.normal_force;
  const ToolKind tool = e.scenario.tool.kind;
  if (tool == ToolKind::nozzle) return true;
  const double least = tool == ToolKind::pad        ? 0.7 * asked
                       : tool == ToolKind::engraver ? 0.0
                                                    : InkWatch::least_force(asked);
  if (measured && !(normal_force >= least)) return false;
  // Blind, the law has no contact state. Without a wrench too, contact is unknown.
  return !e.belief.estimates_surface() || mode == ContactMode::contact;
}

RunOutcome run(const Experiment& e, Driver& driver, const std::filesystem::path& log_file,
               double start_up, const RunHooks& hooks, const Resumption* resumption) {
  if (!touches(e.scenario) && e.belief.by_touch())
    throw InputError(fmt::format(
        "{}: the surface is found by touch, so that nothing tells its height; valid is {}, or "
        "perception.enabled true",
        e.scenario.drawing.dry_run ? "drawing.dry_run" : "tool.kind is nozzle",
        e.scenario.drawing.dry_run ? "null" : "a tool that touches"));
  const auto before_log = Clock::now();
  const HeldPen pen = first_pen(e, resumption);
  const std::unique_ptr<DrawingTask> drawing = drawing_of(e, driver, resumption, pen);
  DrivenArm arm(e, driver, log_file, hooks, resumption);
  if (hooks.begun) hooks.begun();
  if (needs_pens(e) && !follows_canvas(e, driver)) arm.hold_pen(pen);
  Executor executor(e, arm, hooks);
  RunOutcome outcome;
  outcome.wall.start_up = start_up + seconds_since(before_log);

  const auto loop_start = Clock::now();
  while (executor.goes_on()) {
    const Situation now = executor.situation();
    const Move move = arm.while_held([&] { return drawing->next(now); });
    executor.carry_out(move);
    if (move.kind == Move::Kind::end) break;
  }

  static_cast<Ending&>(outcome) = executor.ending();
  static_cast<DrawingRecord&>(outcome) = drawing->record();
  static_cast<LoopRecord&>(outcome) = arm.finish();
  if (outcome.end == RunEnd::stopped && !outcome.silence.empty())
    outcome.cause += "; " + outcome.silence;
  outcome.damped = executor.damped();
  const std::vector<StrokePart> lacking = remaining(e, arm.ink());
  if (outcome.end == RunEnd::finished && !e.scenario.drawing.dry_run) outcome.lacking = lacking;
  outcome.given_up = given_up(e, lacking, outcome);
  if (outcome.end == RunEnd::stopped) outcome.last = arm.last_rows();
  outcome.simulated = arm.time();
  if (const GroundTruth* truth = driver.truth()) outcome.cutoffs = truth->cutoffs;
  outcome.first_time = resumption ? resumption->time : 0.0;
  outcome.wall.loop = seconds_since(loop_start);
  outcome.wall = arm.close_log(outcome.wall, outcome);
  return outcome;
}

// The place where an earlier run into the same log left off (run.h).

std::optional<Resumption> read_resumption(const Experiment& e,
                                          const std::filesystem::path& log_file) {
  const ResumeLog before = read_resume_log(log_file);
  if (before.rows.empty()) return std::nullopt;
  if (before.joint_position.size() != e.belief.arm.joints())
    throw InputError(fmt::format("{}: is of an arm with {} joints, this one has {}",
                                 log_file.string(), before.joint_position.size(),
                                 e.belief.arm.joints()));
  Resumption resumption;
  for (const ResumeRow& row : before.rows) {
    if (row.stroke >= static_cast<int>(e.plan.strokes.size()))
      throw InputError(fmt::format("{}: has a stroke {}, the drawing only {}", log_file.string(),
                                   row.stroke, e.plan.strokes.size()));
    // Blind, the log has no normal to project the force on. Assume that the pen wrote.
    const double force = !e.belief.estimates_surface() && std::isnan(row.f)
                             ? std::numeric_limits<double>::infinity()
                             : row.f;
    resumption.ink.add(row.stroke, row.stroke_along,
                       writes(e, static_cast<ContactMode>(row.mode), force, row.push));
  }
  ArmModel arm = e.belief.arm;
  const auto score = [&](const LogRow& row) {
    if (row.stroke < 0 || e.plan.strokes[static_cast<std::size_t>(row.stroke)].depth > 0.0 ||
        row.mode != static_cast<int>(ContactMode::contact) || !row.surface_normal.allFinite())
      return;
    resumption.scores.push_back({arm.tip_pose(row.measured_position).p, row.surface_normal,
                                 row.surface_normal.dot(row.wrench_measured.head<3>())});
  };
  if (e.control.cut) visit_rows(log_file, score);
  resumption.q = before.joint_position;
  resumption.touches = static_cast<ContactMode>(before.rows.back().mode) != ContactMode::free;
  resumption.X_WK = before.canvas_pose;
  resumption.time = before.rows.back().time + e.control.impedance.timing.dt;
  return resumption;
}

}  // namespace impedraw
