// Time of a normal relative to its floor, the bare k-nearest-neighbour query. Both use the same
// 50,000 points on the standard bowl, the same k and the same queries (along the sine, at the tip
// sphere's centre). Limit: BM_normal_fresh ≤ 1.5 × BM_knn_bare.
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <benchmark/benchmark.h>
#include <nanoflann.hpp>

#include "impedraw/perception/normals.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

const Vector3d kCentre(0.60, 0.0, 0.40);

PointCloud bowl_cloud() {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  PointCloud cloud;
  cloud.eyes.push_back({0.6, 0.0, 0.9});
  for (int i = 0; i < 50000; ++i) {
    const double phi = 2.0 * std::numbers::pi * uniform(random);
    const double cos_theta = 1.0 - 0.2 * uniform(random);  // uniform over the cap's area
    const double rho = std::sqrt(1.0 - cos_theta * cos_theta);
    cloud.points.push_back(kCentre +
                           0.30 * Vector3d(rho * std::cos(phi), rho * std::sin(phi), -cos_theta));
    cloud.camera.push_back(0);
  }
  return cloud;
}

std::vector<Vector3d> queries_along_sine() {
  std::vector<Vector3d> queries;
  for (int i = 0; i <= 6000; ++i) {
    const double y = -0.15 + 0.30 * i / 6000.0;
    const double x = 0.05 * std::sin(2.0 * std::numbers::pi * (y + 0.15) / 0.15);
    const Vector3d out = Vector3d(x, y, -std::sqrt(0.09 - x * x - y * y)).normalized();
    queries.push_back(kCentre + 0.299 * out);
  }
  return queries;
}

template <class Query>
void run(benchmark::State& state, const Query& query) {
  const std::vector<Vector3d> queries = queries_along_sine();
  std::size_t i = 0;
  for (auto _ : state) {
    query(queries[i]);
    if (++i == queries.size()) i = 0;
  }
}

// Plain use of nanoflann on the same points in the same order.
struct Points {
  std::vector<Vector3d> points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

void BM_knn_bare(benchmark::State& state) {
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>,
                                                   Points, 3, int>;
  const int k = static_cast<int>(state.range(0));
  const SurfaceEstimator estimator(bowl_cloud());
  const Points points{estimator.cloud().points};
  const Tree tree(3, points, {12});
  run(state, [&](const Vector3d& p) {
    int index[kMostNeighbours];
    double squared[kMostNeighbours];
    nanoflann::KNNResultSet<double, int, int> found(k);
    found.init(index, squared);
    benchmark::DoNotOptimize(tree.findNeighbors(found, p.data(), {}));
    benchmark::DoNotOptimize(index);
    benchmark::DoNotOptimize(squared);
  });
}

void BM_normal_fresh(benchmark::State& state) {
  NormalSettings settings;
  settings.k = static_cast<int>(state.range(0));
  const SurfaceEstimator estimator(bowl_cloud(), settings);
  run(state, [&](const Vector3d& p) { benchmark::DoNotOptimize(estimator.estimate(p)); });
}

BENCHMARK(BM_knn_bare)->Arg(30)->Arg(40)->Arg(60);
BENCHMARK(BM_normal_fresh)->Arg(30)->Arg(40)->Arg(60);

}  // namespace
}  // namespace impedraw
