#include "impedraw/perception/normals.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <thread>
#include <unordered_set>
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

constexpr int kBlended = 12;  // points whose levels are averaged
// A finer level must better the error of the normal to this share, where it is above kGood [rad].
constexpr double kClearlyBetter = 0.7;
constexpr double kGood = 3e-3;
// The finest level has fewer neighbours: this share of k, but not below kFewest.
constexpr double kFinestShare = 0.4;
constexpr int kFewest = 16;
// A plan: the heights between which it leaves the widest patches for finer ones [m].
constexpr double kLeastOff = 5e-4, kMostOff = 1.5e-3;
// A step of the surface: half of it on either side leaves a plane fit a residual of 0.26 times the
// step, however small the patch is. So the finest patch has a residual above kStep [m], which
// noise, as wide as at the other points, does not explain (kAboveNoise), and which a wider patch
// does not exceed by far (kSameAtAnyScale). The plan keeps kStepMargin off it [m].
constexpr double kStep = 1.6e-4, kAboveNoise = 5.0, kSameAtAnyScale = 0.6, kStepMargin = 4e-3;
// A hole: no point within kHole, and none as near as kSparse times the points' spacing, which
// beside a hole looks twice as wide: it is found from about 3.5 mm inside. A plan looks for holes
// every kHoleStep in the tangent planes of the cloud's points, as far as kHoleReach; for larger
// ones also around each place that it asks about. It keeps kHoleMargin off such places, if they
// are within kHoleLevel of the surface's tangent plane, so that a pen with a tip of 1 mm stays on
// the surface [m].
constexpr double kHole = 2e-3, kSparse = 1.6, kHoleMargin = 5e-3;
constexpr double kHoleStep = 0.7e-3, kHoleReach = 6e-3, kHoleLevel = 1.5e-3;
constexpr int kLooks = 8;  // around
// A crease: the normals of two places on either side of it, as the finest patches tell them, lean
// towards each other by more than kCreaseAngle [rad]. They are so far apart that each patch lies on
// its own side. Where their planes meet, a patch leaves a residual above kCreaseResidual [m]: in a
// round valley it follows the bend. The plan keeps kCreaseMargin off that place [m].
constexpr double kCreaseAngle = 60.0 * std::numbers::pi / 180.0, kCreaseResidual = 1e-4;
constexpr double kCreaseNear = 6e-3, kCreaseFar = 9.5e-3, kCreaseMargin = 3.5e-3;
// A plan: a fitted surface whose nearest point is further off than this many times the points'
// spacing runs on beyond them.
constexpr double kBeyondPoints = 1.5, kOnSurface = 1e-3;  // [1], [m]
// A plan's patch that leaves a residual above kTwoSheets may lie over a step or a crease: it is
// fitted again with less weight for points further off than kOtherSheet, which is approached from
// above in kSheetFits fits [m]. Noise asks for more, in multiples of the cloud's median residual.
constexpr double kTwoSheets = 5e-4, kOtherSheet = 1e-3, kOfNoise = 5.0;
constexpr int kSheetFits = 5;
constexpr int kAround = 40;

// Calls work(begin, end) for both halves of 0 … n at once.
template <class Work>
void in_halves(int n, const Work& work) {
  std::thread other(work, 0, n / 2);
  work(n / 2, n);
  other.join();
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

  // A finer cloud of the same view.
  struct View {
    PointCloud cloud;
    NeighbourTree tree;
    View(PointCloud given, const NormalSettings& s)
        : cloud(in_tree_order(std::move(given), s)), tree(cloud.points) {}
  };
  struct Finer {
    std::shared_ptr<const View> view;
    int k;
    std::vector<double> reach2;
  };
  std::vector<Finer> finer;  // empty where no place needs one
  std::shared_ptr<const View> finest;
  // Of each point of `cloud`: the level to use, 0 for the cloud itself, and the greatest nearby.
  std::vector<float> level, level_nearby;
  std::vector<Roughness> rough;
  std::vector<char> steps;      // the surface steps there, or within kStepMargin
  std::vector<char> creases;    // of a plan: within kCreaseMargin of a crease; empty: none is known
  std::vector<Vector3d> holes;  // of a plan [m]
  std::unique_ptr<const NeighbourTree> hole_tree;  // null: there are none
  double noise = 0.0;                              // median residual of the finest patches [m]
  bool planning = false;     // answers for a plan: see the constructor from another estimator
  double most_misfit = 0.0;  // of a plan [m]

  Index(PointCloud given, const NormalSettings& s, FinerClouds finer_clouds)
      : settings(s), cloud(in_tree_order(std::move(given), s)), tree(cloud.points) {
    fit_every_point();
    if (settings.mode != NormalMode::fresh || finer_clouds.empty()) return;
    for (PointCloud& c : finer_clouds)
      if (static_cast<int>(c.points.size()) > settings.k)
        finer.push_back({std::make_shared<const View>(std::move(c), s), settings.k, {}});
    if (finer.empty()) return;
    finest = finer.back().view;
    const int fewest = std::max(kFewest, static_cast<int>(kFinestShare * settings.k));
    if (fewest < settings.k) finer.push_back({finer.back().view, fewest, {}});
    choose_levels();
  }

  // The same clouds and levels with another edge test.
  Index(const Index& seen, double max_one_sidedness, double misfit)
      : settings(seen.settings),
        cloud(seen.cloud),
        tree(cloud.points),
        finer(seen.finer),
        finest(seen.finest),
        level(seen.level),
        level_nearby(seen.level_nearby),
        rough(seen.rough),
        steps(seen.steps),
        noise(seen.noise),
        planning(true),
        most_misfit(misfit) {
    settings.max_one_sidedness = max_one_sidedness;
    fit_every_point();
    if (!finer.empty()) find_creases(seen);
    if (finest) find_holes();
  }

  void find_holes() {
    const int n = static_cast<int>(cloud.points.size());
    std::vector<Vector3d> more;
    in_halves(n, [&](int begin, int end) {
      std::unordered_set<std::uint64_t> looked;
      looked.reserve(64 * static_cast<std::size_t>(end - begin));
      for (int i = begin; i < end; ++i) find_holes_about(i, &looked, begin == 0 ? &holes : &more);
    });
    holes.insert(holes.end(), more.begin(), more.end());
    if (!holes.empty()) hole_tree = std::make_unique<const NeighbourTree>(holes);
  }

  // In the tangent plane of the plan's surface at point i, but for cubes that were `looked` into.
  void find_holes_about(int i, std::unordered_set<std::uint64_t>* looked,
                        std::vector<Vector3d>* found) const {
    Neighbours near;
    near.n =
        tree.nearest(cloud.points[i], settings.k, settings.max_radius, near.index, near.squared);
    near.closest = i;
    LocalSurface surface;
    if (fit(cloud, cloud.points[i], settings.k, near, surface, true) == SurfaceStatus::too_few)
      return;
    const Vector3d foot = cloud.points[i] - surface.distance * surface.n;
    constexpr int kSteps = static_cast<int>(kHoleReach / kHoleStep);
    const Vector3d a = kHoleStep * surface.n.unitOrthogonal(), b = surface.n.cross(a);
    for (int u = -kSteps; u <= kSteps; ++u)
      for (int v = -kSteps; v <= kSteps; ++v) {
        if (u * u + v * v > kSteps * kSteps) continue;
        const Vector3d place = foot + u * a + v * b;
        if (looked->insert(cube_of(place)).second && is_hole(place)) found->push_back(place);
      }
  }

  // Cubes of side kHoleStep, numbered within ± 700 m.
  static std::uint64_t cube_of(const Vector3d& p) {
    std::uint64_t number = 0;
    for (int k = 0; k < 3; ++k)
      number =
          number << 21 | (static_cast<std::uint64_t>(std::llround(p[k] / kHoleStep)) & 0x1fffff);
    return number;
  }

  // No point of the finest view is as near as the points around are to each other. kAround of them
  // make the spacing that of the surroundings, also where grazing cameras see lines that are wide
  // apart.
  bool is_hole(const Vector3d& place) const {
    int index[kAround];
    double squared[kAround];
    if (finest->tree.nearest(place, 1, kHole, index, squared) == 1) return false;
    if (finest->tree.nearest(place, kAround, settings.max_radius, index, squared) < kAround)
      return true;
    // of kAround points evenly within their radius
    const double spacing = std::sqrt(std::numbers::pi * squared[kAround - 1] / kAround);
    return squared[0] > kSparse * kSparse * spacing * spacing;
  }

  void find_creases(const Index& seen) {
    const int n = static_cast<int>(cloud.points.size());
    std::vector<SurfaceEstimate> at(n);
    const auto estimate = [&](int begin, int end) {
      for (int i = begin; i < end; ++i) at[i] = seen.fresh(cloud.points[i]);
    };
    in_halves(n, estimate);
    creases.assign(n, 0);
    int index[kMostNeighbours];
    double squared[kMostNeighbours];
    for (int i = 0; i < n; ++i) {
      if (at[i].status != SurfaceStatus::ok || level_nearby[i] == 0.0f) continue;
      const int found = tree.nearest(cloud.points[i], kMostNeighbours, kCreaseFar, index, squared);
      for (int k = 0; k < found; ++k) {
        const int j = index[k];
        if (j < i || at[j].status != SurfaceStatus::ok) continue;
        const Vector3d half = 0.5 * (cloud.points[j] - cloud.points[i]);
        const Vector3d &a = at[i].n_W, &b = at[j].n_W;
        const double cosine = a.dot(b);
        const bool apart = squared[k] > kCreaseNear * kCreaseNear;
        if (!apart || cosine > std::cos(kCreaseAngle) || (b - a).dot(half) > 0.0 || cosine < -0.9)
          continue;
        // From the middle between them onto the line where their planes meet.
        const double to_a = -a.dot(half), to_b = b.dot(half), det = 1.0 - cosine * cosine;
        const Vector3d line = cloud.points[i] + half + (to_a - cosine * to_b) / det * a +
                              (to_b - cosine * to_a) / det * b;
        int about[kMostNeighbours];
        double off[kMostNeighbours];
        const int m = tree.nearest(line, kMostNeighbours, kCreaseMargin, about, off);
        if (m == 0) continue;
        const Roughness& there = rough[about[0]];  // no radius: points on both sides are no surface
        if (there.radius > 0.0 && there.residual < kCreaseResidual) continue;
        for (int l = 0; l < m; ++l) creases[about[l]] = 1;
      }
    }
  }

  // One fit at p, and what it tells about the surface there.
  struct Trial {
    bool ok = false;
    double residual = 0.0, radius = 0.0, weight = 1.0;
    int k = 1;
  };
  Trial try_fit(const PointCloud& c, const NeighbourTree& t, int k, const Vector3d& p) const {
    Neighbours found;
    found.n = t.nearest(p, k, settings.max_radius, found.index, found.squared);
    if (found.n < k) return {};
    found.closest = found.index[0];
    LocalSurface surface;
    if (fit(c, p, k, found, surface) != SurfaceStatus::ok) return {};
    // The fit takes degrees of freedom out of the residual; the weights leave about half of k.
    const double freedom = settings.fit == SurfaceFit::quadric ? 6.0 : 3.0;
    const double residual =
        surface.residual * std::sqrt(0.5 * k / std::max(1.0, 0.5 * k - freedom));
    Trial trial{true, residual, std::sqrt(found.squared[k - 1]), 0.0, k};
    for (int i = 0; i < k; ++i) trial.weight += c.weight[found.index[i]] / k;
    return trial;
  }

  void choose_levels() {
    const int n = static_cast<int>(cloud.points.size());
    std::vector<float> best(n, 0.0f);
    std::vector<Residuals> residuals(n);
    rough.assign(n, {});
    const auto choose = [&](int begin, int end) {
      for (int i = begin; i < end; ++i) best[i] = choose_level(i, &residuals[i]);
    };
    in_halves(n, choose);
    find_steps(residuals);
    // Isolated points do not count; what remains is spread and smoothed.
    level.assign(n, 0.0f);
    level_nearby.assign(n, 0.0f);
    if (*std::max_element(best.begin(), best.end()) == 0.0f) return finer.clear();
    const auto over_neighbours = [&](int count, auto&& take) {
      int index[kMostNeighbours];
      double squared[kMostNeighbours];
      for (int i = 0; i < n; ++i)
        take(i, index, tree.nearest(cloud.points[i], count, settings.max_radius, index, squared));
    };
    std::vector<float> median(n, 0.0f);
    over_neighbours(kBlended, [&](int i, const int* index, int found) {
      float values[kBlended];
      for (int j = 0; j < found; ++j) values[j] = best[index[j]];
      std::nth_element(values, values + found / 2, values + found);
      median[i] = found > 0 ? values[found / 2] : 0.0f;
    });
    over_neighbours(kBlended, [&](int i, const int* index, int found) {
      for (int j = 0; j < found; ++j) level[i] += median[index[j]] / static_cast<float>(found);
    });
    over_neighbours(2 * kBlended, [&](int i, const int* index, int found) {
      for (int j = 0; j < found; ++j) level_nearby[i] = std::max(level_nearby[i], level[index[j]]);
    });
    if (*std::max_element(level.begin(), level.end()) == 0.0f) return finer.clear();
    for (Finer& f : finer) {
      const std::vector<Vector3d>& points = f.view->cloud.points;
      f.reach2.resize(points.size());
      const auto measure = [&](int begin, int end) {
        int index[kMostNeighbours];
        double squared[kMostNeighbours];
        for (int i = begin; i < end; ++i) {
          const int found =
              f.view->tree.nearest(points[i], f.k, settings.max_radius, index, squared);
          f.reach2[i] =
              found == f.k ? squared[found - 1] : settings.max_radius * settings.max_radius;
        }
      };
      in_halves(static_cast<int>(points.size()), measure);
    }
  }

  // Of the widest and the finest patch at a point [m].
  struct Residuals {
    double widest = 0.0, finest = 0.0;
  };

  void find_steps(const std::vector<Residuals>& residuals) {
    const int n = static_cast<int>(cloud.points.size());
    std::vector<double> finest;
    for (const Residuals& r : residuals) finest.push_back(r.finest);
    std::nth_element(finest.begin(), finest.begin() + n / 2, finest.end());
    noise = finest[n / 2];
    const double least = std::max(kStep, kAboveNoise * noise);
    steps.assign(n, 0);
    for (int i = 0; i < n; ++i) {
      const Residuals& r = residuals[i];
      if (r.finest < least || r.finest < kSameAtAnyScale * r.widest) continue;
      int index[kMostNeighbours];
      double squared[kMostNeighbours];
      const int found = tree.nearest(cloud.points[i], kMostNeighbours, kStepMargin, index, squared);
      for (int j = 0; j < found; ++j) steps[index[j]] = 1;
    }
  }

  // Also fills rough[i] and *residuals.
  float choose_level(int i, Residuals* residuals) {
    const Vector3d& p = cloud.points[i];
    std::vector<Trial> trials{try_fit(cloud, tree, settings.k, p)};
    if (!trials[0].ok) return 0.0f;
    *residuals = {trials[0].residual, trials[0].residual};
    rough[i] = {trials[0].residual, trials[0].radius, 0.0,
                2.0 * trials[0].residual / trials[0].radius};
    if (trials[0].residual < kGood / 2.0 * trials[0].radius) return 0.0f;
    for (const Finer& f : finer) trials.push_back(try_fit(f.view->cloud, f.view->tree, f.k, p));
    while (!trials.back().ok) trials.pop_back();
    const Trial& finest = trials.back();
    residuals->finest = finest.residual;
    const auto noise_of = [&](const Trial& t) {
      return finest.residual * std::sqrt(finest.weight / t.weight);
    };
    const auto misfit_of = [&](const Trial& t) {
      const double s = 1.1 * noise_of(t);
      return std::sqrt(std::max(0.0, t.residual * t.residual - s * s));
    };
    // of the normal [rad]
    const auto error_of = [&](const Trial& t) {
      return 4.0 * noise_of(t) / (std::sqrt(t.k) * t.radius) + 2.0 * misfit_of(t) / t.radius;
    };
    std::size_t chosen = 0;
    for (std::size_t l = 1; l < trials.size(); ++l) {
      const double now = error_of(trials[chosen]);
      if (trials[l].ok && now > kGood && error_of(trials[l]) < kClearlyBetter * now) chosen = l;
    }
    const Trial& used = trials[chosen];
    double misfit = misfit_of(used), slope = error_of(used);
    if (chosen + 1 == trials.size() && chosen > 0 && trials[chosen - 1].ok) {
      // At the finest level noise and misfit cannot be told apart by the residual alone; but misfit
      // grows with the patch, its square with about the cube of the radius.
      const Trial& wider = trials[chosen - 1];
      const double growth = std::pow(wider.radius / used.radius, 3.0) - 1.0;
      const double more = wider.residual * wider.residual - used.residual * used.residual;
      if (growth > 0.0 && more > 0.0) misfit = std::min(used.residual, std::sqrt(more / growth));
      slope += 2.0 * misfit / used.radius;
    }
    rough[i] = {used.residual, used.radius, misfit, slope};
    return static_cast<float>(chosen);
  }

  static PointCloud in_tree_order(PointCloud cloud, const NormalSettings& s) {
    validate(cloud, s);
    PointCloud ordered;
    ordered.eyes = cloud.eyes;
    for (const int i : tree_order(cloud.points)) {
      ordered.points.push_back(cloud.points[i]);
      ordered.weight.push_back(cloud.weight.empty() ? 1.0 : cloud.weight[i]);
      ordered.camera.push_back(cloud.camera[i]);
      if (!cloud.rgb.empty())
        ordered.rgb.insert(ordered.rgb.end(), &cloud.rgb[3 * i], &cloud.rgb[3 * i] + 3);
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
        known[i].status = fit(cloud, p, settings.k, found, surface);
        if (known[i].status != SurfaceStatus::ok) continue;
        cloud.normals[i] = surface.n;
        known[i] = {SurfaceStatus::ok, surface.n, p - surface.distance * surface.n, surface.bend};
      }
    };
    in_halves(n, fit_range);
  }

  SurfaceEstimate fresh(const Vector3d& p) const {
    Neighbours found;
    found.n = tree.nearest_unordered(p, settings.k, settings.max_radius, reach2, found.index,
                                     found.squared, &found.closest);
    LocalSurface surface;
    const SurfaceStatus status = fit(cloud, p, settings.k, found, surface, planning && finest);
    if (status != SurfaceStatus::ok) return {.status = status};
    if (planning && std::abs(surface.distance) < kOnSurface && runs_on_beyond(p, found))
      return {.status = SurfaceStatus::off_edge};
    const SurfaceEstimate coarse{status, surface.n, surface.distance};
    if (planning) return planned(p, coarse, found.closest);
    if (finer.empty() || found.closest < 0 || level_nearby[found.closest] == 0.0f) return coarse;
    return refined(p, coarse);
  }

  bool runs_on_beyond(const Vector3d& p, const Neighbours& found) const {
    const double spacing2 = std::numbers::pi * found.squared[found.n - 1] / found.n;
    return (cloud.points[found.closest] - p).squaredNorm() >
           kBeyondPoints * kBeyondPoints * spacing2;
  }

  // A plan follows the surface as the widest patches see it, which is smooth; where that is off by
  // more than the pen's approach allows for, as the finer ones see it. It keeps off holes, off
  // steps that no patch resolves, and off creases.
  SurfaceEstimate planned(const Vector3d& p, const SurfaceEstimate& coarse, int closest) const {
    if (finest && closest >= 0 &&
        (steps[closest] || rough[closest].misfit > Roughness::kStepMisfit ||
         rough[closest].rougher_than(most_misfit)))
      return {.status = SurfaceStatus::off_edge};
    if (closest >= 0 && !creases.empty() && creases[closest])
      return {.status = SurfaceStatus::off_edge};
    if (beside_hole(p - coarse.distance * coarse.n_W, coarse.n_W))
      return {.status = SurfaceStatus::off_edge};
    if (finer.empty() || closest < 0 || level_nearby[closest] == 0.0f) return coarse;
    const SurfaceEstimate fine = refined(p, coarse);
    const double off = std::abs(fine.distance - coarse.distance);
    const double share = std::clamp((off - kLeastOff) / (kMostOff - kLeastOff), 0.0, 1.0);
    if (share == 0.0) return coarse;
    return {SurfaceStatus::ok, ((1.0 - share) * coarse.n_W + share * fine.n_W).normalized(),
            (1.0 - share) * coarse.distance + share * fine.distance};
  }

  // A hole further off the tangent plane may lie in the body, under an upper sheet.
  bool beside_hole(const Vector3d& foot, const Vector3d& n) const {
    if (!finest) return false;
    if (hole_tree) {
      int index[kMostNeighbours];
      double squared[kMostNeighbours];
      const int found = hole_tree->nearest(foot, kMostNeighbours, kHoleMargin, index, squared);
      if (std::any_of(index, index + found,
                      [&](int j) { return std::abs(n.dot(holes[j] - foot)) < kHoleLevel; }))
        return true;
    }
    const Vector3d a = kHoleMargin * n.unitOrthogonal(), b = n.cross(a);
    for (int look = 0; look < kLooks; ++look) {
      const double angle = 2.0 * std::numbers::pi * look / kLooks;
      if (is_hole(foot + std::cos(angle) * a + std::sin(angle) * b)) return true;
    }
    return is_hole(foot);
  }

  // The mean of the levels of p's neighbours; negative: it has too few.
  double level_at(const Vector3d& p) const {
    int index[kBlended + 1];
    double squared[kBlended + 1];
    const int found = tree.nearest(p, kBlended + 1, settings.max_radius, index, squared);
    if (found <= kBlended || !(squared[kBlended] > 0.0)) return -1.0;
    double sum = 0.0, at = 0.0;
    for (int i = 0; i < kBlended; ++i) {
      const double fade = 1.0 - squared[i] / squared[kBlended], w = fade * fade;
      sum += w;
      at += w * level[index[i]];
    }
    return at / sum;
  }

  // Blends the two estimates next to the level at p.
  SurfaceEstimate refined(const Vector3d& p, const SurfaceEstimate& coarse) const {
    const double at = level_at(p);
    if (at < 0.0) return coarse;
    const int below = std::min(static_cast<int>(at), static_cast<int>(finer.size()));
    const double share = at - below;
    const SurfaceEstimate low = below == 0 ? coarse : at_level(below - 1, p);
    if (low.status != SurfaceStatus::ok) return coarse;
    if (share < 1e-3 || below == static_cast<int>(finer.size())) return low;
    const SurfaceEstimate high = at_level(below, p);
    if (high.status != SurfaceStatus::ok) return low;
    return {SurfaceStatus::ok, ((1.0 - share) * low.n_W + share * high.n_W).normalized(),
            (1.0 - share) * low.distance + share * high.distance};
  }

  SurfaceEstimate at_level(int l, const Vector3d& p) const {
    const Finer& f = finer[static_cast<std::size_t>(l)];
    Neighbours found;
    found.n = f.view->tree.nearest_unordered(p, f.k, settings.max_radius, f.reach2, found.index,
                                             found.squared, &found.closest);
    LocalSurface surface;
    const SurfaceStatus status = fit(f.view->cloud, p, f.k, found, surface);
    if (status != SurfaceStatus::ok) return {.status = status};
    return {status, surface.n, surface.distance};
  }

  SurfaceStatus fit(const PointCloud& cloud, const Vector3d& p, int k, const Neighbours& found,
                    LocalSurface& surface, bool one_sheet = false) const {
    if (found.n < k || !(found.squared[k - 1] > 0.0)) return SurfaceStatus::too_few;
    Neighbourhood around;
    around.n = k;
    const double furthest2 = found.squared[k - 1];
    for (int i = 0; i < k; ++i) {
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
    const Vector3d towards = eye - cloud.points[found.closest];
    surface = fit_surface(around, settings.fit, towards);
    if (one_sheet && surface.is_surface &&
        surface.residual > std::max(kTwoSheets, kOfNoise * noise))
      fit_one_sheet(towards, &around, &surface);
    if (!surface.is_surface) return SurfaceStatus::too_few;
    return surface.one_sidedness > settings.max_one_sidedness ? SurfaceStatus::off_edge
                                                              : SurfaceStatus::ok;
  }

  // Least squares with redescending weights w / (1 + (r/c)²)² for points off by r, c falling to
  // kOtherSheet: ends on the sheet that most of the weight lies on, which is the query's.
  void fit_one_sheet(const Vector3d& towards, Neighbourhood* around, LocalSurface* surface) const {
    double weight[kMostNeighbours], off[kMostNeighbours];
    std::copy(around->w, around->w + around->n, weight);
    for (int pass = 1; pass <= kSheetFits && surface->is_surface; ++pass) {
      double most = 0.0;
      for (int i = 0; i < around->n; ++i) {
        const Vector3d d =
            Vector3d(around->x[i], around->y[i], around->z[i]) + surface->distance * surface->n;
        off[i] = surface->n.dot(d) + 0.5 * d.dot(surface->bend * d);
        most = std::max(most, std::abs(off[i]));
      }
      const double c = std::max({kOtherSheet, kOfNoise * noise, std::ldexp(most, -pass)});
      for (int i = 0; i < around->n; ++i) {
        const double beyond = 1.0 + (off[i] / c) * (off[i] / c);
        around->w[i] = weight[i] / (beyond * beyond);
      }
      *surface = fit_surface(*around, settings.fit, towards);
    }
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

SurfaceEstimator::SurfaceEstimator(PointCloud cloud, const NormalSettings& settings,
                                   FinerClouds finer)
    : index_(std::make_unique<Index>(std::move(cloud), settings, std::move(finer))) {}
SurfaceEstimator::SurfaceEstimator(const SurfaceEstimator& seen, double max_one_sidedness,
                                   double most_misfit)
    : index_(std::make_unique<Index>(*seen.index_, max_one_sidedness, most_misfit)) {}
SurfaceEstimator::~SurfaceEstimator() = default;
SurfaceEstimator::SurfaceEstimator(SurfaceEstimator&&) noexcept = default;
SurfaceEstimator& SurfaceEstimator::operator=(SurfaceEstimator&&) noexcept = default;

SurfaceEstimate SurfaceEstimator::estimate(const Vector3d& p_W) const noexcept {
  if (!p_W.allFinite()) return {.status = SurfaceStatus::too_few};
  return index_->settings.mode == NormalMode::fresh ? index_->fresh(p_W)
                                                    : index_->interpolated(p_W);
}

double SurfaceEstimator::finer_share(const Vector3d& p_W) const noexcept {
  if (index_->finer.empty() || !p_W.allFinite()) return 0.0;
  return std::clamp(index_->level_at(p_W), 0.0, 1.0);
}

Roughness SurfaceEstimator::roughness(const Vector3d& p_W) const noexcept {
  int nearest = 0;
  double squared = 0.0;
  if (index_->rough.empty() || !p_W.allFinite() ||
      index_->tree.nearest(p_W, 1, index_->settings.max_radius, &nearest, &squared) < 1)
    return {};
  return index_->rough[nearest];
}

bool SurfaceEstimator::in_crease(const Vector3d& p_W) const noexcept {
  int nearest = 0;
  double squared = 0.0;
  return !index_->creases.empty() && p_W.allFinite() &&
         index_->tree.nearest(p_W, 1, index_->settings.max_radius, &nearest, &squared) == 1 &&
         index_->creases[nearest];
}

const PointCloud& SurfaceEstimator::cloud() const noexcept { return index_->cloud; }

}  // namespace impedraw
