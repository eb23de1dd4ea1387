#include "impedraw/app/commands.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/exit_code.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/judge/force_results.h"
#include "impedraw/run/real_time.h"
#include "impedraw/run/run_folder.h"
#include "impedraw/settings/settings_text.h"
#include "impedraw/terminal/clock.h"
#include "impedraw/terminal/interrupt.h"
#include "impedraw/terminal/progress.h"
#include "impedraw/terminal/say.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;

constexpr double kSensorPatience = 60.0;  // for the sensor's file, after the last run [s]

std::vector<ForceController> controllers_of(const std::vector<std::string>& names) {
  const std::vector<std::string> known(std::begin(kForceControllerNames),
                                       std::end(kForceControllerNames));
  std::vector<ForceController> found;
  for (const std::string& name : names)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw InputError("--controllers: " + not_among(name, known));
  for (std::size_t i = 0; i < known.size(); ++i)
    if (names.empty() || std::find(names.begin(), names.end(), known[i]) != names.end())
      found.push_back(static_cast<ForceController>(i));
  return found;
}

bool is_driver(const std::string& arm) {
  return arm == "sim" || arm == "iiwa-lcm" || arm == "franka";
}

// A workpiece that stands where the scenario's canvas does, seen by no camera: what a controller
// knows of it, the benchmark says.
Scenario scenario_of(DrawOptions options, const JudgeForceOptions& judged, Places* places) {
  if (options.scenario.empty()) options.built_in = data_folder() / "scenarios/force-benchmark.yaml";
  if (is_driver(judged.arm)) {
    if (judged.arm != "sim") options.arm = judged.arm;
  } else if (judged.arm != "iiwa") {
    const fs::path urdf = options.out / "arm.urdf";
    make_urdf(judged.arm, "", {}, urdf);
    options.assignments.push_back("arm.urdf=" + fs::absolute(urdf).string());
  }
  Scenario s = placed(options, resolve(options, places), *places);
  if (s.canvas.kind != CanvasKind::bowl)
    throw InputError(
        "judge-force: canvas.kind must be bowl; the benchmark puts its own workpieces there");
  if (s.tool.kind != ToolKind::pen)
    SettingErrors(*places).raise({"tool.kind"},
                                 "tool.kind: judge-force judges a pen's force; valid is pen");
  s.perception.enabled = false;
  // The scenario's drawing is planned, and not drawn.
  const Eigen::Vector3d middle_W = Workpiece().p_W + s.canvas.move;
  s.drawing.placement.centre_m = middle_W.head<2>();
  s.drawing.skip_unreachable = true;
  s.canvas.motion = {};
  s.pushes.clear();
  s.faults.clear();
  if (places->of("arm.start").starts_with("default"))
    s.arm.start_p_WE = middle_W + (ForceProgramme::kHover + 0.01) * Eigen::Vector3d::UnitZ();
  return s;
}

std::string name_of_arm(const JudgeForceOptions& judged, const Scenario& s) {
  if (!is_driver(judged.arm)) return judged.arm == "iiwa" ? "iiwa14" : judged.arm;
  return s.arm.urdf.empty() ? "iiwa14" : s.arm.urdf.stem().string();
}

void write(const ForceResults& results, const fs::path& folder) {
  write_whole(folder / "force.json", force_json(results));
  write_whole(folder / "force.md", force_markdown(results));
  write_whole(folder / "force.html", force_page(results));
}

std::string command_of(const DrawOptions& options, const JudgeForceOptions& judged) {
  std::string text = "./impedraw judge-force --arm " + judged.arm;
  if (!options.scenario.empty()) text += " " + options.scenario.string();
  if (!judged.cases.empty()) text += fmt::format(" --cases {}", fmt::join(judged.cases, ","));
  if (!judged.controllers.empty())
    text += fmt::format(" --controllers {}", fmt::join(judged.controllers, ","));
  if (!judged.sensor.empty()) text += " --sensor " + judged.sensor.string();
  if (!judged.rig.empty()) text += " --rig " + judged.rig.string();
  if (judged.runs != 5) text += fmt::format(" --runs {}", judged.runs);
  for (const std::string& set : options.assignments) text += fmt::format(" --set '{}'", set);
  return text;
}

void say_summary(const ForceCase& c, const JudgedController& judged) {
  std::string line;
  for (int m = 0; m < kForceMetrics; ++m)
    if (const ForceSummary found = judged.summary(m); found.mean)
      line += fmt::format("  {} {}", kForceMetricNames[m], shown_metric(m, found.mean));
  const auto failed = std::count_if(judged.runs.begin(), judged.runs.end(),
                                    [](const JudgedRun& run) { return !run.run.ended.empty(); });
  if (failed > 0) line += fmt::format("  {} of {} runs ended early", failed, judged.runs.size());
  say(stdout, "{:16} {:10}{}\n", c.name, kForceControllerNames[static_cast<int>(judged.controller)],
      line);
}

// The records of later runs go: the page shows the first.
void judge(JudgedRun* judged) {
  if (judged->run.ended.empty())
    judged->metrics = judge_force(judged->run.record, judged->run.question);
  if (judged->seed > 1) judged->run.record.clear();
}

}  // namespace

int judge_force(DrawOptions options, const JudgeForceOptions& judged) {
  const std::vector<ForceController> controllers = controllers_of(judged.controllers);
  std::vector<ForceCase> cases = force_cases(judged.cases);
  if (!judged.sensor.empty() && fs::exists(judged.sensor))
    throw InputError(fmt::format(
        "--sensor {}: it exists already; valid is a file that the sensor leaves after the runs",
        judged.sensor.string()));
  ForceResults results;
  results.again = command_of(options, judged);
  if (options.out.empty()) options.out = "runs/judge-force";
  make_folder(options.out);
  const FolderLock lock(options.out);
  Places places;
  const Scenario scenario = scenario_of(options, judged, &places);
  Prepared experiment = prepare(scenario, places);
  const DriverMaker make_driver = driver_maker(experiment);
  if (!make_driver && !(judged.rig.empty() && judged.sensor.empty()))
    throw InputError(fmt::format(
        "{}: the simulated arm has its own workpieces and the sensor under them; valid with --arm "
        "iiwa-lcm or franka",
        judged.rig.empty() ? "--sensor" : "--rig"));
  const auto start = Clock::now();

  results.arm = name_of_arm(judged, scenario);
  results.driver = is_driver(judged.arm) ? judged.arm : "sim";
  results.simulated = !make_driver || scenario.arm.clock == ArmClock::lock_step;
  results.runs = judged.runs;
  const auto kept = std::stable_partition(cases.begin(), cases.end(), [&](const ForceCase& c) {
    return !make_driver || !judged.rig.empty() || !c.needs_rig();
  });
  for (auto c = kept; c != cases.end(); ++c) results.left_out.push_back(c->name);
  cases.erase(kept, cases.end());
  if (cases.empty())
    throw InputError(fmt::format(
        "--cases: {}: these need another workpiece; valid with --arm {} are --rig, or contact-10, "
        "steps, sweep, hold-still, curved-50, for instance",
        fmt::join(results.left_out, ", "), judged.arm));

  const Interrupt interrupt;
  const RealTime real_time(!results.simulated && scenario.arm.real_time);
  const double all = static_cast<double>(cases.size() * controllers.size()) * judged.runs;
  double done = 0.0;
  ProgressLine line;
  {
    ForceBench bench(experiment, make_driver, !judged.sensor.empty(), judged.rig);
    const auto go_on = [&] { return !interrupt.requested() && !interrupt.emergency(); };
    for (const ForceCase& c : cases) {
      results.cases.push_back({c, {}});
      for (const ForceController controller : controllers) {
        JudgedController one{controller, {}};
        for (int seed = 1; seed <= judged.runs && go_on() && bench.fault().empty(); ++seed) {
          line.update(fmt::format("{}, {}, run {}", c.name,
                                  kForceControllerNames[static_cast<int>(controller)], seed),
                      done / all);
          ForceRun run = bench.run(c, controller, seed, go_on);
          if (!go_on()) break;
          done += 1.0;
          one.runs.push_back({seed, {}, std::move(run)});
          if (judged.sensor.empty()) judge(&one.runs.back());
        }
        if (one.runs.empty()) continue;
        line.wipe();
        if (judged.sensor.empty()) say_summary(c, one);
        results.cases.back().controllers.push_back(std::move(one));
      }
      if (results.cases.back().controllers.empty()) results.cases.pop_back();
    }
    if (!bench.fault().empty()) results.ended = bench.fault();
  }
  if (!judged.sensor.empty() && !results.cases.empty()) {
    line.update("waiting for " + judged.sensor.string(), 0.0);
    const SensorFile sensor(judged.sensor, kSensorPatience);
    line.wipe();
    for (JudgedCase& c : results.cases)
      for (JudgedController& one : c.controllers) {
        for (JudgedRun& run : one.runs) {
          sensor.fill(&run.run);
          run.run.ask();
          judge(&run);
        }
        say_summary(c.what, one);
      }
  }
  if (done < all && results.ended.empty()) results.ended = "interrupted";
  results.seconds = seconds_since(start);
  write(results, options.out);
  say(stdout, "{} cases, {} controllers, {} runs each, in {:.0f} s{}\nreport  {}\n",
      results.cases.size(), controllers.size(), judged.runs, results.seconds,
      results.ended.empty() ? "" : "; " + results.ended,
      fs::absolute(options.out / "force.html").lexically_normal().string());
  if (interrupt.requested()) return interrupt.exit_code();
  return results.ended.empty() ? kFinished : kStopped;
}

}  // namespace impedraw
