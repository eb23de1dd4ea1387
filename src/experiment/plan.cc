#include "impedraw/experiment/plan.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/line_forces.h"
#include "impedraw/experiment/plan_notes.h"
#include "impedraw/experiment/plan_summary.h"
#include "impedraw/experiment/start_posture.h"
#include "impedraw/experiment/tool_fit.h"
#include "impedraw/experiment/way_leans.h"
#include "impedraw/planning/describe_path.h"
#include "impedraw/planning/preflight/crawl.h"
#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {
namespace {

// A wrapped stroke that is cut on the surface goes on where it was cut on the page.
void start_on_page(const Placement& placement, Plan* plan) {
  std::vector<PlacedStroke>& strokes = *plan->laid;
  for (std::size_t k = 1; k < strokes.size(); ++k) {
    const PlacedStroke& last = strokes[k - 1];
    PlacedStroke& stroke = strokes[k];
    if (plan->source[k] == plan->source[k - 1] && stroke.page.front() == last.page.back())
      stroke.start = last.start + flat_length(last, placement);
  }
}

// The finding for a part that the wrap has no surface for.
Finding off_patch(const std::vector<PlacedStroke>& flat, const StrokePart& part, const Pose& X_WP) {
  const StrokePlace middle =
      place_on(flat[static_cast<std::size_t>(part.stroke)], (part.from + part.to) / 2);
  return {part, Problem::off_canvas, "off the patch of the surface that the wrap lays flat",
          middle.page, X_WP * Eigen::Vector3d(middle.p_P.x(), middle.p_P.y(), 0.0)};
}

// The speed that the line alone permits: neither the surface nor the arm's joints slow it down.
PathSettings unhindered(PathSettings s) {
  s.normal_acceleration = kNormalAccelerationRange.highest;
  s.tilt_speed = kTiltSpeedRange.highest;
  s.tilt_acceleration = kTiltAccelerationRange.highest;
  return s;
}

class Planning {
 public:
  Planning(const Scenario& s, const PlacedArtwork& artwork, const Belief& belief,
           Unreachable unreachable, const SettingErrors& setting_errors,
           const PrepareProgress& progress)
      : s_(s),
        artwork_(artwork),
        belief_(belief),
        unreachable_(unreachable == Unreachable::refuse && s.drawing.skip_unreachable
                         ? Unreachable::skip
                         : unreachable),
        setting_errors_(setting_errors),
        progress_(progress),
        seen_(belief.perception != nullptr) {}

  Plan make() {
    plan_.path_settings = path_settings();
    if (plan_.path_settings.heading && belief_.arm.joints() == 6)
      heading_notes_.emplace_back(
          "six joints: with the tool's heading led no motion is left free, so that joints are not "
          "kept from the ends of their ranges, nor from the wrist's singular posture; the plan "
          "leaves out where they would come there");
    const std::vector<StrokePart> lost = lay_on_surface(kHeadingReserve);
    plan_.load = {hardest(s_, artwork_.strokes), s_.control.friction.coefficient,
                  s_.control.torque_share};
    plan_.rest_q = rest_posture(s_.arm, artwork_, requested(), belief_);
    check(lost);
    if (turns_too_far()) check(lay_on_surface(0.0));
    for (bool done = false; !done;) {
      setting_errors_.locate(placement_setting_names(), [&] { promise(); });
      try {
        plan_path();
        plan_.rough = is_rough(belief_, plan_);
        done = true;
      } catch (const OffSurface& off) {
        leave_out(off);  // an edge finer than the pre-flight's sampling
      } catch (const InputError& error) {
        setting_errors_.raise({"path"}, error.what());
      }
    }
    note_roughness();
    require_fit(s_, plan_, surface(), setting_errors_);
    note_spread_forces(s_.path, &plan_);
    plan_.pens = drawn_pens();
    require_pen_places();
    return std::move(plan_);
  }

 private:
  void tell(const char* what, double share) const {
    if (progress_) progress_(what, share);
  }
  const SurfaceHeight& surface() const { return belief_.surface; }
  // The surface on which the pre-flight puts the arm: an unknown surface in the middle of where it
  // may be.
  SurfaceHeight checked_surface() const {
    return belief_.height_unknown() ? level_surface(0.5 * (s_.blind.plane_z + s_.blind.top_z))
                                    : surface();
  }
  const Canvas* obstacle() const {
    return belief_.height_unknown() ? nullptr : belief_.obstacle.get();
  }
  Eigen::Vector3d z_WP() const { return artwork_.X_WP.R.col(2); }
  const std::vector<PlacedStroke>& requested() const { return plan_.requested(artwork_); }

  PathSettings path_settings() const;
  PreflightSettings preflight_settings() const;
  std::vector<StrokePart> lay_on_surface(double reserve);
  void note_roughness();
  std::optional<DrawnPens> drawn_pens() const;
  void require_pen_places() const;
  bool may_move() const { return seen_ && s_.perception.frames.enabled; }
  void leave_to_run(std::vector<Finding>* findings);
  void check(const std::vector<StrokePart>& lost);
  bool turns_too_far() const;
  void promise();
  void plan_path();
  void leave_out_barred(std::vector<Finding> transitions);
  void leave_out(const OffSurface& off);
  bool leave_out_crawling();
  void take_away(std::size_t drawable, double from, double to, Finding finding);

  const Scenario& s_;
  const PlacedArtwork& artwork_;
  const Belief& belief_;
  Unreachable unreachable_;
  const SettingErrors& setting_errors_;
  const PrepareProgress& progress_;
  bool seen_;
  double wrap_doubt_ = 0.0;  // [m]
  std::vector<std::string> heading_notes_, yaw_notes_;
  std::vector<int> of_artwork_;  // the artwork's number of each promised stroke
  struct Tried {
    double share = 0.1;  // that it loses if it is barred
    WayLeans leans;
  };
  std::vector<Tried> tried_;  // of each drawable part
  Plan plan_;
};

PathSettings Planning::path_settings() const {
  PathSettings path = s_.path;
  path.X_WP = artwork_.X_WP;
  path.heading = heading_of(s_, belief_.arm, belief_.start_q);
  // Lines that cover an area end where the arm's reach does, and the normal may lead out of it.
  if (s_.tool.kind == ToolKind::pad) path.steep = 0.0;
  // A sensor is tared at rest before anything moves.
  if (has_sensor(s_.control.source))
    path.start_hold = std::max(path.start_hold, s_.control.sensing.tare_time + 1.0);
  if (seen_) return path;
  if (belief_.height_unknown()) {
    const BlindSettings& blind = s_.blind;
    if (!(blind.plane_z < blind.top_z))
      setting_errors_.raise({"blind.top_z", "blind.plane_z"},
                            fmt::format("blind.top_z = {} m must lie above blind.plane_z = {} m",
                                        blind.top_z, blind.plane_z));
    path.highest_z = blind.top_z;
    if (belief_.by_touch()) {
      if (s_.control.source == WrenchSource::none)
        setting_errors_.raise({"control.wrench", "blind.height"},
                              "blind.height is touch, which needs a wrench: control.wrench is "
                              "none; valid are ground_truth, sensor, realistic");
      return path;
    }
    path.sink = blind.top_z - blind.plane_z;
  }
  // Blind, the desired point lies beneath the surface: the stiffness makes the push.
  path.vertical_pen = true;
  if (!(s_.control.stiffness.linear.normal > 0.0))
    setting_errors_.raise({"control.stiffness_normal"},
                          "control.stiffness_normal is 0 N/m, but without perception it produces "
                          "the normal force; must be more than 0 N/m");
  if (belief_.height_unknown()) return path;
  path.sink = s_.control.normal_force / s_.control.stiffness.linear.normal;
  double highest = -1e9;
  for (const Eigen::Vector3d& v_W : belief_.obstacle->mesh().vertices)
    highest = std::max(highest, z_WP().dot(v_W - artwork_.X_WP.p));
  path.highest_z = highest;
  return path;
}

PreflightSettings Planning::preflight_settings() const {
  PreflightSettings s = impedraw::preflight_settings(s_, artwork_.X_WP, seen_, plan_.rest_q);
  s.normal_force = plan_.load.normal_force;
  s.height_error = height_error(belief_);
  return s;
}

// Projects or wraps the strokes. Returns the parts without a surface, by the artwork's numbers.
// `reserve`: of the arm's range of yaw, that a led tool's lines may use [rad].
std::vector<StrokePart> Planning::lay_on_surface(double reserve) {
  WrappedStrokes laid;
  plan_.laid.reset();
  plan_.source.clear();
  yaw_notes_.clear();
  if (s_.drawing.mapping == Mapping::wrap) {
    laid = setting_errors_.locate({"drawing.wrap", "drawing.mapping", "drawing"}, [&] {
      plan_.wrap.emplace(surface(), s_.drawing.placement.centre_m, artwork_.strokes,
                         s_.drawing.wrap);
      return plan_.wrap->wrap(artwork_.strokes);
    });
    plan_.laid = std::move(laid.strokes);
  }
  if (const auto& heading = plan_.path_settings.heading)
    plan_.laid = cut_where_turned(requested(), *heading, reserve, artwork_.X_WP,
                                  plan_.path_settings.corner_angle_deg * std::numbers::pi / 180.0,
                                  &yaw_notes_);
  for (const PlacedStroke& stroke : requested()) plan_.source.push_back(stroke.number);
  for (std::size_t k = 0; plan_.laid && k < plan_.laid->size(); ++k)
    (*plan_.laid)[k].number = static_cast<int>(k);
  if (plan_.wrap) {
    start_on_page(artwork_.placement, &plan_);
    wrap_doubt_ = wrap_doubt(plan_, belief_);
  }
  return std::move(laid.lost);
}

std::optional<DrawnPens> Planning::drawn_pens() const {
  const Artwork& drawn = artwork_.shape.drawn;
  const bool one = drawn.layers.size() < 2 && s_.pens.empty();
  if (one && !s_.pen.presses()) return {};
  DrawnPens pens{layer_pens(s_, drawn, setting_errors_)};
  if (one) pens.pens[0].colour.reset();
  for (const int number : of_artwork_)
    pens.of_stroke.push_back(drawn.strokes[static_cast<std::size_t>(number)].layer);
  return pens;
}

void Planning::require_pen_places() const {
  ArmModel arm = belief_.arm;
  const auto require = [&](const char* name, const std::optional<Eigen::Vector3d>& p) {
    if (p && !find_posture(arm, {*p, -z_WP()}, belief_.start_q).reached)
      setting_errors_.raise({name}, fmt::format("{} is [{}, {}, {}] m, where the arm cannot hold "
                                                "the pen along the drawing axis",
                                                name, p->x(), p->y(), p->z()));
  };
  require("pen.place", s_.pen.place);
  require("pen.spot", s_.pen.spot);
}

// True if it is so only where the canvas is before it has been watched.
bool passes_with_canvas(Problem problem) {
  return problem == Problem::joint_jump ||
         (problem >= Problem::out_of_reach && problem <= Problem::arm_collision);
}

// A canvas that may move: what the arm can reach is known once it has been watched, and the run
// checks it then (run/carried_plan.h).
void Planning::leave_to_run(std::vector<Finding>* findings) {
  std::vector<StrokePart> parts = plan_.preflight.drawable;
  std::erase_if(*findings, [&](const Finding& f) {
    if (!passes_with_canvas(f.problem)) return false;
    plan_.where_it_is.push_back(f);
    parts.push_back(f.part);
    return true;
  });
  plan_.preflight.drawable = merged(std::move(parts), s_.preflight.edge_tolerance);
}

void Planning::check(const std::vector<StrokePart>& lost) {
  plan_.preflight = setting_errors_.locate({"preflight"}, [&] {
    return check_strokes(requested(), checked_surface(), belief_.arm, obstacle(), belief_.start_q,
                         preflight_settings(),
                         [&](double share) { tell("checking the strokes", 0.3 + 0.35 * share); });
  });
  if (may_move()) leave_to_run(&plan_.preflight.findings);
  for (Finding& f : plan_.where_it_is) f.part = on_artwork(plan_, artwork_.placement, f.part);
  for (Finding& f : plan_.preflight.findings) {
    f.part = on_artwork(plan_, artwork_.placement, f.part);
    name_step(belief_, s_.preflight.roughest, &f);
  }
  for (const StrokePart& part : lost)
    plan_.preflight.findings.push_back(off_patch(artwork_.strokes, part, artwork_.X_WP));
}

// True where the reserve of the arm's range of yaw led a line to a joint's end: it is to be cut.
bool Planning::turns_too_far() const {
  return plan_.path_settings.heading &&
         std::ranges::any_of(plan_.preflight.findings, [](const Finding& f) {
           return f.problem == Problem::joint_limit || f.problem == Problem::joint_jump;
         });
}

// Sets the promised strokes to the drawable parts. Findings are thrown, noted or ignored, depending
// on `unreachable_`.
void Planning::promise() {
  plan_.notes = heading_notes_;
  plan_.notes.insert(plan_.notes.end(), yaw_notes_.begin(), yaw_notes_.end());
  if (plan_.wrap) note_wrap(wrap_doubt_, &plan_.notes);
  const std::vector<Finding>& findings = plan_.preflight.findings;
  if (!findings.empty() && unreachable_ != Unreachable::tell) {
    const std::string first = refusal_text(findings.front(), seen_);
    const std::string more =
        findings.size() == 1 ? "" : fmt::format(", and {} more such places", findings.size() - 1);
    if (unreachable_ == Unreachable::refuse)
      throw InputError(
          fmt::format("{}{}; ./impedraw plan shows all of them, --skip-unreachable draws the rest",
                      first, more));
    if (plan_.preflight.drawable.empty())
      throw InputError(fmt::format("nothing can be drawn: {}{}; ./impedraw plan shows all of them",
                                   first, more));
    for (const Finding& f : findings) plan_.notes.push_back("not drawn: " + finding_text(f));
  }
  plan_.strokes.clear();
  plan_.strokes.reserve(plan_.preflight.drawable.size());
  of_artwork_.clear();
  std::optional<StrokeRuler> ruler;
  for (const StrokePart& part : plan_.preflight.drawable) {
    const PlacedStroke& whole = requested()[static_cast<std::size_t>(part.stroke)];
    if (!ruler || &ruler->stroke() != &whole) ruler.emplace(whole);
    PlacedStroke stroke = ruler->part(part.from, part.to);
    stroke.number = static_cast<int>(plan_.strokes.size());
    stroke.start = 0.0;
    if (!tried_.empty()) tried_[plan_.strokes.size()].leans.give(&stroke);
    of_artwork_.push_back(plan_.source[static_cast<std::size_t>(part.stroke)]);
    plan_.strokes.push_back(std::move(stroke));
  }
}

void Planning::note_roughness() {
  if (!belief_.perception || may_move()) return;
  // Noise of the cameras cannot be told from a rough surface.
  if (s_.perception.noise.sigma_at_1m > 0.0 || s_.perception.source != PerceptionSource::simulated)
    return;
  if (auto note = roughness_note(plan_.strokes, surface(), artwork_.X_WP, *belief_.perception))
    plan_.notes.push_back(*std::move(note));
}

// Plans the path and omits strokes that it cannot reach.
void Planning::plan_path() {
  tried_.resize(plan_.preflight.drawable.size());
  while (!plan_.strokes.empty()) {  // each round shortens at least one, or changes its ways
    plan_.path = TipPath();         // of what was promised before: large
    const double looks = 3.0 * plane_length(plan_.strokes) / plan_.path_settings.knot_spacing +
                         3.0 * static_cast<double>(plan_.strokes.size());
    const auto tell_path = [&](double done) { tell("planning the path", 0.65 + 0.15 * done); };
    plan_.path =
        plan_from(plan_.path_settings, progress_ ? counted(surface(), looks, tell_path) : surface(),
                  plan_.strokes, s_.arm.start_p_WE, z_WP(), plan_.path_settings.start_hold,
                  stroke_limits(belief_, plan_, plan_.path_settings));
    if (leave_out_crawling()) {
      promise();
      continue;
    }
    if (!s_.preflight.arm) return;
    std::vector<Finding> transitions = check_transitions(
        plan_.path, plan_.strokes, belief_.arm, obstacle(), belief_.start_q, preflight_settings(),
        [&](double done) { tell("checking the ways between strokes", 0.8 + 0.1 * done); });
    if (may_move())
      std::erase_if(transitions, [](const Finding& f) { return passes_with_canvas(f.problem); });
    if (transitions.empty()) return;
    leave_out_barred(std::move(transitions));
    promise();
  }
  plan_.path = TipPath();
}

// Findings have the path's stroke numbers. Where the way to a stroke or off it is barred with every
// lean, the stroke is shortened at that end by a share of its length, or left out if too little
// remains; where the arm cannot follow it from there, that part is left out, with more about it for
// a greater share. What is barred again loses twice that.
void Planning::leave_out_barred(std::vector<Finding> transitions) {
  constexpr double kShorten = 5e-3, kAbout = 50e-3;  // at least; times the share [m]
  constexpr double kLong = 0.2;  // a longer stroke loses no more for being longer [m]
  plan_.path = TipPath();        // large, and has told what it can
  std::vector<Finding*> barring(plan_.preflight.drawable.size(), nullptr);
  for (Finding& f : transitions) {
    const auto i = static_cast<std::size_t>(f.part.stroke);
    if (i < barring.size() && !barring[i]) barring[i] = &f;  // the first of each
  }
  if (std::ranges::count(barring, nullptr) == std::ssize(barring))
    throw InputError(finding_text(transitions.front()));
  for (std::size_t i = barring.size(); i-- > 0;) {  // so that the numbers of those before stay
    if (!barring[i]) continue;
    Finding& f = *barring[i];
    if (f.way != WayEnd::none && tried_[i].leans.try_next(f.way)) continue;
    const StrokePart whole = plan_.preflight.drawable[i];
    double from = whole.from, to = whole.to;
    const double share = std::exchange(tried_[i].share, 2.0 * tried_[i].share);
    const double less = std::max(kShorten, share * std::min(whole.length(), kLong));
    if (f.way == WayEnd::first) {
      to = from + less;
    } else if (f.way == WayEnd::last) {
      from = to - less;
    } else if (f.part.length() < whole.length()) {
      from = whole.from + f.part.from - kAbout * share;
      to = whole.from + f.part.to + kAbout * share;
    }
    take_away(i, from, to, std::move(f));
  }
}

// Takes [from, to] of a drawable part away, and what would be left too short beside it. The finding
// says why.
void Planning::take_away(std::size_t i, double from, double to, Finding finding) {
  std::vector<StrokePart>& drawable = plan_.preflight.drawable;
  const StrokePart whole = drawable[i];
  StrokePart gone{whole.stroke, std::max(whole.from, from), std::min(whole.to, to)};
  std::vector<StrokePart> left;
  if (gone.from - whole.from > s_.preflight.shortest)
    left.push_back({whole.stroke, whole.from, gone.from});
  else
    gone.from = whole.from;
  if (whole.to - gone.to > s_.preflight.shortest)
    left.push_back({whole.stroke, gone.to, whole.to});
  else
    gone.to = whole.to;
  const auto at = static_cast<std::ptrdiff_t>(i);
  drawable.insert(drawable.erase(drawable.begin() + at), left.begin(), left.end());
  const Tried tried = tried_[i];
  tried_.insert(tried_.erase(tried_.begin() + at), left.size(), tried);
  finding.part = on_artwork(plan_, artwork_.placement, gone);
  plan_.preflight.findings.push_back(std::move(finding));
}

// Removes a point without a surface, and a margin on both sides, from the drawable parts.
void Planning::leave_out(const OffSurface& off) {
  const auto i = static_cast<std::size_t>(off.stroke);
  const PlacedStroke& stroke = plan_.strokes[i];
  const double along = nearest_place(stroke, off.p), from = plan_.preflight.drawable[i].from;
  take_away(i, from + along - OffSurface::kAbout, from + along + OffSurface::kAbout,
            {.problem = Problem::off_canvas,
             .text = "at an edge of the canvas",
             .page_mm = place_on(stroke, along).page,
             .p_W = artwork_.X_WP * Eigen::Vector3d(off.p.x(), off.p.y(), 0.0)});
}

// Removes what surface and joints slow down too far. Returns false if nothing does. Stretches below
// kCrawling of least_speed always go; as long as the mean, with something in hand since the run's
// clock yields on rough ground, is below least_speed, those below a bound that rises go, too; then,
// the slowest first, those that are not much slower than their own corners make them.
bool Planning::leave_out_crawling() {
  constexpr double kCrawling = 2.0 / 3.0, kInHand = 1.2, kRise = 1.25, kBarelySlowed = 1.25;
  constexpr double kTurning = 5.0;  // in place of kSlowed: a led tool turns in each bend
  const double asked = std::min(s_.preflight.least_speed, 0.5 * plan_.path_settings.draw_speed);
  if (!(asked > 0.0)) return false;
  double least = kCrawling * asked;
  // The turns of a led tool at its corners are no crawling.
  const bool slow_on_average =
      !plan_.path_settings.heading && plan_.path.mean_speed() < kInHand * asked;
  const std::vector<std::size_t> suspects =
      slow_strokes(plan_.path, slow_on_average ? kInHand * asked : least);
  if (suspects.empty()) return false;
  std::vector<PlacedStroke> strokes;
  for (const std::size_t s : suspects) strokes.push_back(plan_.strokes[s]);
  const TipPath free = plan_from(unhindered(plan_.path_settings), surface(), strokes,
                                 s_.arm.start_p_WE, z_WP(), plan_.path_settings.start_hold);
  std::vector<CrawlingStretch> slow = crawling_stretches(
      plan_.path, free, suspects, least, plan_.path_settings.heading ? kTurning : kSlowed);
  while (slow.empty() && slow_on_average && least < kInHand * asked) {
    least = std::min(kRise * least, kInHand * asked);
    slow = crawling_stretches(plan_.path, free, suspects, least);
  }
  if (slow.empty() && slow_on_average) {
    slow = crawling_stretches(plan_.path, free, suspects, least, kBarelySlowed);
    const auto slowest = std::ranges::min_element(slow, {}, &CrawlingStretch::speed);
    if (slowest != slow.end()) slow = {*slowest};
  }
  std::reverse(slow.begin(), slow.end());  // so that the numbers of those before stay
  for (const CrawlingStretch& c : slow) {
    const double from = plan_.preflight.drawable[c.stroke].from;
    take_away(c.stroke, from + c.from, from + c.to,
              {.problem = Problem::crawls,
               .text = fmt::format("{:.1f} mm/s on average, asked for {:.1f} mm/s", 1e3 * c.speed,
                                   1e3 * least),
               .page_mm = place_on(plan_.strokes[c.stroke], c.slowest).page,
               .p_W = c.p_W});
  }
  return !slow.empty();
}

}  // namespace

Plan make_plan(const Scenario& scenario, const PlacedArtwork& artwork, const Belief& belief,
               Unreachable unreachable, const SettingErrors& setting_errors,
               const PrepareProgress& progress) {
  return Planning(scenario, artwork, belief, unreachable, setting_errors, progress).make();
}

TipPath plan_from(const PathSettings& planned, const SurfaceHeight& surface,
                  const std::vector<PlacedStroke>& strokes, const Eigen::Vector3d& p_WE,
                  const Eigen::Vector3d& n_W, double hold, const SpanLimits& limits) {
  PathSettings settings = planned;
  settings.start_p_WE = p_WE;
  settings.start_n_W = n_W;
  settings.start_hold = hold;
  return plan_tip_path(strokes, surface, settings, limits);
}

}  // namespace impedraw
