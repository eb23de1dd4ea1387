#include "app/commands.h"

#include <chrono>
#include <cstdio>
#include <fstream>

#include <fmt/format.h>

#include "app/experiment.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "app/results.h"
#include "app/run.h"
#include "app/settings_doc.h"
#include "app/yaml_read.h"
#include "app/yaml_write.h"
#include "common/errors.h"
#include "drawing/svg.h"
#include "report/report.h"

namespace impedraw {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

fs::path folder_for(const DrawOptions& options, const Scenario& scenario) {
  return options.out.empty() ? fs::path("runs") / scenario.name : options.out;
}

struct Drawing {
  RunOutcome outcome;
  nlohmann::ordered_json metrics;
};

// One run into `folder`, with its results. `start`: when this run's start-up began.
Drawing draw_into(const fs::path& folder, const Scenario& scenario, Clock::time_point start) {
  require_run_folder(folder);
  Experiment experiment = prepare(scenario);
  const double start_up = std::chrono::duration<double>(Clock::now() - start).count();

  fs::create_directories(folder);
  for (const char* stale : {"metrics.json", "report.html", "ink_top.svg", "ink_top.png", "ink_page.svg", "ink_page.png"}) fs::remove(folder / stale);
  std::ofstream(folder / "scenario.yaml") << settings_yaml(experiment.scenario);

  Drawing drawing;
  {
    Interrupt interrupt;
    ProgressLine line;
    RunHooks hooks;
    hooks.interrupted = [&] { return interrupt.requested(); };
    hooks.progress = [&](const RunProgress& p) { line.update({p.time, p.stroke, p.strokes, p.share}); };
    drawing.outcome = run(experiment, folder / "run.h5", start_up, hooks);
  }
  drawing.metrics = write_results(folder, experiment.artwork.target, experiment.placement);
  return drawing;
}

int exit_code(const RunOutcome& outcome) {
  if (outcome.end == RunEnd::finished) return kFinished;
  fmt::print(stderr, "impedraw: {}; the log is kept up to there\n", outcome.cause);
  return outcome.end == RunEnd::stopped ? kStopped : kInterrupted;
}

}  // namespace

Scenario resolve(const DrawOptions& options) {
  Scenario scenario;
  const fs::path file = options.scenario.empty() ? fs::path(IMPEDRAW_ROOT) / "scenarios/bowl-sine.yaml" : options.scenario;
  scenario.name = file.stem();
  std::vector<std::string> assignments;
  if (!options.shape.empty()) assignments.push_back("drawing.shape=" + options.shape);
  assignments.insert(assignments.end(), options.assignments.begin(), options.assignments.end());
  read_settings(scenario, file, assignments);
  if (!options.shape.empty()) {
    scenario.drawing.svg.clear();
    scenario.name += "-" + options.shape;
  }
  if (!options.svg.empty()) {
    scenario.drawing.svg = fs::absolute(options.svg);
    scenario.name += "-" + options.svg.stem().string();
  }
  if (options.no_perception) {
    scenario.perception.enabled = false;
    scenario.name += "-blind";
  }
  return scenario;
}

int draw(const DrawOptions& options) {
  const auto start = Clock::now();
  const Scenario scenario = resolve(options);
  const fs::path folder = folder_for(options, scenario);
  const Drawing drawing = draw_into(folder, scenario, start);
  fmt::print("{}: {:.2f} s simulated in {:.2f} s\n{}report  {}\n", scenario.name, drawing.outcome.simulated, drawing.outcome.wall.loop,
             metrics_table(drawing.metrics), fs::absolute(folder / "report.html").lexically_normal().string());
  return exit_code(drawing.outcome);
}

int compare(const DrawOptions& options) {
  Scenario seen = resolve(options);
  seen.perception.enabled = true;
  Scenario blind = seen;
  blind.perception.enabled = false;
  blind.name += "-blind";
  const fs::path folder = options.out.empty() ? fs::path("runs") / (seen.name + "-compare") : options.out;
  for (const fs::path& f : {folder / "perception", folder / "blind"}) require_run_folder(f);
  for (const auto& [name, scenario] : {std::pair{"perception", seen}, std::pair{"blind", blind}}) {
    const Drawing drawing = draw_into(folder / name, scenario, Clock::now());
    if (const int code = exit_code(drawing.outcome); code == kInterrupted) return code;
    fmt::print("{}\n{}", name, metrics_table(drawing.metrics));
  }
  write_comparison({"with perception", folder / "perception"}, {"without perception", folder / "blind"}, folder);
  fmt::print("comparison  {}\n", fs::absolute(folder / "compare.html").lexically_normal().string());
  return kFinished;
}

int report(const fs::path& folder) {
  if (!fs::exists(folder / "run.h5")) throw InputError(fmt::format("{}: holds no run.h5; name the folder of a run", folder.string()));
  Scenario scenario;
  read_settings(scenario, folder / "scenario.yaml");
  const Artwork artwork = scenario.drawing.svg.empty() ? make_shape(scenario.drawing.shape).target : read_svg(scenario.drawing.svg);
  fmt::print("{}report  {}\n", metrics_table(write_results(folder, artwork, place(artwork, scenario.drawing.placement))),
             fs::absolute(folder / "report.html").lexically_normal().string());
  return kFinished;
}

int print_settings() {
  fmt::print("{}", settings_help<Scenario>());
  return kFinished;
}

}  // namespace impedraw
