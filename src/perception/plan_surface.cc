#include "impedraw/perception/plan_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "impedraw/common/in_parallel.h"
#include "impedraw/perception/detail_levels.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

// The heights between which a plan leaves the widest patches for finer ones [m]. Where it is below
// half of the least at all of the kOffAbout points about, the finer ones are not asked.
constexpr double kLeastOff = 5e-4, kMostOff = 1.5e-3;
constexpr int kOffAbout = 24;
// A hole: no point within kHole, and none as near as kSparse times the points' spacing, which
// beside a hole looks twice as wide: it is found from about 3.5 mm inside. A plan looks for holes
// every kHoleStep in the tangent planes of the cloud's points, as far as kHoleReach; for larger
// ones also around each place that it asks about. It keeps kHoleMargin off such places, if they
// are within kHoleLevel of the surface's tangent plane, so that a pen with a tip of 1 mm stays on
// the surface [m].
constexpr double kHole = 2e-3, kSparse = 1.6, kHoleMargin = 5e-3;
constexpr double kHoleStep = 0.7e-3, kHoleReach = 6e-3, kHoleLevel = 1.5e-3;
constexpr int kLooks = 8;    // around
constexpr int kAround = 40;  // points
// A crease: the normals of two places on either side of it, as the finest patches tell them, lean
// towards each other by more than kCreaseAngle [rad]. They are so far apart that each patch lies on
// its own side. Where their planes meet, a patch leaves a residual above kCreaseResidual [m]: in a
// round valley it follows the bend. The plan keeps kCreaseMargin off that place [m].
constexpr double kCreaseAngle = 60.0 * std::numbers::pi / 180.0, kCreaseResidual = 1e-4;
constexpr double kCreaseNear = 6e-3, kCreaseFar = 9.5e-3, kCreaseMargin = 3.5e-3;
// A fitted surface whose nearest point is further off than this many times the points' spacing runs
// on beyond them.
constexpr double kBeyondPoints = 1.5, kOnSurface = 1e-3;  // [1], [m]
// A patch that leaves a residual above kTwoSheets may lie over a step or a crease: it is fitted
// again with less weight for points further off than kOtherSheet, which is approached from above in
// kSheetFits fits [m]. Noise asks for more, in multiples of the cloud's median residual.
constexpr double kTwoSheets = 5e-4, kOtherSheet = 1e-3, kOfNoise = 5.0;
constexpr int kSheetFits = 5;

// The squared spacing of n points evenly within a squared radius.
double spacing2(double radius2, int n) { return std::numbers::pi * radius2 / n; }

bool over_two_sheets(const LocalSurface& surface, const DetailLevels* levels) noexcept {
  return levels && surface.is_surface &&
         surface.residual > std::max(kTwoSheets, kOfNoise * levels->noise());
}

}  // namespace

PlanSurface::PlanSurface(std::shared_ptr<const SurfaceEstimator> seen, double max_one_sidedness,
                         double most_misfit)
    : seen_(std::move(seen)),
      patches_(*seen_->patches_),
      levels_(seen_->levels_.get()),
      max_one_sidedness_(max_one_sidedness),
      most_misfit_(most_misfit) {
  if (!levels_) return;
  find_apart();
  if (levels_->any()) find_creases();
  find_holes();
}

SurfaceEstimate PlanSurface::estimate(const Vector3d& p) const noexcept {
  if (!p.allFinite()) return {.status = SurfaceStatus::too_few};
  const NormalSettings& s = patches_.settings();
  const Patch patch = patches_.gathered(p, s.k, seen_->reach2_);
  const LocalSurface surface = fit(p, patch);
  const SurfaceStatus status = status_of(surface, max_one_sidedness_);
  if (status != SurfaceStatus::ok) return {.status = status};
  const SurfaceEstimate ends{.status = SurfaceStatus::off_edge};
  if (std::abs(surface.distance) < kOnSurface &&
      (cloud().points[patch.closest] - p).squaredNorm() >
          kBeyondPoints * kBeyondPoints * spacing2(patch.squared[patch.n - 1], patch.n))
    return ends;
  const SurfaceEstimate coarse{status, surface.n, surface.distance};
  if (!levels_) return coarse;
  if (ends_at(patch.closest) || beside_hole(p - coarse.distance * coarse.n_W, coarse.n_W))
    return ends;
  if (!apart_[patch.closest] && std::abs(coarse.distance) < kOnSurface) return coarse;
  const SurfaceEstimate fine = levels_->refined(p, patch.closest, coarse, max_one_sidedness_);
  const double off = std::abs(fine.distance - coarse.distance);
  const double share = std::clamp((off - kLeastOff) / (kMostOff - kLeastOff), 0.0, 1.0);
  if (share == 0.0) return coarse;
  return {SurfaceStatus::ok, ((1.0 - share) * coarse.n_W + share * fine.n_W).normalized(),
          (1.0 - share) * coarse.distance + share * fine.distance};
}

bool PlanSurface::ends_at(int point) const noexcept {
  const Roughness& there = levels_->roughness(point);
  return levels_->steps_near(point) || there.misfit > Roughness::kStepMisfit ||
         there.rougher_than(most_misfit_) || (!creases_.empty() && creases_[point]);
}

bool PlanSurface::in_crease(const Vector3d& p) const noexcept {
  if (creases_.empty() || !p.allFinite()) return false;
  const int nearest = patches_.nearest(p, 1).closest;
  return nearest >= 0 && creases_[nearest];
}

LocalSurface PlanSurface::fit(const Vector3d& p, const Patch& patch) const noexcept {
  Neighbourhood around;
  if (!patches_.about(p, patch, &around)) return {};
  const Vector3d towards = patches_.towards_eye(patch);
  LocalSurface surface = fit_surface(around, patches_.settings().fit, towards);
  if (over_two_sheets(surface, levels_)) fit_one_sheet(towards, &around, &surface);
  return surface;
}

// Least squares with redescending weights w / (1 + (r/c)²)² for points off by r, c falling to
// kOtherSheet: ends on the sheet that most of the weight lies on, which is the query's.
void PlanSurface::fit_one_sheet(const Vector3d& towards, Neighbourhood* around,
                                LocalSurface* surface) const noexcept {
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
    const double c = std::max({kOtherSheet, kOfNoise * levels_->noise(), std::ldexp(most, -pass)});
    for (int i = 0; i < around->n; ++i) {
      const double beyond = 1.0 + (off[i] / c) * (off[i] / c);
      around->w[i] = weight[i] / (beyond * beyond);
    }
    *surface = fit_surface(*around, patches_.settings().fit, towards);
  }
}

void PlanSurface::find_holes() {
  // In the tangent plane at point i, but for cubes that were looked into.
  const auto look_about = [&](int i, CubeSet* looked, std::vector<Vector3d>* found) {
    const Vector3d& p = cloud().points[i];
    LocalSurface surface = seen_->known_[i];
    if (over_two_sheets(surface, levels_)) {
      Patch patch = patches_.nearest(p, patches_.settings().k);
      patch.closest = i;
      surface = fit(p, patch);
    }
    if (!surface.is_surface) return;
    const Vector3d foot = p - surface.distance * surface.n;
    constexpr int kSteps = static_cast<int>(kHoleReach / kHoleStep);
    const Vector3d a = kHoleStep * surface.n.unitOrthogonal(), b = surface.n.cross(a);
    const Vector3d foot_cubes = foot / kHoleStep, a_cubes = a / kHoleStep, b_cubes = b / kHoleStep;
    for (int u = -kSteps; u <= kSteps; ++u)
      for (int v = -kSteps; v <= kSteps; ++v) {
        if (u * u + v * v > kSteps * kSteps) continue;
        if (!looked->insert(cube_of(foot_cubes + u * a_cubes + v * b_cubes))) continue;
        const Vector3d place = foot + u * a + v * b;
        if (is_hole(place)) found->push_back(place);
      }
  };
  std::vector<Vector3d> more;
  in_halves(patches_.size(), [&](int begin, int end) {
    CubeSet looked;
    for (int i = begin; i < end; ++i) look_about(i, &looked, begin == 0 ? &holes_ : &more);
  });
  holes_.insert(holes_.end(), more.begin(), more.end());
  if (!holes_.empty()) hole_tree_ = std::make_unique<const NeighbourTree>(holes_);
}

// No point of the finest view is as near as the points around are to each other. kAround of them
// make the spacing that of the surroundings, also where grazing cameras see lines that are wide
// apart.
bool PlanSurface::is_hole(const Vector3d& place) const noexcept {
  static_assert(1.7321 * DetailLevels::kCube < kHole);
  if (levels_->finest_in_cube(place)) return false;
  const NeighbourTree& finest = levels_->finest();
  if (finest.has_within(place, kHole, 1)) return false;
  const double most = patches_.settings().max_radius;
  int nearest;
  double squared;
  if (finest.nearest(place, 1, most, &nearest, &squared) == 0) return true;
  // The radius at which kAround points have the spacing that makes this place a hole.
  const double radius = std::sqrt(squared / (kSparse * kSparse * spacing2(1.0, kAround)));
  return finest.has_within(place, std::min(radius, most), kAround) ||
         !finest.has_within(place, most, kAround);
}

// A hole further off the tangent plane may lie in the body, under an upper sheet.
bool PlanSurface::beside_hole(const Vector3d& foot, const Vector3d& n) const noexcept {
  if (hole_tree_) {
    int index[kMostNeighbours];
    double squared[kMostNeighbours];
    const int found = hole_tree_->nearest(foot, kMostNeighbours, kHoleMargin, index, squared);
    if (std::any_of(index, index + found,
                    [&](int j) { return std::abs(n.dot(holes_[j] - foot)) < kHoleLevel; }))
      return true;
  }
  const Vector3d a = kHoleMargin * n.unitOrthogonal(), b = n.cross(a);
  for (int look = 0; look < kLooks; ++look) {
    const double angle = 2.0 * std::numbers::pi * look / kLooks;
    if (is_hole(foot + std::cos(angle) * a + std::sin(angle) * b)) return true;
  }
  return is_hole(foot);
}

void PlanSurface::find_apart() {
  apart_.assign(cloud().points.size(), 0);
  for (int i = 0; i < patches_.size(); ++i) {
    const SurfaceEstimate& at = seen_->at_points()[i];
    if (at.status != SurfaceStatus::ok) {
      apart_[i] = 1;
    } else if (std::abs(at.distance - seen_->known_[i].distance) >= 0.5 * kLeastOff) {
      const Patch near = patches_.nearest(cloud().points[i], kOffAbout);
      for (int j = 0; j < near.n; ++j) apart_[near.index[j]] = 1;
    }
  }
}

void PlanSurface::find_creases() {
  const std::vector<Vector3d>& points = cloud().points;
  const std::vector<SurfaceEstimate>& at = seen_->at_points();
  const int n = patches_.size();
  creases_.assign(n, 0);
  int index[kMostNeighbours];
  double squared[kMostNeighbours];
  for (int i = 0; i < n; ++i) {
    if (at[i].status != SurfaceStatus::ok || !levels_->used_near(i)) continue;
    const int found =
        patches_.tree().nearest(points[i], kMostNeighbours, kCreaseFar, index, squared);
    for (int k = 0; k < found; ++k) {
      const int j = index[k];
      if (j < i || at[j].status != SurfaceStatus::ok) continue;
      const Vector3d half = 0.5 * (points[j] - points[i]);
      const Vector3d &a = at[i].n_W, &b = at[j].n_W;
      const double cosine = a.dot(b);
      const bool apart = squared[k] > kCreaseNear * kCreaseNear;
      if (!apart || cosine > std::cos(kCreaseAngle) || (b - a).dot(half) > 0.0 || cosine < -0.9)
        continue;
      // From the middle between them onto the line where their planes meet.
      const double to_a = -a.dot(half), to_b = b.dot(half), det = 1.0 - cosine * cosine;
      const Vector3d line =
          points[i] + half + (to_a - cosine * to_b) / det * a + (to_b - cosine * to_a) / det * b;
      int about[kMostNeighbours];
      double off[kMostNeighbours];
      const int m = patches_.tree().nearest(line, kMostNeighbours, kCreaseMargin, about, off);
      if (m == 0) continue;
      // no radius: points on both sides are no surface
      const Roughness& there = levels_->roughness(about[0]);
      if (there.radius > 0.0 && there.residual < kCreaseResidual) continue;
      for (int l = 0; l < m; ++l) creases_[about[l]] = 1;
    }
  }
}

}  // namespace impedraw
