// The search for a place over drawing planes: the level one and the best that lean to a side, and
// more where none has a place for the whole; in the best ones, with a pen that leans, too. Then the
// best places are moved, turned and leant.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "impedraw/experiment/place_surface.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kTilted = 0.01;     // what another plane must be better by
constexpr std::size_t kRefined = 5;  // places
constexpr std::size_t kLeant = 4;    // planes in which it leans
constexpr double kFurther = 0.1;     // so far behind what is of use, a place is not refined
constexpr double kWorthwhile = 0.3;  // share of the best place in such a plane
constexpr double kRadian = std::numbers::pi / 180.0;  // of a degree

using BenchOf = std::function<std::shared_ptr<PlaceBench>(const Scenario&)>;

// The same place in a plane that leans from that one about its axis x (0) or y (1).
SurfacePlace leant(const SurfacePlace& at, int axis, double by_rad, const BenchOf& bench_of) {
  const Eigen::Matrix3d& R = at.bench->X_WP().R;
  Scenario there = at.bench->scenario();
  there.drawing.tilt_deg = tilt_towards(Eigen::AngleAxisd(by_rad, R.col(axis)) * R.col(2));
  const auto bench = bench_of(there);
  PlaceFound place = at.place;
  place.middle = (bench->X_WP().inverse() * at.p_W).head<2>();
  const double turn = place.turn_deg * kRadian;
  const Vector3d ahead =
      bench->X_WP().R.transpose() * (R * Vector3d(std::cos(turn), std::sin(turn), 0.0));
  place.turn_deg = std::atan2(ahead.y(), ahead.x()) / kRadian;
  SurfacePlace found = bench->at(place);
  found.bench = bench;
  return found;
}

// Moves, turns and leans a place as long as more can be drawn.
void refine(SurfacePlace* best, const BenchOf& bench_of) {
  for (double way = 6e-3, turn = 12.0; way > 7e-4 && best->share < kNearlyAll;) {  // [m], [deg]
    const double before = best->share;
    for (int k = 0; k < 10 && best->share < kNearlyAll; ++k) {
      const double sign = k % 2 == 0 ? 1.0 : -1.0;
      PlaceFound place = best->place;
      if (k < 4) place.middle[k / 2] += sign * way;
      if (k == 4 || k == 5) place.turn_deg += sign * turn;
      try {
        SurfacePlace next = k < 6 ? best->bench->at(place, best->share)
                                  : leant(*best, k / 2 - 3, sign * turn * kRadian, bench_of);
        if (!next.bench) next.bench = best->bench;
        if (next.share > best->share) *best = std::move(next);
      } catch (const InputError&) {  // no posture to start from
      }
    }
    if (best->share == before) way /= 2, turn /= 2;
  }
}

void sort_by_share(std::vector<SurfacePlace>* places) {
  std::ranges::stable_sort(*places, std::ranges::greater(), &SurfacePlace::share);
}

// The planes of the best places, with a pen that leans so.
std::vector<Scenario> with_leaning_pen(double lean_deg, std::vector<SurfacePlace>* found) {
  sort_by_share(found);
  const auto same = [](const Scenario& a, const Scenario& b) {
    return a.drawing.tilt_deg == b.drawing.tilt_deg && a.arm.start_p_WE == b.arm.start_p_WE;
  };
  std::vector<Scenario> planes;
  for (const SurfacePlace& place : *found) {
    if (planes.size() == kLeant || !(place.share > kWorthwhile)) break;
    Scenario in = place.bench->scenario();
    if (std::ranges::any_of(planes, [&](const Scenario& s) { return same(s, in); })) continue;
    in.path.lean_deg = lean_deg;
    planes.push_back(std::move(in));
  }
  return planes;
}

}  // namespace

SurfacePlace place_on_surface(const Scenario& scenario, const Places& places,
                              const SurfaceWish& wish,
                              const std::function<void(double)>& progress) {
  const auto between = [&progress](double from, double to) {
    return [&progress, from, to](double share) {
      if (progress) progress(from + share * (to - from));
    };
  };
  between(0.0, 0.1)(0.0);  // a capture's views take seconds to be put onto each other
  const auto level = std::make_shared<PlaceBench>(scenario, places, wish);
  const BenchOf bench_of = [&](const Scenario& there) {
    return std::make_shared<PlaceBench>(there, places, wish, level.get());
  };
  std::vector<SurfacePlace> found;
  const auto more_than = [&wish](double share) {
    return SurfaceWish{wish.near, wish.shrink, std::max(wish.least, share)};
  };
  const auto look = [&](const std::shared_ptr<PlaceBench>& bench, double from, double to,
                        double least) {
    found.push_back(bench->best_place(more_than(least), between(from, to), &found));
    for (SurfacePlace& place : found)
      if (!place.bench) place.bench = bench;
    return found.back();
  };
  SurfacePlace best = look(level, 0.1, 0.3, 0.0);
  const auto goes_on = [&] {
    return best.share < kNearlyAll && scenario.drawing.tilt_deg.isZero();
  };
  double from = 0.3;
  const auto try_each = [&](const std::vector<Scenario>& planes) {
    for (const Scenario& other : planes) {
      if (!goes_on()) return;
      try {
        const SurfacePlace there = look(bench_of(other), from, from + 0.03, best.share);
        if (there.share > best.share + kTilted) best = there;
      } catch (const InputError&) {  // no posture to start from, for example
      }
      from += 0.03;
    }
  };
  const bool may_lean = scenario.tool.kind == ToolKind::pen && scenario.path.lean_deg == 0.0 &&
                        scenario.control.pen_axis.value_or(PenAxis::plan) == PenAxis::plan;
  for (const auto& [leans, of_pen] :
       {std::pair{std::vector{35.0, 65.0}, 20.0}, {std::vector{0.0, 20.0, 50.0, 90.0}, 30.0}}) {
    if (goes_on()) try_each(level->others(more_than(best.share), leans));
    if (goes_on() && may_lean) try_each(with_leaning_pen(of_pen, &found));
  }
  sort_by_share(&found);
  for (std::size_t i = 0; i < std::min(found.size(), kRefined) && goes_on(); ++i) {
    if (found[i].share < std::max(kRefinable, wish.least - kFurther)) break;
    between(0.8, 1.0)(static_cast<double>(i) / kRefined);
    refine(&found[i], bench_of);
    if (found[i].share > best.share) best = found[i];
  }
  if (!(best.share > 0.0))
    throw InputError("--place surface: the drawing cannot be drawn at any place that was tried");
  return best;
}

std::optional<Eigen::Vector2d> whole_size_mm(const SurfaceWish& wish, const SurfacePlace& found,
                                             const std::function<void(double)>& progress) {
  if (found.share >= kNearlyAll || wish.shrink) return {};
  const SurfacePlace whole = found.bench->best_place({wish.near, true, kNearlyAll}, progress);
  if (whole.share < kNearlyAll) return {};
  return whole.size_mm;
}

}  // namespace impedraw
