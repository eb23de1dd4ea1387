// Runs drawings in this process, through the functions that ./impedraw draw calls.
#include <chrono>
#include <mutex>
#include <optional>

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/experiment/plan_summary.h"
#include "impedraw/experiment/prepare.h"
#include "impedraw/log/run_data.h"
#include "impedraw/metrics/metrics.h"
#include "impedraw/run/log_row.h"
#include "impedraw/run/run_folder.h"
#include "impedraw/run/simulated_arm.h"
#include "impedraw/settings/settings_doc.h"
#include "impedraw/terminal/clock.h"
#include "module.h"

namespace impedraw::python {
namespace {

namespace fs = std::filesystem;

// Calls Python now and then from a loop that runs without the GIL: for signals, and for progress.
class PythonWatch {
 public:
  explicit PythonWatch(nb::object progress) : progress_(std::move(progress)) {}

  // True once a signal's handler, or the callback, has raised: rethrow() then gives its error.
  bool interrupted() { return poll(-1.0, ""); }
  bool poll(double share, const char* what) {
    if (error_) return true;
    const auto now = Clock::now();
    Clock::time_point& next = share < 0.0 ? next_check_ : next_call_;
    if (now < next) return false;
    next = now + std::chrono::milliseconds(50);
    const nb::gil_scoped_acquire gil;
    try {
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
      if (share >= 0.0 && !progress_.is_none()) progress_(what, share);
    } catch (nb::python_error& error) {
      error_.emplace(std::move(error));
    }
    return error_.has_value();
  }
  void rethrow() {
    if (error_) throw nb::python_error(*error_);
  }

 private:
  nb::object progress_;
  Clock::time_point next_check_ = Clock::now(), next_call_ = next_check_;
  std::optional<nb::python_error> error_;
};

struct Result {
  Drawing drawing;
  std::vector<std::string> notes;
  std::string name;
  fs::path folder;
};

nb::dict metrics_dict(const Metrics& metrics) {
  nb::dict values;
  for (const MetricDefinition& d : metric_definitions()) {
    const auto& value = (metrics.*d.member).value();
    values[d.name] = value ? nb::float_(*value) : nb::object(nb::none());
  }
  return values;
}

nb::dict reasons_dict(const Metrics& metrics) {
  nb::dict reasons;
  for (const MetricDefinition& d : metric_definitions())
    if (const Metric& metric = metrics.*d.member; !metric.value())
      reasons[d.name] = metric.reason();
  return reasons;
}

nb::dict ending_dict(const Metrics& metrics) {
  nb::dict d;
  d["end"] = name_of(metrics.ending.end);
  d["cause"] = metrics.ending.cause;
  d["not_drawn"] = metrics.not_drawn;
  d["not_drawn_mm"] = metrics.not_drawn_mm;
  return d;
}

nb::dict dict_of(const Result& r) {
  const RunOutcome& outcome = r.drawing.outcome;
  nb::dict d = ending_dict(r.drawing.metrics);
  d["name"] = r.name;
  d["folder"] = r.folder.empty() ? nb::object(nb::none()) : nb::cast(r.folder.string());
  d["metrics"] = metrics_dict(r.drawing.metrics);
  d["reasons"] = reasons_dict(r.drawing.metrics);
  d["met"] = outcome.met;
  d["simulated"] = outcome.simulated;
  nb::dict wall;
  wall["start_up"] = outcome.wall.start_up;
  wall["loop"] = outcome.wall.loop;
  d["wall"] = wall;
  d["drawn_again"] = outcome.drawn_again.size();
  d["lacking"] = outcome.lacking.size();
  d["notes"] = r.notes;
  return d;
}

// One drawing at a time in a process has the signals (terminal/interrupt.h).
std::mutex& signals() {
  static std::mutex mutex;
  return mutex;
}

// Holds the scenes of its last runs. One thread at a time.
class Runner {
 public:
  explicit Runner(int scenes) : scenes_(static_cast<std::size_t>(scenes)) {}

  // out: the run's folder, made as by ./impedraw draw; empty: nothing is written.
  nb::dict run(const DrawOptions& options, bool to_folder, const nb::object& progress) {
    PythonWatch watch(progress);
    Result result;
    {
      const nb::gil_scoped_release no_gil;
      const std::lock_guard own(mutex_);
      draw(options, to_folder, &watch, &result);
    }
    watch.rethrow();
    return dict_of(result);
  }

  long built() const { return scenes_.built(); }
  long reused() const { return scenes_.reused(); }

 private:
  struct GiveUp {};

  void draw(const DrawOptions& options, bool to_folder, PythonWatch* watch, Result* result) {
    const auto start = Clock::now();
    Places places;
    const Scenario scenario = resolve(options, &places);
    result->name = scenario.name;
    if (to_folder) {
      result->folder = options.out.empty() ? fs::path("runs") / scenario.name : options.out;
      require_run_folder(result->folder);
      if (!options.out.empty() && !options.overwrite) require_no_finished_run(result->folder);
    }
    const PrepareProgress prepared = [&](const char* what, double share) {
      if (watch->poll(share, what)) throw GiveUp();
    };
    std::optional<Prepared> experiment;
    try {
      experiment.emplace(prepare(scenario, places, Unreachable::refuse, prepared, &scenes_));
    } catch (const GiveUp&) {
      return;
    }
    result->notes = notes_of(*experiment);
    RunHooks hooks;
    hooks.interrupted = [watch] { return watch->interrupted(); };
    hooks.progress = [watch](const RunProgress& p) {
      watch->poll(p.share, p.waits_for ? "waiting" : "drawing");
    };
    try {
      if (to_folder) {
        const std::lock_guard one(signals());
        result->drawing =
            draw_into(result->folder, *experiment, seconds_since(start), false, hooks);
      } else {
        RunRecorder recorder(make_header(*experiment));
        hooks.row = [&recorder](const LogRow& row) { recorder.add(row); };
        result->drawing.outcome = impedraw::run(*experiment, {}, seconds_since(start), hooks);
        RunData drawn = recorder.take(result->drawing.outcome.wall);
        drawn.attributes[kEndingAttribute] = ending_text(result->drawing.outcome);
        result->drawing.metrics = compute_metrics(drawn);
      }
    } catch (...) {
      scenes_.give_back(scene_of(std::move(*experiment)));
      throw;
    }
    scenes_.give_back(scene_of(std::move(*experiment)));
  }

  SceneCache scenes_;
  std::mutex mutex_;
};

nb::object plan(const DrawOptions& options) {
  std::string text;
  {
    const nb::gil_scoped_release no_gil;
    Places places;
    const Scenario scenario = resolve(options, &places);
    PreparedPlan drawing = prepare_plan(scenario, places, Unreachable::tell);
    control_for(&drawing, places);
    text = plan_json(drawing).dump();
  }
  return nb::module_::import_("json").attr("loads")(text);
}

nb::list definitions() {
  nb::list list;
  for (const MetricDefinition& d : metric_definitions())
    list.append(nb::make_tuple(d.name, d.unit, d.meaning, d.count));
  return list;
}

nb::tuple metrics_of(const fs::path& log) {
  Metrics metrics;
  {
    const nb::gil_scoped_release no_gil;
    metrics = compute_metrics(read_run(log));
  }
  return nb::make_tuple(metrics_dict(metrics), reasons_dict(metrics), ending_dict(metrics));
}

}  // namespace

void bind_run(nb::module_& m) {
  nb::class_<DrawOptions>(m, "DrawOptions", "What is drawn, as the command line takes it.")
      .def(nb::init<>())
      .def_rw("scenario", &DrawOptions::scenario)
      .def_rw("shape", &DrawOptions::shape)
      .def_rw("svg", &DrawOptions::svg)
      .def_rw("text", &DrawOptions::text)
      .def_rw("no_perception", &DrawOptions::no_perception)
      .def_rw("keep_order", &DrawOptions::keep_order)
      .def_rw("skip_unreachable", &DrawOptions::skip_unreachable)
      .def_rw("overwrite", &DrawOptions::overwrite)
      .def_rw("out", &DrawOptions::out)
      .def_rw("assignments", &DrawOptions::assignments);
  nb::class_<Runner>(m, "Runner",
                     "Draws in this process. Keeps the scenes of its last runs: a run whose\n"
                     "settings make the same scene does not make it again, and gives the same\n"
                     "numbers. Threads may each have a runner of their own.")
      .def(nb::init<int>(), nb::arg("scenes") = 4)
      .def("run", &Runner::run, nb::arg("options"), nb::arg("to_folder") = false,
           nb::arg("progress").none() = nb::none(),
           nb::sig("def run(self, options: DrawOptions, to_folder: bool = False, progress: "
                   "collections.abc.Callable[[str, float], object] | None = None) -> dict[str, "
                   "typing.Any]"),
           "Draws once. Without to_folder, nothing is written. Raises ValueError for what\n"
           "./impedraw draw refuses with exit code 2, before anything is written.")
      .def_prop_ro("scenes_built", &Runner::built)
      .def_prop_ro("scenes_reused", &Runner::reused);
  m.def("plan", &plan, nb::arg("options"),
        "The pre-flight: what ./impedraw plan --json prints, as a dict.");
  m.def("metric_definitions", &definitions, "(name, unit, meaning, is a count) of each metric.");
  m.def("metrics_of", &metrics_of, nb::arg("log"),
        "Metrics of a run.h5, the reasons of those that could not be computed, and how it ended.");
}

}  // namespace impedraw::python
