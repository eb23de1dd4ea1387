#include "impedraw/run/draw_into.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <future>
#include <optional>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/exit_code.h"
#include "impedraw/common/input_file.h"
#include "impedraw/experiment/page_of_plan.h"
#include "impedraw/experiment/plan_summary.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/log/run_rows.h"
#include "impedraw/run/incident.h"
#include "impedraw/run/log_row.h"
#include "impedraw/run/results.h"
#include "impedraw/run/run_folder.h"
#include "impedraw/run/tool_judge.h"
#include "impedraw/terminal/clock.h"
#include "impedraw/terminal/go_ahead.h"
#include "impedraw/terminal/progress.h"
#include "impedraw/terminal/say.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;

nlohmann::ordered_json parts_json(const Experiment& e, const std::vector<StrokePart>& parts) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const StrokePart& part : parts) {
    const StrokePlace from =
        place_on(e.plan.strokes[static_cast<std::size_t>(part.stroke)], part.from);
    list.push_back({{"stroke", part.stroke},
                    {"from_mm", 1e3 * part.from},
                    {"to_mm", 1e3 * part.to},
                    {"page_mm", {from.page.x(), from.page.y()}}});
  }
  return list;
}

// strokes.json: what was promised, what was not and why, what was drawn twice, and what has no ink.
void write_strokes(const fs::path& folder, const Experiment& e, const RunOutcome& outcome) {
  nlohmann::ordered_json json = plan_json(e);
  // Lines of the parts that were left out, for the page: x y z of point after point.
  const std::vector<PlanLine> lines = lines_of_findings(e, e.surface());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::vector<double> line;
    for (const Eigen::Vector3d& p_P : lines[i].points)
      for (const double x : Eigen::Vector3d(e.artwork.X_WP * p_P))
        line.push_back(1e-4 * std::round(1e4 * x));
    json["not_drawable"][i]["line_m"] = line;
  }
  json["drawn_again"] = parts_json(e, outcome.drawn_again);
  json["lacking"] = parts_json(e, outcome.lacking);
  for (std::size_t i = 0; i < outcome.lacking.size(); ++i)
    json["lacking"][i]["reason"] = overlaps(outcome.lacking[i], outcome.walls) ? "wall" : "no_ink";
  json["damped"] = outcome.damped;
  if (e.scenario.perception.frames.enabled) {
    std::vector<StrokePart> unreached;
    for (const UnreachedPart& u : outcome.unreached) unreached.push_back(u.part);
    json["unreached"] = parts_json(e, unreached);
    for (std::size_t i = 0; i < unreached.size(); ++i)
      json["unreached"][i]["text"] = outcome.unreached[i].text;
  }
  if (e.scenario.perception.frames.enabled || !outcome.remarks.empty())
    json["remarks"] = outcome.remarks;
  write_whole(folder / "strokes.json", json.dump(2) + "\n");
}

// pen.json: the pen that the arm holds, for a run that goes on there.
constexpr const char* kPenFile = "pen.json";

void write_pen(const fs::path& file, const HeldPen& pen) {
  nlohmann::ordered_json json = {
      {"number", pen.number}, {"longer_m", pen.longer}, {"radius_m", pen.radius}};
  if (pen.spot) json["spot_m"] = *pen.spot;
  write_whole(file, json.dump(2) + "\n");
}

HeldPen read_pen(const fs::path& file, std::size_t pens) try {
  const auto json = nlohmann::json::parse(InputFile(file).read(4096));
  HeldPen pen{json.at("number"), json.at("longer_m"), json.at("radius_m"), {}};
  if (json.contains("spot_m")) pen.spot = json["spot_m"].get<double>();
  if (pen.number < -1 || pen.number >= static_cast<int>(pens))
    throw InputError(
        fmt::format("{}: names a pen {}, of {} in `pens`", file.string(), pen.number, pens));
  return pen;
} catch (const nlohmann::json::exception& error) {
  throw InputError(fmt::format("{}: is damaged: {}", file.string(), error.what()));
}

double total_mm(const std::vector<StrokePart>& parts) {
  double sum = 0.0;
  for (const StrokePart& part : parts) sum += 1e3 * part.length();
  return sum;
}

// The place where the run in the folder left off; none if nothing has been drawn yet, which is
// said.
std::optional<Resumption> resumption_in(const fs::path& folder, const Experiment& experiment) {
  const fs::path log = folder / "run.h5";
  if (fs::exists(log)) {
    recover_log(log);
    std::optional<Resumption> resumption = read_resumption(experiment, log);
    if (resumption && fs::exists(folder / kPenFile)) {
      resumption->pen = read_pen(folder / kPenFile, experiment.scenario.pens.size());
      const HeldPen& pen = *resumption->pen;
      say(stderr, "note: the arm holds the pen of {}{}\n",
          pen.number < 0
              ? "`pen`"
              : fmt::format("layer '{}'",
                            experiment.scenario.pens[static_cast<std::size_t>(pen.number)].layer),
          pen.longer != 0.0 ? fmt::format(", {:.2f} mm beyond that of arm.urdf", 1e3 * pen.longer)
                            : "");
    }
    if (resumption) return resumption;
  }
  say(stderr, "note: nothing has been drawn in {} yet; the run starts from the beginning\n",
      folder.string());
  return std::nullopt;
}

// Room for what is left of the plan, and for the log of an earlier run, which is copied.
void require_room(const fs::path& folder, const Experiment& experiment,
                  const std::optional<Resumption>& resumption) {
  std::error_code error;
  const double earlier =
      resumption ? static_cast<double>(fs::file_size(folder / "run.h5", error)) : 0.0;
  const double seconds =
      std::max(0.0, experiment.plan.path.duration() - (resumption ? resumption->time : 0.0));
  require_space(folder, earlier + log_bytes(make_header(experiment), seconds), seconds);
}

// An arm that stopped by itself, and can recover, goes on where it stopped: as --resume does, but
// from where the arm now rests.
void draw_on_after_reflexes(const fs::path& folder, const Experiment& experiment, Driver& driver,
                            RunHooks hooks, RunOutcome* outcome) {
  hooks.begun = {};  // the folder's files are those of this run
  for (int i = 0; i < experiment.scenario.arm.recoveries; ++i) {
    if (outcome->end != RunEnd::stopped || driver.fault().empty()) return;
    const std::string cause = driver.fault();
    write_incident(folder, experiment.scenario, *outcome);
    const auto stopped = Clock::now();
    JointVector q;
    if (!driver.recover(&q)) return;
    std::optional<Resumption> rest = resumption_in(folder, experiment);
    if (!rest) rest.emplace();
    rest->q = q;
    say(stderr, "note: {}; the arm recovered within {:.2f} s, and the drawing goes on\n", cause,
        seconds_since(stopped));
    const RunOutcome before = *outcome;
    *outcome = run(experiment, driver, folder / "run.h5", 0.0, hooks, &*rest);
    outcome->wall.start_up = before.wall.start_up;
    outcome->wall.loop += before.wall.loop;
    for (const auto& [name, seconds] : before.met) outcome->met[name] += seconds;
    outcome->damped.insert(outcome->damped.begin(), before.damped.begin(), before.damped.end());
    if (before.slow_velocity && !(outcome->slow_velocity && outcome->slow_velocity->bandwidth <
                                                                before.slow_velocity->bandwidth))
      outcome->slow_velocity = before.slow_velocity;
  }
}

}  // namespace

std::function<void()> give_up_on(const Interrupt& interrupt, const fs::path& folder) {
  return [&interrupt, text = folder.string()] {
    if (interrupt.requested())
      throw Interrupted(
          fmt::format("interrupted while the results were made; the drawing is kept, and "
                      "./impedraw report {} finishes them",
                      text),
          interrupt.exit_code());
  };
}

Drawing draw_into(const fs::path& folder, const Experiment& experiment,
                  const DriverMaker& make_driver, double start_up, bool resume,
                  const RunHooks& watch, const FolderLock* held) {
  make_folder(folder);
  std::optional<FolderLock> lock;
  if (!held) lock.emplace(folder);
  require_own_log(folder);
  std::optional<Resumption> resumption;
  if (resume) resumption = resumption_in(folder, experiment);
  require_room(folder, experiment, resumption);
  const std::unique_ptr<ToolJudge> judge = tool_judge(experiment);
  if (judge && resumption)
    visit_rows(folder / "run.h5", [&judge](const LogRow& row) { judge->add(row); });
  Drawing drawing;
  const bool simulated = experiment.scenario.arm.driver == ArmDriver::sim;
  // On the second core while a simulated arm draws. The loop of a real one has both for itself.
  std::future<Backdrop> backdrop =
      std::async(simulated ? std::launch::async : std::launch::deferred, [&] {
        return backdrop_of(experiment.scenario, experiment.artwork, folder,
                           &experiment.yardstick.canvas);
      });
  {
    Interrupt interrupt;
    ProgressLine line;
    RunHooks hooks;
    hooks.row = watch.row;
    if (judge)
      hooks.row = [&](const LogRow& row) {
        judge->add(row);
        if (watch.row) watch.row(row);
      };
    hooks.emergency = [&] {
      return interrupt.emergency() || (watch.emergency && watch.emergency());
    };
    GoAhead go_ahead;
    // True while a person was asked, and has answered neither here nor on the live page.
    const auto awaited = [&] {
      if (!go_ahead.asked()) return false;
      if (watch.paused && !watch.paused()) go_ahead.withdraw();
      if (go_ahead.given() && watch.go_on) watch.go_on();
      return go_ahead.asked();
    };
    hooks.held = [&](double time) {
      if (interrupt.requested() || interrupt.emergency()) return false;
      if (!awaited()) return watch.held && watch.held(time);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      return true;
    };
    hooks.paused = [&] {
      return !interrupt.requested() && (awaited() || (watch.paused && watch.paused()));
    };
    hooks.pause = [&](const std::string& asks) {
      line.wipe();
      if (watch.pause) watch.pause(asks);
      if (simulated && !watch.pause && !go_ahead.terminal())
        say(stderr,
            "note: {}: nobody is at the terminal, and the simulated run goes on by itself\n", asks);
      else
        go_ahead.ask(asks);
    };
    hooks.holds_pen = [&](const HeldPen& pen) { write_pen(folder / kPenFile, pen); };
    // An arm that cannot be started leaves the results of an earlier run.
    hooks.begun = [&] {
      for (const char* stale :
           {"metrics.json", "report.html", "ink_top.svg", "ink_top.png", "ink_page.svg",
            "ink_page.png", "strokes.json", "incident.html", kPenFile, kCoverFile, kGrooveFile,
            kJetFile, kBladeFile, "cover.svg", "cover.png"})
        if (is_own_file(folder / stale)) fs::remove(folder / stale);
      if (!resumption) write_inputs(folder, experiment.scenario, experiment.inputs);
      if (watch.begun) watch.begun();
    };
    hooks.interrupted = [&] {
      return interrupt.requested() || (watch.interrupted && watch.interrupted());
    };
    hooks.progress = [&, first_time = resumption ? resumption->time : 0.0](const RunProgress& p) {
      if (watch.progress) watch.progress(p);
      line.update({p.time, p.stroke, p.strokes, p.share, p.drawn, p.length, p.again, first_time,
                   p.waits_for, p.waited});
    };
    const Resumption* const resumed = resumption ? &*resumption : nullptr;
    const auto driver = make_driver(resumed ? resumed->q : experiment.belief.start_q, resumed);
    drawing.outcome = run(experiment, *driver, folder / "run.h5", start_up, hooks, resumed);
    draw_on_after_reflexes(folder, experiment, *driver, hooks, &drawing.outcome);
    drawing.signal_code = interrupt.requested() ? interrupt.exit_code() : 128 + SIGINT;
  }
  const Interrupt interrupt;
  const auto check = give_up_on(interrupt, folder);
  if (drawing.outcome.end == RunEnd::stopped)
    write_incident(folder, experiment.scenario, drawing.outcome);
  if (!drawing.outcome.canvas_open.empty())
    say(stderr,
        "note: the canvas's shape does not show whether it {}; it is taken not to; "
        "perception.fiducials would tell\n",
        drawing.outcome.canvas_open);
  if (!drawing.outcome.frames.empty()) say(stderr, "note: {}\n", drawing.outcome.frames);
  for (const std::string& cause : drawing.outcome.damped)
    say(stderr, "note: {}; the drawing went on beyond that place\n", cause);
  for (const std::string& remark : drawing.outcome.remarks) say(stderr, "note: {}\n", remark);
  if (experiment.scenario.drawing.skip_unreachable)
    for (const UnreachedPart& u : drawing.outcome.unreached)
      say(stderr, "note: not drawn: {}\n", u.text);
  if (const double lag = drawing.outcome.stamp_lag; lag != 0.0)
    say(stderr,
        "note: frames' time stamps are {:.1f} ms later than perception.frames.stamp_error says, as "
        "the pen on the canvas showed; {:.5f} says so from the beginning\n",
        1e3 * lag, lag + experiment.scenario.perception.frames.stamp_error);
  if (!drawing.outcome.not_real_time.empty())
    say(stderr, "note: arm.real_time: {}\n", drawing.outcome.not_real_time);
  write_strokes(folder, experiment, drawing.outcome);
  if (judge) write_whole(folder / judge->file(), judge->results().dump(2) + "\n");
  if (watch.ended) watch.ended();
  drawing.metrics = write_results(folder, experiment.scenario, experiment.artwork, backdrop.get(),
                                  check, experiment.yardstick.surface.get());
  return drawing;
}

void print_notes(const PlannedDrawing& drawing) {
  constexpr std::size_t kMost = 20;
  const std::vector<std::string> notes = notes_of(drawing);
  for (std::size_t i = 0; i < notes.size() && i < kMost; ++i) say(stderr, "note: {}\n", notes[i]);
  if (notes.size() > kMost)
    say(stderr, "note: and {} more, in strokes.json\n", notes.size() - kMost);
}

namespace {

std::string cutoff_line(const SolverCutoffs& cutoffs) {
  if (cutoffs.tip == 0 && cutoffs.joints == 0) return {};
  return fmt::format(
      "solver  cut off before its tolerance: {} steps of the tip contact, {} of joints and tip\n",
      cutoffs.tip, cutoffs.joints);
}

}  // namespace

std::string met_line(const RunOutcome& outcome) {
  std::string text;
  for (const auto& [name, seconds] : outcome.met)
    text += fmt::format("{}{} {:.3g} s", text.empty() ? "status  " : ", ", name, seconds);
  return (text.empty() ? text : text + "\n") + cutoff_line(outcome.cutoffs);
}

std::string velocity_line(const Experiment& e, const RunOutcome& outcome) {
  if (!outcome.slow_velocity || !e.control.joint_estimator) return {};
  const SlowVelocity& slow = *outcome.slow_velocity;
  const JointStateEstimatorSettings& estimator = *e.control.joint_estimator;
  return fmt::format(
      "joints  velocity was estimated with a bandwidth of {:.0f} rad/s, not {:.0f}: the readings "
      "of {} have noise of {:.2g} rad{}\n",
      slow.bandwidth, estimator.bandwidth, e.belief.arm.joint_names()[slow.joint], slow.noise,
      slow.bandwidth > estimator.least_bandwidth ? ""
      : estimator.least_bandwidth > e.scenario.control.joint_sensing.least_bandwidth
          ? "; the stability checks allow no less"
          : ", which is the least");
}

std::string ink_lines(const Experiment& e, const RunOutcome& outcome) {
  if (outcome.drawn_again.empty() && outcome.lacking.empty()) return {};
  const auto counted = [](std::size_t n) { return fmt::format("{} part{}", n, n == 1 ? "" : "s"); };
  std::string text;
  if (!outcome.drawn_again.empty())
    text = fmt::format("ink     {}, {:.1f} mm, had none at first and {} drawn again; {}\n",
                       counted(outcome.drawn_again.size()), total_mm(outcome.drawn_again),
                       outcome.drawn_again.size() == 1 ? "was" : "were",
                       outcome.end != RunEnd::finished ? "the run ended before all of it had ink"
                       : outcome.lacking.empty()
                           ? "all of it has ink now"
                           : fmt::format("{} still lack it:", counted(outcome.lacking.size())));
  else
    text = fmt::format("ink     {}, {:.1f} mm, has none:\n", counted(outcome.lacking.size()),
                       total_mm(outcome.lacking));
  for (const StrokePart& part : outcome.lacking) {
    const StrokePlace from =
        place_on(e.plan.strokes[static_cast<std::size_t>(part.stroke)], part.from);
    text +=
        fmt::format("        stroke {}, {:.1f} to {:.1f} mm of it, from page ({:.1f}, {:.1f}) mm\n",
                    part.stroke, 1e3 * part.from, 1e3 * part.to, from.page.x(), from.page.y());
  }
  return text;
}

int exit_code(const Drawing& drawing) {
  const Ending& ending = drawing.metrics.ending;
  switch (ending.end) {
    case RunEnd::finished:
      return kFinished;
    case RunEnd::nothing_drawn:
    case RunEnd::far_off:
      say(stderr, "impedraw: {}\n", told(ending));
      return kStopped;
    default:
      break;
  }
  const bool by_person = ending.end == RunEnd::interrupted;
  say(stderr, "impedraw: {}; the log is kept up to there{}\n", ending.cause,
      by_person ? "; --resume continues from there" : "");
  return by_person ? drawing.signal_code : kStopped;
}

}  // namespace impedraw
