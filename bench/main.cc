// ./impedraw bench: speed as ratios against floors of the same run, each beside its limit. Exit code 1 when a limit is missed.
//
// A shared machine slows floor and subject alike, but not at the same instant: each is repeated often and briefly, in mixed order, and the
// medians are compared. The best times would not do: one lucky moment of a faster clock for one of the two is a third of the ratio.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "app/commands.h"
#include "app/experiment.h"
#include "app/run.h"
#include "app/yaml_read.h"
#include "common/errors.h"
#include "floor.h"

namespace impedraw {
namespace {

const std::string kRoot = IMPEDRAW_ROOT;

Experiment& experiment(const std::string& name) {
  static std::map<std::string, Experiment> all;
  if (const auto it = all.find(name); it != all.end()) return it->second;
  DrawOptions options;
  options.scenario = kRoot + "/scenarios/" + name + ".yaml";
  return all.emplace(name, prepare(resolve(options))).first->second;
}

// Postures along the drawing, so that no branch predictor learns one by heart.
struct Posture {
  JointVector q, v;
};

std::vector<Posture> postures(const Experiment& e) {
  std::vector<Posture> all;
  for (int i = 0; i < 64; ++i) {
    JointVector q = e.control.q_0, v(q.size());
    for (int j = 0; j < q.size(); ++j) {
      q[j] += 0.1 * std::sin(0.37 * i + j);
      v[j] = 0.2 * std::cos(0.91 * i + 2 * j);
    }
    all.push_back({q, v});
  }
  return all;
}

void BM_floor(benchmark::State& state) {
  Floor floor((kRoot + "/models/iiwa14_pen.urdf").c_str());
  std::vector<std::pair<Eigen::VectorXd, Eigen::VectorXd>> all;
  for (const Posture& p : postures(experiment("bowl-sine"))) all.emplace_back(p.q, p.v);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(floor.compute(all[i].first, all[i].second));
    i = (i + 1) % all.size();
  }
}

void BM_arm_terms(benchmark::State& state) {
  Experiment& e = experiment("bowl-sine");
  const auto all = postures(e);
  ArmTerms terms(e.arm.joints());
  std::size_t i = 0;
  for (auto _ : state) {
    e.arm.compute(all[i].q, all[i].v, &terms);
    benchmark::DoNotOptimize(terms);
    i = (i + 1) % all.size();
  }
}

// A whole controller step in contact: arm terms and law.
void step(benchmark::State& state, const std::string& name) {
  Experiment& e = experiment(name);
  const auto all = postures(e);
  ArmTerms terms(e.arm.joints());
  ImpedanceController controller(e.control, e.arm.joints());
  const PathSample sample = e.path.at(0.5 * (e.path.strokes()[0].start + e.path.strokes()[0].end));
  SurfaceEstimate surface;
  surface.status = SurfaceStatus::ok;
  surface.n_W = sample.goal.n_WD;
  surface.distance = 0.0;
  Wrench F = Wrench::Zero();
  F.head<3>() = 5.0 * surface.n_W;
  std::size_t i = 0;
  for (auto _ : state) {
    e.arm.compute(all[i].q, all[i].v, &terms);
    benchmark::DoNotOptimize(controller.step(terms, sample.goal, surface, F));
    i = (i + 1) % all.size();
  }
}
void BM_step_shaped(benchmark::State& state) { step(state, "bowl-sine"); }
void BM_step_natural(benchmark::State& state) { step(state, "bowl-sine-natural"); }

// A whole run with its log; counts simulated seconds.
void draw(benchmark::State& state, const std::string& name) {
  Experiment& e = experiment(name);
  const std::filesystem::path log = std::filesystem::temp_directory_path() / ("impedraw_bench_" + std::to_string(getpid()) + ".h5");
  double simulated = 0.0, wall = 0.0;
  for (auto _ : state) {
    const RunOutcome outcome = run(e, log, 0.0);
    state.SetIterationTime(outcome.wall.loop + outcome.wall.writing);
    simulated += outcome.simulated;
    wall += outcome.wall.loop + outcome.wall.writing;
  }
  std::filesystem::remove(log);
  state.counters["real_time_factor"] = simulated / wall;
}
void BM_draw(benchmark::State& state) { draw(state, "bowl-sine"); }
void BM_draw_natural(benchmark::State& state) { draw(state, "bowl-sine-natural"); }
void BM_draw_blind(benchmark::State& state) { draw(state, "bowl-sine-blind"); }

BENCHMARK(BM_floor);
BENCHMARK(BM_arm_terms);
BENCHMARK(BM_step_shaped);
BENCHMARK(BM_step_natural);
BENCHMARK(BM_draw)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(1)->Repetitions(5);
BENCHMARK(BM_draw_natural)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(1)->Repetitions(5);
BENCHMARK(BM_draw_blind)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(1)->Repetitions(5);

// Collects every repetition beside the usual output.
class Repetitions : public benchmark::ConsoleReporter {
 public:
  using benchmark::ConsoleReporter::ConsoleReporter;
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration || run.error_occurred) continue;
      const std::string name = run.run_name.function_name + (run.run_name.args.empty() ? "" : "/" + run.run_name.args);
      time_[name].push_back(run.GetAdjustedCPUTime());  // what others take of a core does not count; whole runs go by wall time
      if (const auto c = run.counters.find("real_time_factor"); c != run.counters.end()) factor_[name].push_back(c->second.value);
    }
  }
  double time(const std::string& name) const { return median(time_, name); }  // [ns]
  double factor(const std::string& name) const { return median(factor_, name); }

 private:
  using Values = std::map<std::string, std::vector<double>>;
  static double median(const Values& values, const std::string& name) {
    const auto it = values.find(name);
    if (it == values.end()) return std::nan("");
    std::vector<double> sorted = it->second;
    std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
    return sorted[sorted.size() / 2];
  }
  Values time_, factor_;
};

struct Line {
  const char* what;
  double value, limit;
  bool at_most;
};

int judge(const Repetitions& median) {
  const std::vector<Line> lines = {
      {"floor of a controller step [µs]; above 6.5 it is no floor", median.time("BM_floor") / 1e3, 6.5, true},
      {"controller step, shaped inertia / floor", median.time("BM_step_shaped") / median.time("BM_floor"), 2.0, true},
      {"controller step, natural inertia / floor", median.time("BM_step_natural") / median.time("BM_floor"), 2.0, true},
      {"fresh normal / bare k-nearest-neighbour query (k = 60)", median.time("BM_normal_fresh/60") / median.time("BM_knn_bare/60"), 1.5,
       true},
      {"real_time_factor, perception, wrench true", median.factor("BM_draw"), 30.0, false},
      {"real_time_factor, perception, wrench none", median.factor("BM_draw_natural"), 30.0, false},
      {"real_time_factor, blind", median.factor("BM_draw_blind"), 40.0, false},
  };
  int missed = 0, judged = 0;
  std::printf("\n%-60s %9s %10s\n", "ratio (medians of the repetitions)", "value", "limit");
  for (const Line& line : lines) {
    if (std::isnan(line.value)) continue;  // filtered out
    const bool holds = line.at_most ? line.value <= line.limit : line.value >= line.limit;
    missed += !holds;
    ++judged;
    std::printf("%-60s %9.2f %5s %5.1f%s\n", line.what, line.value, line.at_most ? "<=" : ">=", line.limit, holds ? "" : "   MISSED");
  }
  std::printf("%d of %d limits held\n", judged - missed, judged);
  return missed == 0 && judged > 0 ? kFinished : kMissed;
}

}  // namespace
}  // namespace impedraw

int main(int argc, char** argv) {
  std::vector<char*> arguments(argv, argv + argc);
  std::string repetitions = "--benchmark_repetitions=25", interleaving = "--benchmark_enable_random_interleaving=true",
              min_time = "--benchmark_min_time=0.02";
  arguments.insert(arguments.begin() + 1, {repetitions.data(), interleaving.data(), min_time.data()});
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return impedraw::kBadInput;
  try {
    impedraw::Repetitions repetitions_done(benchmark::ConsoleReporter::OO_None);
    benchmark::RunSpecifiedBenchmarks(&repetitions_done);
    return impedraw::judge(repetitions_done);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "impedraw bench: %s\n", error.what());
    return impedraw::kStopped;
  }
}
