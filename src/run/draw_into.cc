#include "impedraw/run/draw_into.h"

#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/common/exit_code.h"
#include "impedraw/experiment/plan_summary.h"
#include "impedraw/run/results.h"
#include "impedraw/run/run_folder.h"
#include "impedraw/settings/yaml_write.h"
#include "impedraw/terminal/interrupt.h"
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
  json["drawn_again"] = parts_json(e, outcome.drawn_again);
  json["lacking"] = parts_json(e, outcome.lacking);
  write_file(folder / "strokes.json", json.dump(2) + "\n");
}

double total_mm(const std::vector<StrokePart>& parts) {
  double sum = 0.0;
  for (const StrokePart& part : parts) sum += 1e3 * part.length();
  return sum;
}

}  // namespace

Drawing draw_into(const fs::path& folder, Experiment& experiment, double start_up, bool resume) {
  make_folder(folder);
  std::optional<Resumption> resumption;
  if (resume) resumption = read_resumption(experiment, folder / "run.h5");
  for (const char* stale : {"metrics.json", "report.html", "ink_top.svg", "ink_top.png",
                            "ink_page.svg", "ink_page.png", "strokes.json"})
    fs::remove(folder / stale);
  if (!resume) fs::remove(folder / "run.h5");

  Drawing drawing;
  {
    Interrupt interrupt;
    ProgressLine line;
    RunHooks hooks;
    hooks.interrupted = [&] { return interrupt.requested(); };
    hooks.progress = [&](const RunProgress& p) {
      line.update({p.time, p.stroke, p.strokes, p.share, p.drawn, p.length, p.again});
    };
    try {
      write_file(folder / "scenario.yaml", settings_yaml(experiment.scenario));
      drawing.outcome =
          run(experiment, folder / "run.h5", start_up, hooks, resumption ? &*resumption : nullptr);
    } catch (...) {
      // Without a log the folder holds no run and would be refused to the next one.
      if (!fs::exists(folder / "run.h5")) fs::remove(folder / "scenario.yaml");
      throw;
    }
  }
  write_strokes(folder, experiment, drawing.outcome);
  drawing.metrics = write_results(folder, experiment.scenario, experiment.artwork);
  return drawing;
}

namespace {

PrepareProgress shown_on(ProgressLine& line) {
  return [&line](const char* what, double share) { line.update(what, share); };
}

}  // namespace

Experiment prepare_visibly(const Scenario& scenario, const Places& places) {
  ProgressLine line;
  return prepare(scenario, places, Unreachable::refuse, shown_on(line));
}

PlannedDrawing prepare_plan_visibly(const Scenario& scenario, const Places& places) {
  ProgressLine line;
  return prepare_plan(scenario, places, Unreachable::tell, shown_on(line));
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

std::string ink_lines(const Experiment& e, const RunOutcome& outcome) {
  if (outcome.drawn_again.empty() && outcome.lacking.empty()) return {};
  const auto counted = [](std::size_t n) { return fmt::format("{} part{}", n, n == 1 ? "" : "s"); };
  std::string text;
  if (!outcome.drawn_again.empty())
    text = fmt::format("ink     {}, {:.1f} mm, got none at first and {} drawn again; {}\n",
                       counted(outcome.drawn_again.size()), total_mm(outcome.drawn_again),
                       outcome.drawn_again.size() == 1 ? "was" : "were",
                       outcome.lacking.empty()
                           ? "all of it has ink now"
                           : fmt::format("{} still lack it:", counted(outcome.lacking.size())));
  else
    text = fmt::format("ink     {}, {:.1f} mm, got none:\n", counted(outcome.lacking.size()),
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

int exit_code(const RunOutcome& outcome) {
  if (outcome.end == RunEnd::finished) return kFinished;
  say(stderr, "impedraw: {}; the log is kept up to there{}\n", outcome.cause,
      outcome.end == RunEnd::interrupted ? ", --resume goes on from it" : "");
  return outcome.end == RunEnd::stopped ? kStopped : kInterrupted;
}

}  // namespace impedraw
