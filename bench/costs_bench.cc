// Cost of large inputs relative to a floor measured in the same run: sorting a million numbers. The
// limits of the ratios are in main.cc.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "impedraw/canvas/canvas.h"
#include "impedraw/canvas/mesh_check.h"
#include "impedraw/drawing/order.h"
#include "impedraw/drawing/svg.h"
#include "impedraw/log/log.h"
#include "impedraw/metrics/metrics.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/wrap/wrap.h"
#include "log/run_columns.h"
#include "processor_time.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

template <typename Work>
void measure(benchmark::State& state, const Work& work) {
  for (auto _ : state) {
    const double before = processor_seconds();
    work();
    state.SetIterationTime(processor_seconds() - before);
  }
}

std::optional<SurfaceSample> bowl(double x, double y) {
  const Vector3d centre(0.60, 0.0, 0.40);
  const double r = std::hypot(x - 0.60, y);
  if (r > 0.18) return std::nullopt;
  const Vector3d p(x, y, 0.40 - std::sqrt(0.09 - r * r));
  return SurfaceSample{p, (centre - p) / 0.30};
}

PlacedStroke stroke_through(const std::vector<Vector2d>& points) { return {points, points, 0}; }

void BM_sort(benchmark::State& state) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform;
  std::vector<double> numbers(1000000);
  for (double& x : numbers) x = uniform(random);
  measure(state, [&] {
    std::vector<double> sorted = numbers;
    std::sort(sorted.begin(), sorted.end());
    benchmark::DoNotOptimize(sorted.data());
  });
}

// 2,000,000 triangles of a wave, from a binary STL to a canvas ready for queries.
void BM_mesh(benchmark::State& state) {
  constexpr int kSide = 1000;
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     ("impedraw_bench_" + std::to_string(getpid()) + ".stl");
  {
    std::ofstream out(file, std::ios::binary);
    const auto put = [&out](const auto& value) {
      out.write(reinterpret_cast<const char*>(&value), sizeof value);
    };
    const auto corner = [&](int i, int j) {
      const double x = 0.4 * i / kSide, y = 0.4 * j / kSide;
      for (const double v : {x, y, 0.02 * std::sin(20 * x) * std::cos(17 * y)})
        put(static_cast<float>(v));
    };
    out << std::string(80, ' ');
    put(std::uint32_t{2 * kSide * kSide});
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j)
        for (const int half : {0, 1}) {
          out << std::string(12, '\0');
          corner(i, j);
          corner(i + 1, half ? j + 1 : j);
          corner(half ? i : i + 1, j + 1);
          put(std::uint16_t{0});
        }
  }
  measure(state, [&] {
    const Canvas canvas(load_mesh(file, 1.0).mesh);
    benchmark::DoNotOptimize(canvas.closest(Vector3d(0.2, 0.2, 0.0)));
  });
  std::filesystem::remove(file);
}

// 20 minutes of drawing: 1.2 million rows matched to 150,000 target points.
void BM_metrics(benchmark::State& state) {
  constexpr Eigen::Index kRows = 1200000, kPerStroke = 600;
  RunConstants constants;
  constants.joint_lower = Eigen::Vector2d(-1.0, -2.0);
  constants.joint_upper = Eigen::Vector2d(1.0, 2.0);
  constants.torque_limit = Eigen::Vector2d(10.0, 20.0);
  RunRows rows;
  {
    const auto n = static_cast<std::size_t>(kRows);
    rows.joint_position = rows.joint_velocity = rows.joint_torque = rows.torque_before_limits =
        RunRows::Joints::Zero(kRows, 2);
    rows.time_scale.assign(n, 1.0);
    rows.stroke_along.assign(n, LogRow::kNone);
    rows.contact_force.assign(n, {0.0, 0.0, 5.0});
    rows.contact_normal.assign(n, Vector3d::UnitZ());
    rows.surface_normal.assign(n, Vector3d::UnitZ());
    rows.tip_position.assign(n, Vector3d::Zero());
    rows.desired_position.assign(n, Vector3d::Zero());
    rows.tip_orientation.assign(n, Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0));
    rows.surface_distance.assign(n, 0.0);
    rows.push.assign(n, 5.0);
    rows.step_time.assign(n, 1e-5);
    rows.mode.assign(n, 0);
    for (Eigen::Index i = 0; i < kRows; ++i) {
      const auto stroke = static_cast<int>(i / kPerStroke);
      rows.time.push_back(1e-3 * static_cast<double>(i));
      rows.contact_point.emplace_back(5e-5 * static_cast<double>(i % kPerStroke),
                                      1e-3 * (stroke % 100) + 3e-5, 0.0);
      rows.stroke.push_back(stroke);
    }
  }
  RunData run = recorded(rows, constants);
  for (int stroke = 0; stroke < 2000; ++stroke)
    for (int k = 0; k <= 75; ++k) {
      run.target_points.emplace_back(5e-4 * k, 1e-3 * (stroke % 100), 0.0);
      run.target_stroke.push_back(stroke);
    }
  measure(state, [&] { benchmark::DoNotOptimize(compute_metrics(run)); });
}

void BM_order(benchmark::State& state) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(0.0, 200.0);
  std::vector<Stroke> dots(static_cast<std::size_t>(state.range(0)));
  for (Stroke& dot : dots) dot.points = {Vector2d(place(random), place(random))};
  measure(state, [&] { benchmark::DoNotOptimize(shortest_order(dots)); });
}

// Triangles without order or neighbours in a box, as 3-D scans gone wrong have them: checked,
// repaired and ready for queries.
void BM_soup(benchmark::State& state) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(0.0, 0.3), side(0.0, 0.01);
  TriangleMesh soup;
  for (int i = 0; i < state.range(0); ++i) {
    const Vector3d p(place(random), place(random), 0.2 * place(random));
    for (int k = 0; k < 3; ++k)
      soup.vertices.push_back(p + Vector3d(side(random), side(random), side(random)));
    soup.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  measure(state, [&] {
    const Canvas canvas(check_mesh(soup).mesh);
    for (int i = 0; i < 1000; ++i)
      benchmark::DoNotOptimize(canvas.closest(Vector3d(place(random), place(random), 0.03)));
  });
}

// 10,000 subpaths with one curve each.
void BM_svg(benchmark::State& state) {
  std::string document =
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 100 100'>"
      "<path stroke='red' d='";
  for (int i = 0; i < 10000; ++i)
    document += "M" + std::to_string(i % 100) + " " + std::to_string(i / 100) + "c.5 0 0 .5 .3 .3z";
  document += "'/></svg>";
  measure(state, [&] { benchmark::DoNotOptimize(parse_svg(document, "a.svg")); });
}

// Flattening of a 300 mm patch, including its process.
void BM_wrap(benchmark::State& state) {
  std::vector<Vector2d> circle;
  for (int i = 0; i <= 200; ++i)
    circle.push_back(Vector2d(0.60, 0.0) + 0.15 * Vector2d(std::cos(0.01 * std::numbers::pi * i),
                                                           std::sin(0.01 * std::numbers::pi * i)));
  measure(state, [&] {
    benchmark::DoNotOptimize(Wrap(bowl, Vector2d(0.60, 0.0), {stroke_through(circle)}));
  });
}

// Strokes of 100 points each.
std::vector<PlacedStroke> flow_field(int count) {
  std::vector<PlacedStroke> strokes;
  for (int k = 0; k < count; ++k) {
    const Vector2d centre = Vector2d(0.6, 0.0) + 0.12 * std::sqrt(static_cast<double>(k) / count) *
                                                     Vector2d(std::cos(2.4 * k), std::sin(2.4 * k));
    std::vector<Vector2d> points;
    for (int i = 0; i < 100; ++i)
      points.push_back(centre + 0.004 * Vector2d(std::cos(0.063 * i), std::sin(0.126 * i)));
    strokes.push_back(stroke_through(points));
  }
  return strokes;
}

void BM_plan(benchmark::State& state) {
  const std::vector<PlacedStroke> strokes = flow_field(static_cast<int>(state.range(0)));
  measure(state, [&] { benchmark::DoNotOptimize(plan_tip_path(strokes, bowl)); });
}

// A million queries in order of time, as in the loop.
void BM_plan_at(benchmark::State& state) {
  const TipPath path = plan_tip_path(flow_field(1500), bowl);
  measure(state, [&] {
    constexpr int kCalls = 1000000;
    for (int i = 0; i < kCalls; ++i)
      benchmark::DoNotOptimize(path.at(path.duration() * i / kCalls));
  });
}

// CPU time of a row for the loop. Waiting for the disk is not counted.
void BM_append(benchmark::State& state) {
  RunLogHeader header;
  for (int j = 0; j < 7; ++j) header.joint_names.push_back("joint_" + std::to_string(j + 1));
  for (int k = 0; k < 9; ++k) header.torque_terms.push_back("term_" + std::to_string(k + 1));
  header.mode_names = {"free"};
  header.joint_lower = Eigen::VectorXd::Constant(7, -1.0);
  header.joint_upper = header.torque_limit = Eigen::VectorXd::Constant(7, 1.0);
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     ("impedraw_bench_" + std::to_string(getpid()) + ".h5");
  const auto this_thread_seconds = [] {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  };
  for (auto _ : state) {
    RunLog log(file, header);
    LogRow row(7);
    const double before = this_thread_seconds();
    for (int i = 0; i < 16000; ++i) {
      row.time = 1e-3 * i;
      log.append(row);
    }
    state.SetIterationTime(this_thread_seconds() - before);
    log.close();
  }
  std::filesystem::remove(file);
}

#define IMPEDRAW_COST(name) \
  BENCHMARK(name)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(1)->Repetitions(3)
IMPEDRAW_COST(BM_sort)->Repetitions(9);
IMPEDRAW_COST(BM_mesh);
IMPEDRAW_COST(BM_metrics);
IMPEDRAW_COST(BM_order)->Arg(5000)->Arg(20000);
IMPEDRAW_COST(BM_soup)->Arg(50000)->Arg(200000)->Repetitions(8);
IMPEDRAW_COST(BM_svg);
IMPEDRAW_COST(BM_wrap);
IMPEDRAW_COST(BM_plan)->Arg(1500)->Arg(6000);
IMPEDRAW_COST(BM_plan_at);
IMPEDRAW_COST(BM_append);
#undef IMPEDRAW_COST

}  // namespace
}  // namespace impedraw
