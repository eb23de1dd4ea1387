#include "impedraw/experiment/place_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "impedraw/common/in_parallel.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/place_wish.h"
#include "impedraw/experiment/plan.h"
#include "impedraw/experiment/scene.h"
#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kShrink = 0.85, kSmallest = 0.25;
constexpr int kChecked = 20, kWhole = 3,
              kInVain = 12;  // places: checked; that suffice; since the best one
constexpr double kAll = 0.999, kPromising = 0.95;
constexpr std::size_t kOthers = 5;  // planes, where the given one does not do
constexpr double kHopeless = 5.0;   // cost of those that are not tried
// The quick look promises at most so much less than the pre-flight: of 700 places, 1 in 100 more.
constexpr double kQuickError = 0.05;
constexpr double kAlmost = 0.85;  // share from which on a place is moved a little
constexpr double kDegree = std::numbers::pi / 180.0;  // [rad]

// Points spaced evenly along the drawing, about the middle of its box.
std::vector<Vector2d> points_about_middle(const std::vector<PlacedStroke>& strokes,
                                          const Vector2d& middle) {
  constexpr double kSpacing = 2e-3, kMostSamples = 400.0;  // [m]
  const double step = std::max(kSpacing, plane_length(strokes) / kMostSamples);
  std::vector<Vector2d> points;
  double until = 0.0;  // the next point, along the stroke
  for (const PlacedStroke& stroke : strokes) {
    const StrokeRuler ruler(stroke);
    for (until = std::min(until, ruler.length()); until <= ruler.length(); until += step)
      points.push_back(ruler.at(until).p_P - middle);
    until -= ruler.length();
  }
  return points;
}

std::vector<std::string> assignments_of(const PlacementSettings& s, const PlacementSettings& given,
                                        const Scenario& scenario, bool moved, bool started) {
  std::vector<std::string> sets = {
      fmt::format("drawing.placement.centre=[{:.4f}, {:.4f}]", s.centre_m.x(), s.centre_m.y()),
      fmt::format("drawing.placement.rotate={:.1f}", s.rotate_deg)};
  if (s.scale != given.scale) {
    const auto drop = [&](const char* name, bool was) {
      if (was) sets.push_back(fmt::format("drawing.placement.{}=null", name));
    };
    drop("width", given.width_mm.has_value());
    drop("height", given.height_mm.has_value());
    drop("fit_width", given.fit_width_m.has_value());
    drop("fit_height", given.fit_height_m.has_value());
    if (given.margin_mm != 0.0) sets.emplace_back("drawing.placement.margin=0");
    if (given.fit_page) sets.emplace_back("drawing.placement.fit_page=false");
    sets.push_back(fmt::format("drawing.placement.scale={:.4f}", *s.scale));
  }
  const Vector3d &tilt = scenario.drawing.tilt_deg, &move = scenario.canvas.move,
                 &start = scenario.arm.start_p_WE;
  if (!tilt.isZero())
    sets.push_back(fmt::format("drawing.tilt=[{}, {}, {}]", tilt.x(), tilt.y(), tilt.z()));
  if (started)
    sets.push_back(fmt::format("arm.start=[{}, {}, {}]", start.x(), start.y(), start.z()));
  if (scenario.path.lean_deg > 0.0)
    sets.push_back(fmt::format("path.lean={}", scenario.path.lean_deg));
  if (moved) sets.push_back(fmt::format("canvas.move=[{}, {}, {}]", move.x(), move.y(), move.z()));
  return sets;
}

// The pens along a drawing at a place, W, as far as there is a surface.
std::vector<PenPlacement> pens_along(const std::vector<Vector2d>& drawing, const PlaceFound& place,
                                     const SurfaceHeight& surface, const Pose& X_WP) {
  constexpr std::size_t kPens = 24;
  std::vector<PenPlacement> pens;
  const std::size_t step = std::max<std::size_t>(1, drawing.size() / kPens);
  for (std::size_t i = 0; i < drawing.size(); i += step) {
    const Vector2d p = place(drawing[i]);
    if (const auto at = surface(p.x(), p.y()))
      pens.push_back({X_WP * at->p_P, -(X_WP.R * at->n_P)});
  }
  return pens;
}

struct Checked {
  PlaceFound place;
  PlacementSettings placement;
  double share = -1.0, cost = std::numeric_limits<double>::infinity();

  // The cheaper one wins of those that can be drawn but for a trace.
  bool better_than(const Checked& other) const {
    const double mine = std::min(share, kNearlyAll), its = std::min(other.share, kNearlyAll);
    return mine > its || (mine == its && cost < other.cost);
  }
};

}  // namespace

Vector3d tilt_towards(const Vector3d& z) {
  return {std::round(-std::asin(z.y()) / kDegree) + 0.0,
          std::round(std::atan2(z.x(), z.z()) / kDegree) + 0.0, 0.0};
}

struct PlaceBench::Parts {
  Parts(const Scenario& scenario, const Places& places) : errors(places), s(scenario) {}

  struct Placing {
    PlacementSettings given;  // completed
    Artwork drawn;
    Placement placed;  // as given
    Vector2d middle;   // of the strokes' box, P [m]

    // Rounded as it is printed.
    PlacementSettings at(const PlaceFound& found) const {
      const auto rounded = [](double x, double to) { return std::round(x / to) * to; };
      PlacementSettings out = given;
      // A rectangle's sides stay along the world's axes: what turns in it changes its size.
      if (found.size != 1.0 || out.fit_width_m || out.fit_height_m) {
        out.width_mm = out.height_mm = out.fit_width_m = out.fit_height_m = std::nullopt;
        out.margin_mm = 0.0;
        out.fit_page = false;
        out.scale = rounded(found.size * placed.scale(), 1e-4);
      }
      out.rotate_deg = rounded(std::remainder(given.rotate_deg + found.turn_deg, 360.0), 0.1);
      const Vector2d centre = found(placed.centre_m - middle);
      out.centre_m = Vector2d::Zero();
      // Another page point may be at the centre now.
      out.centre_m = centre - place(drawn, out).to_plane(placed.origin_mm);
      for (double& x : out.centre_m) x = rounded(x, 1e-4);
      return out;
    }
  };

  SettingErrors errors;
  Scenario s;  // with the placement completed, and a canvas that may have been moved
  bool moved = false, started = false;  // canvas; arm.start
  Pose X_WP;
  std::shared_ptr<Scene> scene;
  std::optional<Belief> belief;              // the scene's, before this drawing plane
  std::string near;                          // the wish
  std::optional<PlaceSearch> search, fresh;  // see looked(); fresh: nothing failed yet
  Placing placing;
  std::vector<std::vector<Vector2d>> strokes;
  std::vector<Vector2d> drawing;  // points spaced evenly along the strokes, about their middle

  // Verdict of a pre-flight of the drawing at a place; `failed`: points of P where it cannot be
  // drawn.
  struct Verdict {
    double share = 0.0;
    std::vector<Vector2d> failed;
  };
  std::map<std::array<double, 4>, Verdict> verdicts;  // by centre, turn and scale

  // Looks at the surface when it is asked: to move a known place a little, it need not.
  PlaceSearch& looked() {
    if (!search) search = fresh.emplace(belief->surface, search_settings(s, *belief, X_WP, near));
    return *search;
  }

  void improve(Checked* best);
  SurfacePlace result(const Checked& found) const;
  double lean(const Vector3d& normal, const SurfaceWish& wish, Scenario* there) const;

  const Verdict& verdict(const PlacementSettings& at) {
    const auto [found, is_new] = verdicts.try_emplace(
        {at.centre_m.x(), at.centre_m.y(), at.rotate_deg, at.scale.value_or(0.0)});
    if (is_new) found->second.share = share_of(at, &found->second.failed);
    return found->second;
  }

 private:
  double share_of(const PlacementSettings& placement, std::vector<Vector2d>* failed) {
    Scenario there = s;
    there.drawing.placement = placement;
    const PlacedArtwork put = load_artwork(there.drawing, errors, {}, &belief->surface);
    try {
      const Plan plan = make_plan(there, put, *belief, Unreachable::tell, errors);
      double lost = 0.0;
      for (const Finding& f : plan.preflight.findings) {
        lost += f.part.length();
        failed->push_back((X_WP.inverse() * f.p_W).head<2>());
        const PlacedStroke& stroke = put.strokes[static_cast<std::size_t>(f.part.stroke)];
        const PlacedStroke part = part_of(stroke, f.part.from, f.part.to);
        failed->insert(failed->end(), part.p_P.begin(), part.p_P.end());
      }
      double kept = 0.0;
      for (const StrokePart& part : plan.preflight.drawable) kept += part.length();
      return kept / std::max(kept + lost, 1e-9);
    } catch (const InputError&) {  // nothing of a wrap, for example
      return 0.0;
    }
  }
};

PlaceBench::PlaceBench(const Scenario& scenario, const Places& places, const SurfaceWish& wish,
                       const PlaceBench* other) {
  distance_of(wish.near, {});  // refuses it before anything takes long
  parts_ = std::make_unique<Parts>(scenario, places);
  Scenario& s = parts_->s;
  s.drawing.placement = placement_settings(s.drawing);
  const PlacedArtwork artwork = load_artwork(s.drawing, parts_->errors);
  const Pose X_WP = parts_->X_WP = artwork.X_WP;
  if (other) {
    parts_->scene = other->parts_->scene;
    Belief& known = parts_->belief.emplace(parts_->scene->belief);
    known.start_q = start_before(s, X_WP, parts_->scene->truth, &known, parts_->errors);
    known.surface = perceived_height(known.planning, X_WP);
  } else {
    parts_->scene = std::make_shared<Scene>(build_scene(s, X_WP, parts_->errors, false));
    parts_->belief.emplace(parts_->scene->belief);
  }
  const Belief& belief = *parts_->belief;
  parts_->moved = other ? other->parts_->moved : s.canvas.move != scenario.canvas.move;
  parts_->started = other && s.arm.start_p_WE != other->parts_->s.arm.start_p_WE;
  if (belief.height_unknown())
    throw InputError(
        "--place surface: nothing is known of the surface; valid is perception.enabled: true, or "
        "blind.height: canvas");

  parts_->near = wish.near;
  parts_->placing = {s.drawing.placement, artwork.shape.drawn, artwork.placement, {}};
  Eigen::AlignedBox2d box;
  for (const PlacedStroke& stroke : artwork.strokes)
    for (const Vector2d& p : stroke.p_P) box.extend(p);
  const Vector2d middle = parts_->placing.middle = box.center();
  for (const PlacedStroke& stroke : artwork.strokes) {
    parts_->strokes.emplace_back();
    for (const Vector2d& p : stroke.p_P) parts_->strokes.back().push_back(p - middle);
  }
  parts_->drawing = points_about_middle(artwork.strokes, middle);
}

PlaceBench::~PlaceBench() = default;
const Scenario& PlaceBench::scenario() const { return parts_->s; }
const Pose& PlaceBench::X_WP() const { return parts_->X_WP; }
const PlaceSearch& PlaceBench::search() const { return parts_->looked(); }
const std::vector<std::vector<Vector2d>>& PlaceBench::strokes() const { return parts_->strokes; }

const TriangleMesh* PlaceBench::known_mesh() const {
  const Parts& p = *parts_;
  return p.s.perception.source == PerceptionSource::simulated ? &p.scene->truth.canvas->mesh()
                                                              : nullptr;
}

std::vector<Vector3d> PlaceBench::cloud() const {
  const auto& seen = parts_->belief->planning;
  return seen ? seen->cloud().points : std::vector<Vector3d>();
}

PlaceFound PlaceBench::given() const {
  PlaceFound place;
  place.middle = parts_->placing.middle;
  return place;
}

PlaceBench::QuickCheck PlaceBench::check(const PlaceFound& place) const {
  constexpr double kBetween = 1.0;  // strokes: the pen is lifted, moved and set down [s]
  QuickCheck found;
  for (const std::vector<Vector2d>& stroke : parts_->strokes)
    for (std::size_t i = 1; i < stroke.size(); ++i)
      found.length += place.size * (stroke[i] - stroke[i - 1]).norm();
  const double each = found.length / static_cast<double>(parts_->drawing.size());
  double lost = 0.0;
  for (const Vector2d& p : parts_->drawing) {
    const CellTrouble trouble = parts_->looked().trouble(place(p));
    if (trouble == CellTrouble::none) continue;
    found.lost[trouble] += each;
    lost += each;
  }
  found.share = 1.0 - lost / std::max(found.length, 1e-9);
  found.time = found.length / parts_->s.path.draw_speed +
               kBetween * static_cast<double>(parts_->strokes.size());
  const Parts::Placing& placing = parts_->placing;
  found.size_mm = place.size * placing.placed.scale() * bounds_of(placing.drawn.strokes).sizes();
  return found;
}

Scenario PlaceBench::scenario_at(const PlaceFound& place) const {
  Scenario s = parts_->s;
  s.drawing.placement = parts_->placing.at(place);
  return s;
}

double PlaceBench::share_of_plan(const PlaceFound& place) const {
  return parts_->verdict(parts_->placing.at(place)).share;
}

// Leans the drawing plane towards `normal`. The arm starts above the calmest place in it: the way
// from where it starts before a level plane often leads past the ends of joints' ranges. A start
// that was asked for stays, and that before simulated cameras, which would see the arm there.
// Returns the cost of the best place that the quick search finds.
double PlaceBench::Parts::lean(const Vector3d& normal, const SurfaceWish& wish,
                               Scenario* there) const {
  there->drawing.tilt_deg = tilt_towards(normal);
  const Pose X = drawing_frame(there->drawing);
  Belief known = scene->belief;
  known.surface = perceived_height(known.planning, X);
  PlaceSearchSettings settings = search_settings(*there, known, X, wish.near);
  settings.unreachable = {};
  settings.reach_step *= 2;  // the first look
  PlaceSearch look(known.surface, settings);
  const PlaceFound calmest = look.best(drawing, 1.0, {});
  if (!(calmest.cost < kHopeless) || calmest.share < wish.least - kQuickError) return kHopeless;
  const Vector3d z = X.R.col(2), up = s.path.safe_height * z, given = s.arm.start_p_WE;
  if (s.perception.source != PerceptionSource::simulated && given == ArmSettings().start_p_WE) {
    const std::vector<PenPlacement> pens = pens_along(drawing, calmest, known.surface, X);
    Vector3d middle = Vector3d::Zero();
    double highest = -std::numeric_limits<double>::infinity();
    for (const PenPlacement& pen : pens) {
      middle += pen.p_WE / static_cast<double>(pens.size());
      highest = std::max(highest, z.dot(pen.p_WE));
    }
    there->arm.start_p_WE = middle + (highest - z.dot(middle)) * z + up;
    for (double& x : there->arm.start_p_WE) x = std::round(1e3 * x) / 1e3;
  }
  for (const bool last : {false, true}) {
    try {
      known.start_q = start_before(*there, X, scene->truth, &known, errors);
      break;
    } catch (const InputError&) {  // out of reach, or a link touches
      if (last) return kHopeless;
      there->arm.start_p_WE = given;
    }
  }
  look.add_effort(unreachable(known, X, preflight_settings(*there, X, true, known.start_q), up));
  return look.best(drawing, 1.0, {}).cost;
}

std::vector<Scenario> PlaceBench::others(const SurfaceWish& wish,
                                         const std::vector<double>& leans_deg) const {
  constexpr int kSides = 8;
  Parts& p = *parts_;
  struct Plane {
    Vector3d normal;
    double cost = kHopeless;
    Scenario scenario;
  };
  std::vector<Plane> found;
  for (int k = 0; p.belief->planning && k < kSides; ++k) {
    for (const double lean_deg : leans_deg) {
      if (lean_deg == 0.0 && k > 0) continue;  // the same to all sides
      const double side = 2.0 * std::numbers::pi * k / kSides, lean = lean_deg * kDegree;
      found.push_back({.normal = {std::sin(lean) * std::cos(side), std::sin(lean) * std::sin(side),
                                  std::cos(lean)},
                       .scenario = p.s});
    }
  }
  in_parallel(static_cast<int>(found.size()), [&](int i) {
    Plane& plane = found[static_cast<std::size_t>(i)];
    plane.cost = p.lean(plane.normal, wish, &plane.scenario);
  });
  std::ranges::stable_sort(found, {}, &Plane::cost);
  // Places that failed in this plane are avoided there.
  const double here = p.looked().best(p.drawing, 1.0, {}).cost;
  std::vector<Scenario> others;
  for (Plane& plane : found)
    if (others.size() < kOthers && plane.cost < std::min(here, kHopeless))
      others.push_back(std::move(plane.scenario));
  return others;
}

// Moves and turns a place by less than the search tells apart, as long as more can be drawn: joints
// meet their limits on the ways to strokes, of which the search knows nothing.
void PlaceBench::Parts::improve(Checked* best) {
  if (best->share < kAlmost) return;
  for (double way = 6e-3, turn = 12.0; way > 1e-3 && best->share < kNearlyAll;) {  // [m], [deg]
    const double before = best->share;
    for (int k = 0; k < 6 && best->share < kNearlyAll; ++k) {
      const double sign = k % 2 == 0 ? 1.0 : -1.0;
      Checked next = *best;
      if (k < 4)
        next.place.middle[k / 2] += sign * way;
      else
        next.place.turn_deg += sign * turn;
      if (looked().share(drawing, next.place) < best->share - kQuickError) continue;
      next.placement = placing.at(next.place);
      next.share = verdict(next.placement).share;
      if (next.share > best->share) *best = next;
    }
    if (best->share == before) way /= 2, turn /= 2;
  }
}

SurfacePlace PlaceBench::best_place(const SurfaceWish& wish,
                                    const std::function<void(double)>& progress,
                                    std::vector<SurfacePlace>* behind) {
  Parts& parts = *parts_;
  parts.looked();
  parts.search = parts.fresh;
  Checked best;
  std::vector<PlaceFound> tried;
  for (double size = 1.0; size >= kSmallest; size *= kShrink) {
    int whole = 0, in_vain = 0;
    for (int i = 0; i < kChecked && whole < kWhole && in_vain < kInVain; ++i) {
      const PlaceFound place = parts.search->best(parts.drawing, size, tried);
      if (!std::isfinite(place.cost)) break;
      // A smaller one will do better.
      if (wish.shrink && place.share < kPromising && size * kShrink >= kSmallest) break;
      progress(static_cast<double>(i) / kChecked);
      tried.push_back(place);
      if (place.share < std::max(best.share, wish.least) - kQuickError) {
        ++in_vain;
        continue;
      }
      Checked checked{place, parts.placing.at(place)};
      // Points that fail in the pre-flight are avoided from here on.
      const Parts::Verdict& verdict = parts.verdict(checked.placement);
      checked.share = verdict.share;
      checked.cost = place.cost + 10.0 * (1.0 - checked.share);
      parts.search->avoid(verdict.failed);
      whole += checked.share >= kAll;
      ++in_vain;
      const bool better = checked.better_than(best);
      const Checked& less = better ? best : checked;
      if (behind && less.share >= kRefinable) behind->push_back(parts.result(less));
      if (!better) continue;
      best = checked;
      in_vain = 0;
    }
    parts.improve(&best);
    if (!wish.shrink || best.share >= kNearlyAll) break;
  }
  // The given place, whatever the search thinks of it.
  if (!(best.share > 0.0) && wish.least == 0.0) {
    best = {given(), parts.placing.at(given())};
    best.share = parts.verdict(best.placement).share;
  }
  return best.share > 0.0 ? parts.result(best) : SurfacePlace();
}

SurfacePlace PlaceBench::Parts::result(const Checked& best) const {
  SurfacePlace result;
  result.place = best.place;
  result.scenario = s;
  result.scenario.drawing.placement = best.placement;
  const Vector2d& middle = best.place.middle;
  const auto under = belief->surface(middle.x(), middle.y());
  result.p_W = X_WP * (under ? under->p_P : Vector3d(middle.x(), middle.y(), 0.0));
  result.turn_deg = best.place.turn_deg;
  result.share = best.share;
  const Placement final_placement = place(placing.drawn, best.placement);
  result.size_mm = final_placement.scale() * bounds_of(placing.drawn.strokes).sizes();
  result.assignments = assignments_of(best.placement, placing.given, s, moved, started);
  return result;
}

SurfacePlace PlaceBench::at(const PlaceFound& place, double least) const {
  if (parts_->search && parts_->search->share(parts_->drawing, place) < least - kQuickError)
    return {};
  Checked there{place, parts_->placing.at(place)};
  there.share = parts_->verdict(there.placement).share;
  return parts_->result(there);
}

}  // namespace impedraw
