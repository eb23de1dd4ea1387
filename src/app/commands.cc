#include "app/commands.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include <fmt/format.h>

#include "app/calibrate_tool.h"
#include "app/experiment.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "app/results.h"
#include "app/run.h"
#include "app/settings_doc.h"
#include "app/wall_time.h"
#include "app/yaml_read.h"
#include "app/yaml_write.h"
#include "common/errors.h"
#include "drawing/artwork_file.h"
#include "report/report.h"

namespace impedraw {

namespace {

namespace fs = std::filesystem;

fs::path folder_for(const DrawOptions& options, const Scenario& scenario) {
  return options.out.empty() ? fs::path("runs") / scenario.name : options.out;
}

struct Drawing {
  RunOutcome outcome;
  nlohmann::ordered_json metrics;
};

void print_notes(const Experiment& experiment) {
  for (const std::string& note : experiment.notes) fmt::print(stderr, "note: {}\n", note);
}

// One run into `folder`, with its results. start_up: seconds it took to prepare.
Drawing draw_into(const fs::path& folder, Experiment& experiment, double start_up) {
  make_folder(folder);
  for (const char* stale : {"run.h5", "metrics.json", "report.html", "ink_top.svg", "ink_top.png", "ink_page.svg", "ink_page.png"})
    fs::remove(folder / stale);

  Drawing drawing;
  {
    Interrupt interrupt;
    ProgressLine line;
    RunHooks hooks;
    hooks.interrupted = [&] { return interrupt.requested(); };
    hooks.progress = [&](const RunProgress& p) { line.update({p.time, p.stroke, p.strokes, p.share}); };
    try {
      write_file(folder / "scenario.yaml", settings_yaml(experiment.scenario));
      drawing.outcome = run(experiment, folder / "run.h5", start_up, hooks);
    } catch (...) {
      // Without a log it is no run, and the next one would be refused the folder.
      if (!fs::exists(folder / "run.h5")) fs::remove(folder / "scenario.yaml");
      throw;
    }
  }
  drawing.metrics = write_results(folder, experiment.artwork.target, experiment.placement);
  return drawing;
}

// What the controller said of itself while it drew, where that was not all well.
std::string met_line(const RunOutcome& outcome) {
  std::string text;
  for (const auto& [name, seconds] : outcome.met) text += fmt::format("{}{} {:.3g} s", text.empty() ? "status  " : ", ", name, seconds);
  return text.empty() ? text : text + "\n";
}

int exit_code(const RunOutcome& outcome) {
  if (outcome.end == RunEnd::finished) return kFinished;
  fmt::print(stderr, "impedraw: {}; the log is kept up to there\n", outcome.cause);
  return outcome.end == RunEnd::stopped ? kStopped : kInterrupted;
}

}  // namespace

Scenario resolve(const DrawOptions& options, Places* given) {
  Scenario scenario;
  const fs::path file = options.scenario.empty() ? fs::path(IMPEDRAW_ROOT) / "scenarios/bowl-sine.yaml" : options.scenario;
  scenario.name = file.stem();
  // Artwork from the command line names the run, with the scenario in front where one was given.
  const auto name_after = [&](const std::string& artwork) {
    scenario.name = options.scenario.empty() ? artwork : scenario.name + "-" + artwork;
  };
  Places places = read_settings(scenario, file, options.assignments);
  if (!options.shape.empty()) {
    scenario.drawing.shape = options.shape;
    scenario.drawing.svg.clear();
    name_after(options.shape);
    places.put("drawing.shape", fmt::format("--shape {}", options.shape));
  }
  if (!options.svg.empty()) {
    scenario.drawing.svg = fs::absolute(options.svg);
    name_after(options.svg.stem().string());
    places.put("drawing.svg", fmt::format("--svg {}", options.svg.string()));
  }
  if (options.keep_order) scenario.drawing.keep_order = true;
  if (options.no_perception) {
    scenario.perception.enabled = false;
    scenario.name += "-blind";
  }
  if (scenario.drawing.svg.empty()) {
    const std::string& shape = scenario.drawing.shape;
    const std::vector<std::string> shapes = shape_names();
    if (std::find(shapes.begin(), shapes.end(), shape) == shapes.end())
      throw InputError(fmt::format("{}: drawing.shape {}", places.of("drawing.shape"), not_among(shape, shapes)));
  }
  // It names the run's folder.
  if (scenario.name.empty() || scenario.name.find('/') != std::string::npos || scenario.name.starts_with('.'))
    throw InputError(fmt::format("{}: name is '{}', but it names a folder: no '/' in it, no '.' in front, not empty",
                                 places.of("name"), shown(scenario.name)));
  if (given) *given = places;
  return scenario;
}

int draw(const DrawOptions& options) {
  const auto start = Clock::now();
  Places places;
  const Scenario scenario = resolve(options, &places);
  const fs::path folder = folder_for(options, scenario);
  require_run_folder(folder);
  Experiment experiment = prepare(scenario, places);
  print_notes(experiment);
  const Drawing drawing = draw_into(folder, experiment, seconds_since(start));
  fmt::print("{}: {:.2f} s simulated in {:.2f} s\n{}{}report  {}\n", scenario.name, drawing.outcome.simulated, drawing.outcome.wall.loop,
             metrics_table(drawing.metrics), met_line(drawing.outcome), fs::absolute(folder / "report.html").lexically_normal().string());
  return exit_code(drawing.outcome);
}

int compare(const DrawOptions& options) {
  Places places;
  Scenario seen = resolve(options, &places);
  seen.perception.enabled = true;
  Scenario blind = seen;
  blind.perception.enabled = false;
  blind.name += "-blind";
  const fs::path folder = options.out.empty() ? fs::path("runs") / (seen.name + "-compare") : options.out;
  require_comparison_folder(folder);

  // Both are prepared before either is drawn: what is wrong with the second must not leave the first behind.
  struct Side {
    std::string name;
    Experiment experiment;
    double start_up;
  };
  std::vector<Side> sides;
  for (const auto& [name, scenario] : {std::pair{"perception", &seen}, std::pair{"blind", &blind}}) {
    const auto start = Clock::now();
    Experiment experiment = prepare(*scenario, places);
    sides.push_back({name, std::move(experiment), seconds_since(start)});
  }
  int worst = kFinished;
  for (Side& side : sides) {
    const Drawing drawing = draw_into(folder / side.name, side.experiment, side.start_up);
    const int code = exit_code(drawing.outcome);
    if (code == kInterrupted) return code;
    worst = std::max(worst, code);
    fmt::print("{}\n{}", side.name, metrics_table(drawing.metrics));
  }
  write_comparison({"with perception", folder / "perception"}, {"without perception", folder / "blind"}, folder);
  fmt::print("comparison  {}\n", fs::absolute(folder / "compare.html").lexically_normal().string());
  return worst;
}

namespace {

// docs/settings.md, which is this program's own output.
std::string settings_page() {
  return "# Settings\n\n"
         "Every setting of a scenario, as `./impedraw settings --markdown` prints them. A YAML file names those that differ from the "
         "default "
         "(`control: {push: 3}`), the command line any one of them (`--set control.push=3`, `--set perception.cameras.0.width=320`). "
         "`extends: other.yaml` takes everything from another file first. Where a name has an N, a list of them is given, counted from "
         "0.\n\n" +
         settings_markdown<Scenario>();
}

}  // namespace

int calibrate_tool(const DrawOptions& options, int poses) {
  DrawOptions with_sensor = options;
  if (with_sensor.scenario.empty()) with_sensor.scenario = fs::path(IMPEDRAW_ROOT) / "scenarios/bowl-sine-realistic.yaml";
  Places places;
  const Scenario scenario = resolve(with_sensor, &places);
  if (!has_sensor(scenario.control.source))
    throw InputError(fmt::format("{}: control.wrench has no sensor to read; valid are sensor, realistic", places.of("control.wrench")));
  Experiment experiment = prepare(scenario, places);
  const ToolIdentification found = calibrate_tool(experiment, poses).found;
  fmt::print("{} poses\n"
             "  mass      {:.4f} ± {:.4f} kg\n"
             "  centre    ({:.4f}, {:.4f}, {:.4f}) ± ({:.4f}, {:.4f}, {:.4f}) m, in the sensor's frame\n"
             "  bias      ({:.3f}, {:.3f}, {:.3f}) N, ({:.4f}, {:.4f}, {:.4f}) Nm\n"
             "  residual  {:.4f} N, {:.5f} Nm RMS an axis\n\n"
             "As a setting of a scenario:\n"
             "control: {{sensing: {{tool: {{mass: {:.4f}, centre: [{:.4f}, {:.4f}, {:.4f}]}}}}}}\n",
             poses, found.mass, found.mass_error, found.p_SC.x(), found.p_SC.y(), found.p_SC.z(), found.p_SC_error.x(),
             found.p_SC_error.y(), found.p_SC_error.z(), found.bias_S[0], found.bias_S[1], found.bias_S[2], found.bias_S[3],
             found.bias_S[4], found.bias_S[5], found.residual_force, found.residual_torque, found.mass, found.p_SC.x(), found.p_SC.y(),
             found.p_SC.z());
  return kFinished;
}

int report(const fs::path& folder) {
  if (!fs::exists(folder / "run.h5")) throw InputError(fmt::format("{}: holds no run.h5; name the folder of a run", folder.string()));
  Scenario scenario;
  read_settings(scenario, folder / "scenario.yaml");
  const Artwork artwork = scenario.drawing.svg.empty() ? make_shape(scenario.drawing.shape).target : read_artwork(scenario.drawing.svg);
  fmt::print("{}report  {}\n", metrics_table(write_results(folder, artwork, place(artwork, scenario.drawing.placement))),
             fs::absolute(folder / "report.html").lexically_normal().string());
  return kFinished;
}

int print_settings(bool markdown) {
  fmt::print("{}", markdown ? settings_page() : settings_help<Scenario>());
  return kFinished;
}

}  // namespace impedraw
