// What people wait for on a scan of 50,000 triangles: the plan of 2 m of line, its placement, and a
// quick check of where it is dragged to. The limits are in main.cc.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "impedraw/experiment/place_auto.h"
#include "impedraw/experiment/plan.h"
#include "impedraw/experiment/prepare.h"
#include "impedraw/settings/yaml_read.h"
#include "processor_time.h"
#include "scan_bench.h"

namespace impedraw {
namespace {

// An egg with bumps of 4 mm, 0.3 m wide.
std::filesystem::path scan() {
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     ("impedraw_scan_" + std::to_string(getpid()) + ".obj");
  constexpr int kAround = 224, kUp = 112;
  std::ofstream out(file);
  for (int j = 0; j <= kUp; ++j)
    for (int i = 0; i < kAround; ++i) {
      const double a = 2.0 * std::numbers::pi * i / kAround, b = std::numbers::pi * j / kUp;
      const double r = 1.0 + 0.03 * std::sin(9.0 * a) * std::sin(7.0 * b) * std::sin(b);
      out << "v " << 0.15 * r * std::sin(b) * std::cos(a) << ' '
          << 0.15 * r * std::sin(b) * std::sin(a) << ' ' << 0.1 - 0.1 * r * std::cos(b) << '\n';
    }
  for (int j = 0; j < kUp; ++j)
    for (int i = 0; i < kAround; ++i) {
      const int a = j * kAround + i + 1, b = j * kAround + (i + 1) % kAround + 1;
      out << "f " << a << ' ' << b << ' ' << b + kAround << '\n'
          << "f " << a << ' ' << b + kAround << ' ' << a + kAround << '\n';
    }
  return file;
}

}  // namespace

const Scenario& scan_scenario() {
  static const Scenario made = [] {
    DrawOptions options;
    options.svg = std::string(IMPEDRAW_ROOT) + "/artwork/koi.svg";
    options.assignments = {"canvas.kind=mesh", "canvas.mesh.file=" + scan().string(),
                           "drawing.placement.fit_radius=0.08", "drawing.skip_unreachable=true"};
    return resolve(options);
  }();
  return made;
}

namespace {

void BM_scan_plan(benchmark::State& state) {
  for (auto _ : state) {
    const double before = processor_seconds();
    const PreparedPlan e = prepare_plan(scan_scenario(), {}, Unreachable::tell);
    state.SetIterationTime(processor_seconds() - before);
    state.counters["line_m"] = plane_length(e.plan.requested(e.artwork));
  }
}

void BM_scan_place(benchmark::State& state) {
  for (auto _ : state) {
    const double before = processor_seconds();
    benchmark::DoNotOptimize(place_automatically(scan_scenario(), {}).margin);
    state.SetIterationTime(processor_seconds() - before);
  }
}

// Reach, slope, edge and size of the drawing, moved by up to 20 mm over a surface that has been
// planned on. The repetitions are placements.
void BM_scan_quick(benchmark::State& state) {
  static PreparedPlan e = prepare_plan(scan_scenario(), {}, Unreachable::tell);
  static int placement = 0;
  for (auto _ : state) {
    const double turn = 2.4 * ++placement;
    const Eigen::Vector2d by =
        0.002 * (placement % 11) * Eigen::Vector2d(std::cos(turn), std::sin(turn));
    std::vector<PlacedStroke> strokes = e.artwork.strokes;
    for (PlacedStroke& stroke : strokes)
      for (Eigen::Vector2d& p : stroke.p_P) p += by;
    const double before = processor_seconds();
    benchmark::DoNotOptimize(
        check_strokes(strokes, e.surface(), e.belief.arm, e.belief.obstacle.get(), e.belief.start_q,
                      preflight_settings(e.scenario, e.artwork.X_WP, true, e.plan.rest_q))
            .drawable.size());
    state.SetIterationTime(processor_seconds() - before);
  }
}

BENCHMARK(BM_scan_plan)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1)
    ->Repetitions(3);
BENCHMARK(BM_scan_place)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1)
    ->Repetitions(2);
BENCHMARK(BM_scan_quick)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1)
    ->Repetitions(40);

}  // namespace
}  // namespace impedraw
