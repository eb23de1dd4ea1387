#include "impedraw/perception/detail_levels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "impedraw/common/in_parallel.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr int kBlended = 12;  // points whose levels are averaged
constexpr int kShared = 8;    // points that share the reach of one
// A finer level must better the error of the normal to this share, where it is above kGood [rad].
constexpr double kClearlyBetter = 0.7;
constexpr double kGood = 3e-3;
// The finest level has fewer neighbours: this share of k, but not below kFewest.
constexpr double kFinestShare = 0.4;
constexpr int kFewest = 16;
// A step of the surface: half of it on either side leaves a plane fit a residual of 0.26 times the
// step, however small the patch is. So the finest patch has a residual above kStep [m], which
// noise, as wide as at the other points, does not explain (kAboveNoise), and which a wider patch
// does not exceed by far (kSameAtAnyScale). The plan keeps kStepMargin off it [m]. Where a wider
// patch does, as over rough ground, the residual is misfit of all places as near.
constexpr double kStep = 1.6e-4, kAboveNoise = 5.0, kSameAtAnyScale = 0.6, kStepMargin = 4e-3;

double mean_weight(const CloudPatches& patches, const Patch& patch) {
  double mean = 0.0;
  for (int i = 0; i < patch.k; ++i) mean += patches.cloud().weight[patch.index[i]] / patch.k;
  return mean;
}

}  // namespace

std::unique_ptr<const DetailLevels> DetailLevels::of(const CloudPatches& widest,
                                                     const std::vector<LocalSurface>& fits,
                                                     const std::vector<double>& reach2,
                                                     FinerClouds finer) {
  const NormalSettings& s = widest.settings();
  std::unique_ptr<DetailLevels> levels(new DetailLevels(widest));
  std::erase_if(finer, [&s](const PointCloud& cloud) {
    return static_cast<int>(cloud.points.size()) <= s.k;
  });
  levels->finer_.resize(finer.size());
  in_parallel(static_cast<int>(finer.size()), [&](int i) {
    levels->finer_[i] = {std::make_shared<const CloudPatches>(std::move(finer[i]), s), s.k, {}};
  });
  if (!levels->any()) return nullptr;
  levels->finest_ = levels->finer_.back().patches;
  for (const Vector3d& p : levels->finest_->cloud().points)
    levels->finest_cubes_.insert(cube_of(p, kCube));
  const int fewest = std::max(kFewest, static_cast<int>(kFinestShare * s.k));
  if (fewest < s.k) levels->finer_.push_back({levels->finest_, fewest, {}});
  levels->choose_levels(fits, reach2);
  return levels;
}

DetailLevels::Trial DetailLevels::trial_of(const LocalSurface& fit, int k, double radius2,
                                           const NormalSettings& s) {
  if (status_of(fit, s.max_one_sidedness) != SurfaceStatus::ok) return {};
  // The fit takes degrees of freedom out of the residual; the weights leave about half of k.
  const double freedom = s.fit == SurfaceFit::quadric ? 6.0 : 3.0;
  const double residual = fit.residual * std::sqrt(0.5 * k / std::max(1.0, 0.5 * k - freedom));
  return {true, residual, std::sqrt(radius2), 0.0, k};
}

DetailLevels::Trial DetailLevels::try_fit(const CloudPatches& patches, int k, const Vector3d& p,
                                          double guess2) {
  const Patch patch = patches.nearest(p, k, guess2);
  Trial trial = trial_of(patches.fit(p, patch), k, patch.squared[k - 1], patches.settings());
  if (!trial.ok) return {};
  trial.weight = mean_weight(patches, patch);
  return trial;
}

void DetailLevels::choose_levels(const std::vector<LocalSurface>& fits,
                                 const std::vector<double>& reach2) {
  const int n = widest_.size();
  std::vector<float> best(n, 0.0f);
  std::vector<Residuals> residuals(n);
  rough_.assign(n, {});
  in_halves(n, [&](int begin, int end) {
    for (int i = begin; i < end; ++i)
      best[i] = choose_level(
          i, trial_of(fits[i], widest_.settings().k, reach2[i], widest_.settings()), &residuals[i]);
  });
  find_steps(residuals);
  spread(best);
  if (*std::max_element(level_.begin(), level_.end()) == 0.0f) return finer_.clear();
  for (Level& level : finer_) {
    const std::vector<Vector3d>& points = level.patches->cloud().points;
    level.reach2.resize(points.size());
    // Elsewhere the level is not asked.
    const double most = widest_.settings().max_radius;
    in_halves(static_cast<int>(points.size()), [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        // It is a guess, and neighbours in the tree's order share it.
        if (i % kShared != 0 && i > begin) {
          level.reach2[i] = level.reach2[i - 1];
          continue;
        }
        const Patch near = widest_.nearest(points[i], kBlended);
        level.reach2[i] =
            std::any_of(near.index, near.index + near.n, [this](int j) { return used_near(j); })
                ? level.patches->nearest(points[i], level.k).reach2(widest_.settings())
                : most * most;
      }
    });
  }
}

// Isolated points do not count; what remains is spread and smoothed.
void DetailLevels::spread(const std::vector<float>& best) {
  const int n = widest_.size();
  level_.assign(n, 0.0f);
  level_nearby_.assign(n, 0.0f);
  if (*std::max_element(best.begin(), best.end()) == 0.0f) return;
  std::vector<float> median(n, 0.0f);
  std::vector<std::array<int, kBlended>> about(n);
  std::vector<int> found(n);
  for (int i = 0; i < n; ++i) {
    const Patch near = widest_.nearest(widest_.cloud().points[i], kBlended);
    found[i] = near.n;
    std::copy_n(near.index, near.n, about[i].begin());
    float values[kBlended];
    for (int j = 0; j < near.n; ++j) values[j] = best[near.index[j]];
    std::nth_element(values, values + near.n / 2, values + near.n);
    median[i] = near.n > 0 ? values[near.n / 2] : 0.0f;
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < found[i]; ++j)
      level_[i] += median[about[i][j]] / static_cast<float>(found[i]);
  for (int i = 0; i < n; ++i) {
    const Patch near = widest_.nearest(widest_.cloud().points[i], 2 * kBlended);
    for (int j = 0; j < near.n; ++j)
      level_nearby_[i] = std::max(level_nearby_[i], level_[near.index[j]]);
  }
}

void DetailLevels::find_steps(const std::vector<Residuals>& residuals) {
  const int n = widest_.size();
  std::vector<double> finest;
  for (const Residuals& r : residuals) finest.push_back(r.finest);
  std::nth_element(finest.begin(), finest.begin() + n / 2, finest.end());
  noise_ = finest[n / 2];
  const double least = std::max(kStep, kAboveNoise * noise_);
  steps_.assign(n, 0);
  std::vector<int> edge(n, -1);
  for (int i = 0; i < n; ++i) {
    const Residuals& r = residuals[i];
    if (r.finest < least) continue;
    int index[kMostNeighbours];
    double squared[kMostNeighbours];
    const int found = widest_.tree().nearest(widest_.cloud().points[i], kMostNeighbours,
                                             kStepMargin, index, squared);
    const bool steps = r.finest >= kSameAtAnyScale * r.widest;
    for (int j = 0; j < found; ++j) {
      int& worst = edge[index[j]];
      if (steps)
        steps_[index[j]] = 1;
      else if (worst < 0 || r.finest > residuals[worst].finest)
        worst = i;
    }
  }
  for (int i = 0; i < n; ++i) {
    if (edge[i] < 0 || rough_[i].rougher_than(residuals[edge[i]].finest)) continue;
    rough_[i].misfit = residuals[edge[i]].finest;
    rough_[i].radius = residuals[edge[i]].radius;
  }
}

// Also fills rough_[i] and *residuals.
float DetailLevels::choose_level(int i, const Trial& widest, Residuals* residuals) {
  if (!widest.ok) return 0.0f;
  *residuals = {widest.residual, widest.residual, widest.radius};
  rough_[i] = {widest.residual, widest.radius, 0.0, 2.0 * widest.residual / widest.radius};
  if (widest.residual < kGood / 2.0 * widest.radius) return 0.0f;
  const Vector3d& p = widest_.cloud().points[i];
  std::vector<Trial> trials{widest};
  trials[0].weight = mean_weight(widest_, widest_.nearest(p, widest.k));
  const double per_point = widest.radius * widest.radius / widest.k * widest_.size();
  for (const Level& level : finer_)
    trials.push_back(
        try_fit(*level.patches, level.k, p, per_point * level.k / level.patches->size()));
  while (!trials.back().ok) trials.pop_back();
  const Trial& finest = trials.back();
  residuals->finest = finest.residual;
  residuals->radius = finest.radius;
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
  rough_[i] = {used.residual, used.radius, misfit, slope};
  return static_cast<float>(chosen);
}

// The mean of the levels of p's neighbours; negative: it has too few.
double DetailLevels::level_at(const Vector3d& p, RecentSurface* recent) const noexcept {
  const Patch near =
      recent ? widest_.nearest(p, kBlended + 1, &recent->widest) : widest_.nearest(p, kBlended + 1);
  if (near.n <= kBlended || !(near.squared[kBlended] > 0.0)) return -1.0;
  double sum = 0.0, at = 0.0;
  for (int i = 0; i < kBlended; ++i) {
    const double fade = 1.0 - near.squared[i] / near.squared[kBlended], w = fade * fade;
    sum += w;
    at += w * level_[near.index[i]];
  }
  return at / sum;
}

double DetailLevels::finer_share(const Vector3d& p) const noexcept {
  return any() ? std::clamp(level_at(p), 0.0, 1.0) : 0.0;
}

SurfaceEstimate DetailLevels::refined(const Vector3d& p, int closest, const SurfaceEstimate& coarse,
                                      double max_one_sidedness,
                                      RecentSurface* recent) const noexcept {
  if (closest < 0 || !used_near(closest)) return coarse;
  const double at = level_at(p, recent);
  if (at < 0.0) return coarse;
  const int below = std::min(static_cast<int>(at), static_cast<int>(finer_.size()));
  const double share = at - below;
  const SurfaceEstimate low =
      below == 0 ? coarse : at_level(below - 1, p, max_one_sidedness, recent);
  if (low.status != SurfaceStatus::ok) return coarse;
  if (share < 1e-3 || below == static_cast<int>(finer_.size())) return low;
  const SurfaceEstimate high = at_level(below, p, max_one_sidedness, recent);
  if (high.status != SurfaceStatus::ok) return low;
  return {SurfaceStatus::ok, ((1.0 - share) * low.n_W + share * high.n_W).normalized(),
          (1.0 - share) * low.distance + share * high.distance};
}

SurfaceEstimate DetailLevels::at_level(int l, const Vector3d& p, double max_one_sidedness,
                                       RecentSurface* recent) const noexcept {
  const auto number = static_cast<std::size_t>(l);
  const Level& level = finer_[number];
  const CloudPatches& patches = *level.patches;
  const LocalSurface surface =
      patches.fit(p, recent && number < recent->finer.size()
                         ? patches.nearest(p, level.k, &recent->finer[number])
                         : patches.gathered(p, level.k, level.reach2));
  const SurfaceStatus status = status_of(surface, max_one_sidedness);
  if (status != SurfaceStatus::ok) return {.status = status};
  return {status, surface.n, surface.distance};
}

}  // namespace impedraw
