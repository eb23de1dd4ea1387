#include "impedraw/perception/normals.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/perception/neighbours.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr int kInterpolated = 10;  // precomputed normals per query
// the one-sidedness of so few points scatters: 0.4 within the cloud, 0.6 ± 0.1 on its edge
constexpr double kInterpolatedEdge = 0.8;

void validate(const PointCloud& cloud, const NormalSettings& s) {
  using Limits = NormalSettings::Limits;
  require_in_range("normals", Limits::k, s.k);
  require_in_range("normals", Limits::max_radius, s.max_radius);
  require_in_range("normals", Limits::max_one_sidedness, s.max_one_sidedness);
  if (cloud.points.empty()) {
    throw InputError(
        "normals: the cloud has no points: check that the cameras see the canvas and that the "
        "region contains it");
  }
  if (cloud.camera.size() != cloud.points.size()) {
    throw InputError(fmt::format("normals: the cloud has {} points and {} camera indices",
                                 cloud.points.size(), cloud.camera.size()));
  }
  if (!cloud.weight.empty() && cloud.weight.size() != cloud.points.size()) {
    throw InputError(fmt::format("normals: the cloud has {} points and {} weights",
                                 cloud.points.size(), cloud.weight.size()));
  }
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!cloud.points[i].allFinite())
      throw InputError(fmt::format("normals: point {} of the cloud is not finite", i));
    if (!cloud.weight.empty() && !(cloud.weight[i] > 0.0)) {
      throw InputError(
          fmt::format("normals: point {} of the cloud has weight {}, must be greater than 0", i,
                      cloud.weight[i]));
    }
    if (cloud.camera[i] < 0 || cloud.camera[i] >= static_cast<int>(cloud.eyes.size())) {
      throw InputError(fmt::format("normals: point {} of the cloud names camera {}, it has {}", i,
                                   cloud.camera[i], cloud.eyes.size()));
    }
  }
}

// N(p); the last point is the furthest.
struct Neighbours {
  int n;
  int closest;
  int index[kMostNeighbours];
  double squared[kMostNeighbours];
};

}  // namespace

struct SurfaceEstimator::Index {
  NormalSettings settings;
  PointCloud cloud;
  NeighbourTree tree;
  std::vector<double>
      reach2;  // of each point: squared distance to its k-th neighbour, or to max_radius [m²]

  struct Known {  // surface fitted at a point of the cloud
    SurfaceStatus status = SurfaceStatus::none;
    Vector3d n;
    Vector3d foot;         // projection of the point onto that surface [m]: removes its noise
    Eigen::Matrix3d bend;  // dn/dp [1/m]
  };
  std::vector<Known> known;

  Index(PointCloud given, const NormalSettings& s)
      : settings(s), cloud(in_tree_order(std::move(given), s)), tree(cloud.points) {
    fit_every_point();
  }

  static PointCloud in_tree_order(PointCloud cloud, const NormalSettings& s) {
    validate(cloud, s);
    PointCloud ordered;
    ordered.eyes = cloud.eyes;
    for (const int i : tree_order(cloud.points)) {
      ordered.points.push_back(cloud.points[i]);
      ordered.weight.push_back(cloud.weight.empty() ? 1.0 : cloud.weight[i]);
      ordered.camera.push_back(cloud.camera[i]);
    }
    return ordered;
  }

  void fit_every_point() {
    const int n = static_cast<int>(cloud.points.size());
    cloud.normals.assign(n, Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    known.resize(n);
    reach2.resize(n);
    const auto fit_range = [this](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const Vector3d& p = cloud.points[i];
        Neighbours found;
        found.n = tree.nearest(p, settings.k, settings.max_radius, found.index, found.squared);
        found.closest = i;
        reach2[i] = found.n == settings.k ? found.squared[settings.k - 1]
                                          : settings.max_radius * settings.max_radius;
        LocalSurface surface;
        known[i].status = fit(p, found, surface);
        if (known[i].status != SurfaceStatus::ok) continue;
        cloud.normals[i] = surface.n;
        known[i] = {SurfaceStatus::ok, surface.n, p - surface.distance * surface.n, surface.bend};
      }
    };
    std::thread other(fit_range, 0, n / 2);
    fit_range(n / 2, n);
    other.join();
  }

  SurfaceEstimate fresh(const Vector3d& p) const {
    Neighbours found;
    found.n = tree.nearest_unordered(p, settings.k, settings.max_radius, reach2, found.index,
                                     found.squared, &found.closest);
    LocalSurface surface;
    const SurfaceStatus status = fit(p, found, surface);
    if (status != SurfaceStatus::ok) return {.status = status};
    return {status, surface.n, surface.distance};
  }

  SurfaceStatus fit(const Vector3d& p, const Neighbours& found, LocalSurface& surface) const {
    if (found.n < settings.k || !(found.squared[settings.k - 1] > 0.0))
      return SurfaceStatus::too_few;
    Neighbourhood around;
    around.n = settings.k;
    const double furthest2 = found.squared[settings.k - 1];
    for (int i = 0; i < settings.k; ++i) {
      const Vector3d& q = cloud.points[found.index[i]];
      around.x[i] = q.x() - p.x();
      around.y[i] = q.y() - p.y();
      around.z[i] = q.z() - p.z();
      const double fade = 1.0 - found.squared[i] / furthest2;
      around.w[i] = settings.weighting == NeighbourWeighting::smooth
                        ? cloud.weight[found.index[i]] * fade * fade
                        : 1.0;
    }
    const Vector3d& eye = cloud.eyes[cloud.camera[found.closest]];
    surface = fit_surface(around, settings.fit, eye - cloud.points[found.closest]);
    if (!surface.is_surface) return SurfaceStatus::too_few;
    return surface.one_sidedness > settings.max_one_sidedness ? SurfaceStatus::off_edge
                                                              : SurfaceStatus::ok;
  }

  // Each neighbour i has a surface point f_i, its normal n_i and the derivative bend_i. It predicts
  // the normal n_i + bend_i (p − f_i) at p. n is the average of these predictions. Between f_i and
  // the query's foot the normal changes from n_i to n. The rise of a parabola follows the mean of
  // both slopes, so the distance is (n_i + n)/|n_i + n| · (p − f_i), exact to second order.
  SurfaceEstimate interpolated(const Vector3d& p) const {
    int index[kInterpolated + 1];
    double squared[kInterpolated + 1];
    const int found = tree.nearest(p, kInterpolated + 1, settings.max_radius, index, squared);
    if (found <= kInterpolated || !(squared[kInterpolated] > 0.0))
      return {.status = SurfaceStatus::too_few};
    double weight[kInterpolated];
    double sum = 0.0;
    double lost = 0.0;
    Vector3d n = Vector3d::Zero();
    Vector3d mean = Vector3d::Zero();
    for (int i = 0; i < kInterpolated; ++i) {
      const Known& at = known[index[i]];
      const double fade = 1.0 - squared[i] / squared[kInterpolated];
      weight[i] = at.status == SurfaceStatus::ok ? fade * fade : 0.0;
      lost += fade * fade - weight[i];
      if (weight[i] == 0.0) continue;
      sum += weight[i];
      n += weight[i] * (at.n + at.bend * (p - at.foot));
      mean += weight[i] * (at.foot - p);
    }
    if (!(sum > lost) || !(n.norm() > 0.5 * sum)) {
      const SurfaceStatus nearest = known[index[0]].status;
      return {.status = nearest == SurfaceStatus::ok ? SurfaceStatus::too_few : nearest};
    }
    n.normalize();
    mean /= sum;
    double distance = 0.0;
    double spread = 0.0;
    for (int i = 0; i < kInterpolated; ++i) {
      if (weight[i] == 0.0) continue;
      const Vector3d from = p - known[index[i]].foot;
      distance += weight[i] * (known[index[i]].n + n).normalized().dot(from);
      spread += weight[i] * (from - n * n.dot(from)).squaredNorm();
    }
    const double offset = (mean - n * n.dot(mean)).norm();
    if (offset > kInterpolatedEdge * std::sqrt(spread / sum))
      return {.status = SurfaceStatus::off_edge};
    return {SurfaceStatus::ok, n, distance / sum};
  }
};

SurfaceEstimator::SurfaceEstimator(PointCloud cloud, const NormalSettings& settings)
    : index_(std::make_unique<Index>(std::move(cloud), settings)) {}
SurfaceEstimator::~SurfaceEstimator() = default;
SurfaceEstimator::SurfaceEstimator(SurfaceEstimator&&) noexcept = default;
SurfaceEstimator& SurfaceEstimator::operator=(SurfaceEstimator&&) noexcept = default;

SurfaceEstimate SurfaceEstimator::estimate(const Vector3d& p_W) const noexcept {
  if (!p_W.allFinite()) return {.status = SurfaceStatus::too_few};
  return index_->settings.mode == NormalMode::fresh ? index_->fresh(p_W)
                                                    : index_->interpolated(p_W);
}

const PointCloud& SurfaceEstimator::cloud() const noexcept { return index_->cloud; }

}  // namespace impedraw
