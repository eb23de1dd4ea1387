#include "impedraw/app/commands.h"

#include <algorithm>
#include <cstdio>
#include <sstream>

#include <fmt/format.h>

#include "impedraw/experiment/page_context.h"
#include "impedraw/experiment/place_auto.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/report/report.h"
#include "impedraw/run/identify_joints.h"
#include "impedraw/run/results.h"
#include "impedraw/run/run_folder.h"
#include "impedraw/run/simulated_arm.h"
#include "impedraw/settings/settings_doc.h"
#include "impedraw/settings/yaml_write.h"
#include "impedraw/terminal/clock.h"
#include "impedraw/terminal/progress.h"
#include "impedraw/terminal/say.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;

fs::path folder_for(const DrawOptions& options, const Scenario& scenario) {
  return options.out.empty() ? fs::path("runs") / scenario.name : options.out;
}

PageContext page_of(const fs::path& folder, const Experiment& experiment) {
  return page_context(experiment.scenario, experiment.artwork, draw_again(folder));
}

std::string numbers(const fs::path& folder, const Scenario& scenario, const Metrics& metrics,
                    bool table) {
  return metrics_summary(metrics, touches(scenario) ? Trace::line : Trace::none) +
         tool_figures(folder) + (table ? metrics_table(metrics) : "");
}

// The lines that name report and incident.
std::string pages(const fs::path& folder, const Metrics& metrics) {
  const auto path = [&folder](const char* name) {
    return fs::absolute(folder / name).lexically_normal().string();
  };
  return (metrics.ending.incident.empty()
              ? ""
              : fmt::format("incident  {}\n", path(metrics.ending.incident.c_str()))) +
         fmt::format("report  {}\n", path("report.html"));
}

void say_comparison(const fs::path& folder) {
  say(stdout, "comparison  {}\n",
      fs::absolute(folder / "compare.html").lexically_normal().string());
}

auto number_of_settings(const std::vector<SettingRow>& rows) {
  return std::count_if(rows.begin(), rows.end(), [](const SettingRow& row) { return !row.group; });
}

// docs/settings.md, which is this program's own output.
std::string settings_page(const std::vector<SettingRow>& rows) {
  return "# Settings\n\n"
         "This page lists every setting of a scenario: first those that an artist sets, then those "
         "of an expert on the arm. `./impedraw settings` prints the first, `--all` both, and "
         "`--markdown` this page.\n\n"
         "A YAML file names the settings that differ from their default "
         "(`control: {normal_force: 3}`). `extends: other.yaml` takes everything from another file "
         "first. The command line sets any one of them (`--set control.normal_force=3`, `--set "
         "perception.cameras.0.width=320`). An N in a name stands for the index of a list's "
         "element, counted from 0.\n\n"
         "Editors complete and check scenario files with the JSON Schema "
         "[scenario.schema.json](scenario.schema.json). Settings that have been renamed are listed "
         "in [migration.md](migration.md).\n\n## For users\n\n" +
         rows_markdown(of_tier(Tier::users, rows)) + "\n## For experts\n\n" +
         rows_markdown(of_tier(Tier::experts, rows));
}

// True if an arm of one's own would draw on a canvas that nobody placed, and cannot.
bool lies_out_of_reach(const Scenario& s, const Places& places) {
  const Scenario usual;
  if (s.arm.urdf.empty() || s.arm.driver != ArmDriver::sim || s.canvas.kind == CanvasKind::mesh ||
      s.perception.source != PerceptionSource::simulated || !s.canvas.move.isZero() ||
      !s.drawing.tilt_deg.isZero() || !s.canvas.motion.file.empty() ||
      s.drawing.placement.centre_m != usual.drawing.placement.centre_m)
    return false;
  try {
    return !prepare_plan(s, places, Unreachable::tell).plan.preflight.findings.empty();
  } catch (const InputError&) {
    return true;
  }
}

SurfacePlace found_on_surface(const SurfaceWish& wish, const Scenario& scenario,
                              const Places& places) {
  ProgressLine line;
  return place_on_surface(scenario, places, wish,
                          [&line](double share) { line.update("placing the drawing", share); });
}

std::optional<Eigen::Vector2d> size_of_whole(const SurfaceWish& wish, const SurfacePlace& found) {
  ProgressLine line;
  return whole_size_mm(
      wish, found, [&line](double share) { line.update("looking for a size that fits", share); });
}

Scenario placed_on_surface(const SurfacePlace& found) {
  say(stderr,
      "placed  the drawing's middle at ({:.3f}, {:.3f}, {:.3f}) m, turned by {:.0f}°, {:.0f} × "
      "{:.0f} mm: {:.1f} % of it can be drawn\n        again there:",
      found.p_W.x(), found.p_W.y(), found.p_W.z(), found.turn_deg, found.size_mm.x(),
      found.size_mm.y(), 100.0 * found.share);
  for (const std::string& set : found.assignments) say(stderr, " --set '{}'", set);
  say(stderr, "\n");
  return found.scenario;
}

Scenario placed_with_canvas(const Scenario& scenario, const Places& places) {
  PlacedCanvas found;
  {
    ProgressLine line;
    found = place_automatically(
        scenario, places, [&line](double share) { line.update("placing the canvas", share); });
  }
  if (!found.passes) {  // elsewhere on the object it may be drawn
    try {
      const SurfacePlace elsewhere = found_on_surface({.least = kNearlyAll}, scenario, places);
      if (elsewhere.share >= kNearlyAll) return placed_on_surface(elsewhere);
    } catch (const InputError&) {  // there is no place for it
    }
  }
  const Eigen::Vector2d c = found.scenario.drawing.placement.centre_m;
  say(stderr,
      "placed  the canvas was moved, the drawing's centre to ({:.3f}, {:.3f}) m, turned by "
      "{:.0f}°: worst margin "
      "{:.2f}, before {:.2f}{}\n",
      c.x(), c.y(), found.turn_deg, found.margin, found.margin_before,
      found.passes ? "" : "; some of it cannot be drawn there, and nowhere else is better");
  return found.scenario;
}

}  // namespace

Scenario placed(const DrawOptions& options, const Scenario& scenario, const Places& places) {
  if (options.place == "surface") {
    const SurfacePlace found = found_on_surface(options.surface, scenario, places);
    const auto whole = size_of_whole(options.surface, found);
    const Scenario there = placed_on_surface(found);
    if (whole)
      say(stderr, "note: the whole can be drawn {:.0f} × {:.0f} mm large: --shrink\n", whole->x(),
          whole->y());
    return there;
  }
  if (!options.surface.near.empty() || options.surface.shrink)
    throw InputError("--near and --shrink need --place surface");
  if (options.place == "auto") return placed_with_canvas(scenario, places);
  if (!options.place.empty() || !lies_out_of_reach(scenario, places)) return scenario;
  try {
    return placed_with_canvas(scenario, places);
  } catch (const InputError&) {  // what is wrong is told where the drawing is prepared
    return scenario;
  }
}

int draw(const DrawOptions& options, const LiveOptions& live, bool table) {
  const auto start = Clock::now();
  LiveView view(live);
  Places places;
  Scenario scenario = resolve(options, &places);
  const fs::path folder = folder_for(options, scenario);
  require_run_folder(folder);
  if (!options.out.empty() && !options.resume && !options.overwrite)
    require_no_finished_run(folder);
  const bool given = !options.scenario.empty() || !options.shape.empty() || !options.svg.empty() ||
                     !options.text.empty() || !options.assignments.empty();
  const bool begun = options.resume && is_own_file(folder / "run.h5");
  if (options.resume && !begun && !given)
    throw InputError(fmt::format(
        "--resume: {} contains no run to resume; name its folder with --out", folder.string()));
  // A resumed run keeps its placement.
  if (begun && (!given || (!options.place.empty() && options.place != "fixed")))
    scenario = recorded_scenario(folder, &places);
  else
    scenario = placed(options, scenario, places);
  const bool goes_on = begun && has_steps(folder / "run.h5");
  Scenario as_given = scenario;
  if (goes_on) find_inputs(&scenario, folder, InputsFrom::originals);
  Prepared experiment = prepare_visibly(scenario, places);
  if (goes_on) {
    // The preparation completes these.
    as_given.drawing.placement = experiment.scenario.drawing.placement;
    as_given.canvas.move = experiment.scenario.canvas.move;
    as_given.arm.start_p_WE = experiment.scenario.arm.start_p_WE;
    const ControlSettings& completed = experiment.scenario.control;
    as_given.control.pen_axis = completed.pen_axis;
    as_given.control.normal_error_deg = completed.normal_error_deg;
    as_given.control.felt_normal.share = completed.felt_normal.share;
    require_same_settings(as_given, folder);
  }
  require_steady_loop(experiment.scenario, live);
  print_notes(experiment);
  view.begin(experiment, draw_again(folder));
  if (!view.address().empty()) {
    say(stdout, "live    {}\n", view.address());
    std::fflush(stdout);
  }
  const Drawing drawing = draw_into(folder, experiment, seconds_since(start), options.resume,
                                    view.hooks(), driver_maker(experiment));
  view.finish(folder / "report.html");
  const RunOutcome& outcome = drawing.outcome;
  const std::string before =
      outcome.first_time > 0.0
          ? fmt::format("{:.2f} s simulated, ", outcome.first_time + outcome.simulated)
          : "";
  say(stdout, "{}: {}{:.2f} s {} in {:.2f} s\n{}{}{}{}{}{}", scenario.name, before,
      outcome.simulated,
      !before.empty()                                    ? "of it since the resume"
      : experiment.scenario.arm.driver == ArmDriver::sim ? "simulated"
                                                         : "of the arm's clock",
      outcome.wall.loop, numbers(folder, scenario, drawing.metrics, table),
      contact_line(experiment), met_line(drawing.outcome),
      velocity_line(experiment, drawing.outcome), ink_lines(experiment, drawing.outcome),
      pages(folder, drawing.metrics));
  return exit_code(drawing);
}

int compare(const DrawOptions& options, bool table) {
  Places places;
  Scenario seen = resolve(options, &places);
  seen.perception.enabled = true;
  Scenario blind = seen;
  blind.perception.enabled = false;
  blind.name += "-blind";
  const fs::path folder =
      options.out.empty() ? fs::path("runs") / (seen.name + "-compare") : options.out;
  require_comparison_folder(folder);
  if (!options.out.empty() && !options.overwrite)
    for (const char* side : {"perception", "blind"}) require_no_finished_run(folder / side);

  // Both are prepared before either is drawn, so that an error in the second leaves no half result.
  struct Side {
    std::string name;
    Prepared experiment;
    double start_up;
  };
  std::vector<Side> sides;
  for (const auto& [name, scenario] :
       {std::pair{"perception", &seen}, std::pair{"blind", &blind}}) {
    const auto start = Clock::now();
    Prepared experiment = prepare(*scenario, places);
    sides.push_back({name, std::move(experiment), seconds_since(start)});
  }
  int worst = kFinished;
  for (Side& side : sides) {
    const Drawing drawing = draw_into(folder / side.name, side.experiment, side.start_up);
    const int code = exit_code(drawing);
    if (drawing.outcome.end == RunEnd::interrupted) return code;
    worst = std::max(worst, code);
    say(stdout, "{}\n{}", side.name,
        numbers(folder / side.name, side.experiment.scenario, drawing.metrics, table));
  }
  const auto compared = [&](const char* name, const Side& side) {
    return ComparedRun{name, folder / side.name, page_of(folder / side.name, side.experiment)};
  };
  write_comparison(
      {compared("with perception", sides[0]), compared("without perception", sides[1])}, folder);
  say_comparison(folder);
  return worst;
}

int compare_finished(const std::vector<fs::path>& runs, const fs::path& out) {
  if (runs.size() < 2)
    throw InputError(fmt::format(
        "compare {}: one run alone; name the folders of two or more runs, or a scenario to draw",
        runs.front().string()));
  std::vector<ComparedRun> compared;
  for (const fs::path& folder : runs) {
    if (!is_own_file(folder / "run.h5"))
      throw InputError(
          fmt::format("{}: contains no run.h5; name the folder of a run", folder.string()));
    Places places;
    Scenario scenario = recorded_scenario(folder, &places);
    find_inputs(&scenario, folder, InputsFrom::folder);
    const PlacedArtwork artwork = load_artwork(scenario.drawing, SettingErrors(Places()));
    const auto named = [&](const std::string& name) {
      return std::count_if(compared.begin(), compared.end(),
                           [&](const ComparedRun& run) { return run.name == name; }) > 0;
    };
    // The folder's own name, unless another has it, too.
    std::string name = fs::absolute(folder).lexically_normal().filename().string();
    if (name.empty()) name = fs::absolute(folder).lexically_normal().parent_path().filename();
    if (named(name)) name = folder.string();
    if (named(name)) name += fmt::format(" ({})", compared.size() + 1);
    compared.push_back({name, folder, page_context(scenario, artwork, draw_again(folder))});
  }
  const fs::path folder =
      out.empty() ? fs::path("runs") / fmt::format("{}-compare", compared.front().name) : out;
  require_page_folder(folder);
  make_folder(folder);
  write_comparison(compared, folder);
  say_comparison(folder);
  return kFinished;
}

int calibrate_tool(const DrawOptions& options, int poses) {
  DrawOptions with_sensor = options;
  if (with_sensor.scenario.empty())
    with_sensor.built_in = data_folder() / "scenarios/bowl-sine-realistic.yaml";
  Places places;
  const Scenario scenario = resolve(with_sensor, &places);
  if (!has_sensor(scenario.control.source))
    throw InputError(
        fmt::format("{}: control.wrench has no sensor to read; valid are sensor, realistic",
                    places.of("control.wrench")));
  Prepared experiment = prepare(scenario, places);
  SimulatedArm arm(experiment, experiment.belief.start_q, Disturbances());
  const ToolIdentification found = calibrate_tool(experiment, arm, poses).found;
  say(stdout,
      "{} poses\n"
      "  mass      {:.4f} ± {:.4f} kg\n"
      "  centre    ({:.4f}, {:.4f}, {:.4f}) ± ({:.4f}, {:.4f}, {:.4f}) m, in the sensor's frame\n"
      "  bias      ({:.3f}, {:.3f}, {:.3f}) N, ({:.4f}, {:.4f}, {:.4f}) Nm\n"
      "  residual  {:.4f} N, {:.5f} Nm RMS an axis\n\n"
      "As a setting of a scenario:\n"
      "control: {{sensing: {{tool: {{mass: {:.4f}, centre: [{:.4f}, {:.4f}, {:.4f}]}}}}}}\n",
      poses, found.mass, found.mass_error, found.p_SC.x(), found.p_SC.y(), found.p_SC.z(),
      found.p_SC_error.x(), found.p_SC_error.y(), found.p_SC_error.z(), found.bias_S[0],
      found.bias_S[1], found.bias_S[2], found.bias_S[3], found.bias_S[4], found.bias_S[5],
      found.residual_force, found.residual_torque, found.mass, found.p_SC.x(), found.p_SC.y(),
      found.p_SC.z());
  return kFinished;
}

int report(const fs::path& folder, bool table) {
  if (!is_own_file(folder / "run.h5"))
    throw InputError(
        fmt::format("{}: contains no run.h5; name the folder of a run", folder.string()));
  const FolderLock lock(folder);
  const Interrupt interrupt;
  remove_unfinished(folder);
  recover_log(folder / "run.h5");
  Places places;
  Scenario scenario = recorded_scenario(folder, &places);
  find_inputs(&scenario, folder, InputsFrom::folder);
  if (!is_own_file(folder / "scenario.yaml"))
    write_whole(folder / "scenario.yaml", settings_yaml(scenario));
  const PlacedArtwork artwork = load_artwork(scenario.drawing, SettingErrors(Places()));
  const Metrics metrics =
      write_results(folder, scenario, artwork, backdrop_of(scenario, artwork, folder),
                    give_up_on(interrupt, folder));
  say(stdout, "{}{}", numbers(folder, scenario, metrics, table), pages(folder, metrics));
  return kFinished;
}

int print_settings(SettingsForm form) {
  Scenario defaults;
  const std::vector<SettingRow> rows = setting_rows(described(defaults));
  const std::vector<SettingRow> for_users = of_tier(Tier::users, rows);
  switch (form) {
    case SettingsForm::users:
      say(stdout, "{}\n{} more settings are for experts on the arm: ./impedraw settings --all\n",
          rows_text(for_users), number_of_settings(rows) - number_of_settings(for_users));
      break;
    case SettingsForm::all:
      say(stdout, "{}", rows_text(rows));
      break;
    case SettingsForm::markdown:
      say(stdout, "{}", settings_page(rows));
      break;
    case SettingsForm::json_schema:
      say(stdout, "{}", settings_json_schema<Scenario>("impedraw scenario"));
      break;
  }
  return kFinished;
}

}  // namespace impedraw
