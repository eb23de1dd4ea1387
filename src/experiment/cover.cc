#include "impedraw/experiment/cover.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "impedraw/canvas/mesh_file.h"
#include "impedraw/common/file_extension.h"
#include "impedraw/common/in_parallel.h"
#include "impedraw/experiment/cover_region.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/place_wish.h"
#include "impedraw/experiment/tool_fit.h"
#include "impedraw/perception/seen_surface.h"
#include "impedraw/planning/cover/even_lines.h"
#include "impedraw/planning/stroke_part.h"

namespace impedraw {
namespace {

constexpr double kMostVertices = 90e3;
constexpr double kInside = 0.75;
// The range of the force along the lines over the one asked for: for an even dose, and for one by
// tones. With less, a pad's face would not touch as a whole.
constexpr ForceRange kEven{0.945, 1.055}, kByTone{0.4, 1.055};
// Between the points of a line [m]. The path keeps to their chords within a tenth of it, which a
// pad does not feel: held within 10 µm, each would be a bend to slow down at.
constexpr double kExact = 1e-3;
// The share of the arm's own inertia along the normal that is desired while a pad presses: where
// the normal turns faster than perception knows it, a lighter tip keeps its force. Foam is soft, so
// that the loop bears it with a wrench that comes late. With 0.1 a hand of 40 N once drove it off
// by 0.2 m.
constexpr double kLighter = 0.15;
// A pad turns with the surface that it feels: joints come nearer to their ends than planned [rad].
constexpr double kJointMargin = 0.08;
// The distance of the centres from places that the arm does not reach [m].
constexpr double kOffReach = 1e-3;
constexpr double kReachStep = 8e-3,
                 kFinestReach = 2e-3;  // of squares in which the arm is asked [m]
constexpr double kUnsure = 0.5e-3;     // of a place's height, along its normal [m]
constexpr double kNothing = 0.02;      // a tone as light as that asks for nothing

// A foam that is pressed deeper than its thickness is a jet (jet_of()), which no foam's end limits.
Footprint footprint_of(const PadSettings& pad) {
  return {pad.radius, pad.rest, pad.rest > pad.thickness ? kFar : pad.thickness};
}

Eigen::AlignedBox2d extent_of(const Scenario& s, const Belief& belief, const Pose& X_WP) {
  const auto& points = belief.perception->cloud().points;
  const Pose X_PW = X_WP.inverse();
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3d& p_W : points) box.extend((X_PW * p_W).head<2>());
  const double air = 2.0 * s.tool.radius.value_or(PadSettings().radius) / 5.0;
  return {box.min().array() - air, box.max().array() + air};
}

// The surface under the footprint's rim: the planner's own surface ends where its centres must.
// Heights are those of the estimate; a place is known between points of the cloud, no further from
// each other than two voxels. A voxel's point is the mean of those within: at an edge, a quarter of
// the voxel inside of it on average. Points that are not averaged are no further apart than the
// grid is wide.
void know_between_points(const PointCloud& cloud, double voxel, const Pose& X_WP, SurfaceGrid* g) {
  const SeenSurface seen(cloud, std::max(voxel, 2.0 * g->step), kInside * voxel);
  in_parallel(g->ny, [&](int j) {
    for (int i = 0; i < g->nx; ++i)
      if (const std::size_t v = g->index(i, j); g->known[v]) g->known[v] = seen(X_WP * g->point(v));
  });
}

// The doubt of each place: the cloud's noise, or twice what the estimate misses of its points.
void doubt_heights(const Belief& belief, const Pose& X_WP, SurfaceGrid* g) {
  const auto error = height_error(belief);
  g->unsure.assign(g->size(), kUnsure);
  in_parallel(g->ny, [&](int j) {
    for (int i = 0; i < g->nx; ++i)
      if (const std::size_t v = g->index(i, j); g->known[v])
        g->unsure[v] = std::max(kUnsure, error(X_WP * g->point(v)));
  });
}

// A place whose tone is less than what the least force leaves gets that.
double least_share(const Scenario& s) { return kByTone.least / s.cover.passes; }

void wish_for_region(const Scenario& s, const Pose& X_WP, const SettingErrors& errors,
                     CoverPlan* plan) {
  CoverRegion region = errors.locate({"cover.region", "drawing.placement"},
                                     [&] { return region_of(s, plan->grid, X_WP); });
  plan->wish.region = std::move(region.inside);
  plan->left_out = std::move(region.left_out);
  if (s.cover.dose != CoverDose::by_tone) return;
  plan->wish.share = std::move(region.tones);
  for (std::size_t v = 0; v < plan->grid.size(); ++v) {
    double& share = plan->wish.share[v];
    if (share <= kNothing) plan->wish.region[v] = 0;
    if (plan->wish.region[v] && share < least_share(s)) plan->faint += plan->grid.area[v];
    share = std::max(share, least_share(s));
  }
}

const char* name_of(const ToolSettings& tool) {
  return tool.kind == ToolKind::nozzle ? "jet" : "pad";
}

void require_tones(const Scenario& s, const SettingErrors& errors) {
  if (s.cover.dose == CoverDose::even) return;
  if (s.tool.kind != ToolKind::pad)
    errors.raise({"cover.dose", "tool.kind"},
                 "cover.dose: by_tone varies the force of a pad, and tool.kind is nozzle; valid is "
                 "even, or tool.kind pad");
  if (lower_extension(s.cover.region) != ".svg")
    errors.raise({"cover.dose", "cover.region"},
                 "cover.dose: by_tone takes its tones from the filled areas of an SVG, and "
                 "cover.region is " +
                     (s.cover.region.empty() ? "not given" : s.cover.region.string()));
}

// Throws InputError with the reason that the footprint fits nowhere, if it does not.
void require_centres(const CoverPlan& plan, const Scenario& s, const SettingErrors& errors) {
  const bool drawn = !s.cover.region.empty();
  if (plan.centres.wanted == 0.0)
    errors.raise({"cover.region"},
                 drawn ? fmt::format("cover.region: {} lies off the canvas, or where it is steeper "
                                     "than {:.0f}°; {} moves it",
                                     s.cover.region.string(), s.preflight.max_slope_deg,
                                     is_mesh_file(s.cover.region) ? "canvas.mesh.position"
                                                                  : "drawing.placement")
                       : fmt::format("cover: nothing of the canvas is seen, or all is steeper than "
                                     "{:.0f}°",
                                     s.preflight.max_slope_deg));
  if (std::ranges::count(plan.centres.allowed, 1) > 0) return;
  const double width = 2e3 * plan.wish.footprint.radius;
  if (plan.centres.uneven > 0)
    errors.raise(
        {"tool.radius", "cover.region"},
        fmt::format("tool.radius: a pad of {:.1f} mm touches with a part of its face only, "
                    "wherever it is put: the surface bends by more than its foam gives "
                    "({:.2f} mm under {:.3g} N); valid is a smaller pad, softer foam or "
                    "more force",
                    width, 1e3 * plan.wish.footprint.compression, s.control.normal_force));
  errors.raise({"tool.radius", "cover.region"},
               fmt::format("tool.radius: a {0} of {1:.1f} mm, kept {2:.1f} mm off the edges, fits "
                           "nowhere {3}; valid is a smaller {0}",
                           name_of(s.tool), width, 1e3 * plan.wish.margin,
                           drawn ? "in cover.region" : "on the canvas"));
}

// Throws InputError where the footprint fits, but in too little room for a line.
void require_lines(const CoverPlan& plan, const Scenario& s, const SettingErrors& errors) {
  if (!plan.lines.passes.empty()) return;
  errors.raise(
      {"tool.radius", "cover.region"},
      fmt::format("tool.radius: a {0} of {1:.1f} mm, kept {2:.1f} mm off the edges, has no "
                  "room to move along a line {3}; valid is a smaller {0}",
                  name_of(s.tool), 2e3 * plan.wish.footprint.radius, 1e3 * plan.wish.margin,
                  s.cover.region.empty() ? "on the canvas" : "in cover.region"));
}

// `refused`: lines were left out.
void note_rest(const Scenario& s, bool refused, CoverPlan* cover) {
  const double max_slope_deg = s.preflight.max_slope_deg;
  const CoverPlan& plan = *cover;
  const SurfaceGrid& g = plan.grid;
  const std::vector<char>& region = plan.wish.region;
  const double cm2 = 1e4;
  if (!region.empty()) {
    double off = 0.0;
    for (std::size_t v = 0; v < g.size(); ++v)
      if (region[v] && !g.known[v]) off += g.step * g.step;
    if (off > 1e-4)
      cover->notes.push_back(fmt::format(
          "{:.1f} cm² of cover.region, seen along the drawing axis, lie where no surface is seen, "
          "or one steeper than {:.0f}°: not covered",
          cm2 * off, max_slope_deg));
  }
  if (plan.faint > 1e-4)
    cover->notes.push_back(fmt::format(
        "{:.1f} cm² of cover.region have a tone below {:.2f}: they get that much, by {:.0f} "
        "% of the force; more cover.passes allow less",
        cm2 * plan.faint, least_share(s), 100.0 * kByTone.least));
  const double rest = plan.centres.wanted - plan.promised_area;
  if (rest > 1e-5)
    cover->notes.push_back(fmt::format(
        "{:.1f} of {:.1f} cm² are not covered: within the {}'s margin of an edge or a hole{}{}",
        cm2 * rest, cm2 * plan.centres.wanted, name_of(s.tool),
        s.tool.kind == ToolKind::pad ? ", or where the pad's face does not touch as a whole" : "",
        refused ? ", or where the arm does not reach or the pre-flight refuses the surface" : ""));
}

std::vector<char> inner_places(const CoverPlan& plan, const PlaneLines& lines) {
  const double radius = plan.wish.footprint.radius;
  return inside_by(plan.grid, surely_pressed(plan.grid, lines, plan.centres.feet), radius);
}

ForceRange force_range(const Scenario& s) {
  if (s.tool.kind == ToolKind::nozzle) return {1.0, 1.0};
  return s.cover.dose == CoverDose::by_tone ? kByTone : kEven;
}

WantedDose wanted_dose(const CoverPlan& plan, int passes, std::vector<char> places) {
  WantedDose wanted{std::move(places), plan.wish.share, plan.one_pass};
  for (double& share : wanted.share) share *= passes;
  return wanted;
}

// Promises what the lines cover, leaves out and repeats parts of them where the dose is uneven, and
// finds their forces.
void promise(const Scenario& s, const std::vector<char>& inner, bool refused, CoverPlan* cover) {
  CoverPlan& plan = *cover;
  PlaneLines& lines = plan.lines.passes;
  if (plan.wish.share.empty()) even_parts(plan.grid, plan.centres.feet, inner, &lines);
  plan.promised_area = area_of(plan.grid, surely_pressed(plan.grid, lines, plan.centres.feet));
  plan.forces = even_forces(plan.grid, lines, plan.centres.feet,
                            wanted_dose(plan, s.cover.passes, inner), force_range(s));
  for (auto& pass : plan.forces)
    for (double& f : pass) f *= s.control.normal_force;
  plan.notes.clear();
  note_rest(s, refused, cover);
}

// On the plan's centres, in the layout that is more even.
void lay_lines(const Scenario& s, CoverPlan* cover) {
  CoverPlan& plan = *cover;
  struct Laid {
    CoverLines lines;
    std::vector<char> inner;
    double uneven = 0.0;
  };
  std::array<Laid, 2> laid;
  in_parallel(2, [&](int i) {
    Laid& l = laid[static_cast<std::size_t>(i)];
    l.lines =
        cover_lines(plan.grid, plan.centres, plan.wish, i == 0 ? Layout::rows : Layout::rings);
    l.inner = inner_places(plan, l.lines.passes);
    l.uneven = even_lines(plan.grid, plan.centres, l.inner, l.lines.edges, &l.lines.passes);
  });
  Laid& better = laid[1].uneven < laid[0].uneven ? laid[1] : laid[0];
  plan.lines = std::move(better.lines);
  for (auto& pass : plan.lines.passes) pass = rounded(pass, kExact);
  if (!plan.wish.share.empty()) {
    plan.one_pass =
        mean_of(plan.grid, dose_of(plan.grid, plan.lines.passes, plan.centres.feet), better.inner);
    plan.lines.passes =
        in_passes(plan.grid, plan.lines.passes, plan.centres.feet,
                  wanted_dose(plan, s.cover.passes, better.inner), force_range(s), s.cover.passes);
  }
  promise(s, better.inner, !plan.centres.within_reach.empty(), cover);
}

// Vertices where the arm has a posture for the pad, asked in the middle of squares. Squares
// beside others with another answer are asked again by quarters.
std::vector<char> reached_places(const Scenario& s, const Belief& belief, const Pose& X_WP,
                                 const SurfaceGrid& g, const Centres& centres) {
  const PreflightSettings settings = preflight_settings(s, X_WP, true, belief.start_q);
  std::vector<char> reached(g.size(), 1), asked = centres.allowed;
  for (double width = kReachStep;; width *= 0.5) {
    const int side = std::max(1, static_cast<int>(std::lround(width / g.step)));
    const auto in_square = [&](int i0, int j0, auto&& visit) {
      for (int j = j0; j < std::min(g.ny, j0 + side); ++j)
        for (int i = i0; i < std::min(g.nx, i0 + side); ++i)
          if (const std::size_t v = g.index(i, j); centres.allowed[v]) visit(v);
    };
    std::vector<char> answers = reached;
    in_parallel((g.ny + side - 1) / side, [&](int row) {
      const auto out_of_reach = unreachable(belief, X_WP, settings);
      for (int i0 = 0, j0 = row * side; i0 < g.nx; i0 += side) {
        const Eigen::Vector2d middle =
            g.low + g.step * (Eigen::Vector2d(i0, j0).array() + 0.5 * (side - 1)).matrix();
        std::optional<std::size_t> at;
        bool unsure = false;
        in_square(i0, j0, [&](std::size_t v) {
          if (!at || (g.plane(v) - middle).norm() < (g.plane(*at) - middle).norm()) at = v;
          unsure = unsure || asked[v];
        });
        if (!unsure) continue;
        const Eigen::Vector3d n = centres.feet.at(g, g.plane(*at)).normal();
        const bool here = out_of_reach({g.point(*at), n}) < 1.0;
        in_square(i0, j0, [&](std::size_t v) { answers[v] = here; });
      }
    });
    reached = std::move(answers);
    if (0.5 * width < kFinestReach) return reached;
    // Squares beside the border are asked again.
    std::vector<char> out(g.size());
    for (std::size_t v = 0; v < g.size(); ++v) out[v] = !reached[v];
    const std::vector<double> in = distance_to_edge(g, reached), off = distance_to_edge(g, out);
    for (std::size_t v = 0; v < g.size(); ++v)
      asked[v] = centres.allowed[v] && std::max(in[v], off[v]) < 0.5 * side * g.step;
  }
}

// Keeps the centres off what is not reached.
void keep_within(const SurfaceGrid& g, const std::vector<char>& reached, Centres* centres) {
  if (std::ranges::count(reached, 0) == 0) return;
  Centres& c = *centres;
  const std::vector<double> within = distance_to_edge(g, reached);
  if (c.within_reach.empty()) c.within_reach.assign(g.size(), kFar);
  for (std::size_t v = 0; v < g.size(); ++v) {
    c.within_reach[v] = std::min(c.within_reach[v], within[v]);
    c.clearance[v] = std::min(c.clearance[v], c.within_reach[v] - kOffReach);
    c.allowed[v] = c.clearance[v] >= 0.0;
  }
}

std::vector<Eigen::Vector2d> line_of(const PlacedArtwork& artwork, const StrokePart& part) {
  const PlacedStroke& stroke = artwork.strokes[static_cast<std::size_t>(part.stroke)];
  return part_of(stroke, part.from, part.to).p_P;
}

}  // namespace

std::optional<PadSettings> covering(const Scenario& s) {
  const double force = s.control.normal_force;
  const auto pad = pad_of(s.tool, s.world.tip.friction, force);
  return pad ? pad : jet_of(s.tool, force);
}

Scenario with_cover_defaults(Scenario s, const Places& places) {
  const auto given = [&](const char* name) { return !places.of(name).starts_with("default of "); };
  const SettingErrors errors(places);
  if (s.tool.kind == ToolKind::pen && given("tool.kind"))
    errors.raise(
        {"tool.kind"},
        "tool.kind is pen: its ball touches at a point and covers no area; valid is pad, or "
        "nozzle");
  if (s.tool.kind == ToolKind::pen) s.tool.kind = ToolKind::pad;
  require_own_settings(s.tool, places);
  // A jet coats by time: it must not have to slow down where rows turn.
  if (!given("path.draw_speed")) s.path.draw_speed = s.tool.kind == ToolKind::nozzle ? 0.05 : 0.1;
  if (!given("path.draw_acceleration")) s.path.draw_acceleration = 2.0;
  if (!given("path.travel_acceleration")) s.path.travel_acceleration = 1.0;
  // A face that leans off the normal presses with one side, and more than the law makes up for.
  if (!given("path.tilt_allowance")) s.path.tilt_allowance_deg = 0.0;
  ControlSettings& control = s.control;
  // A canvas that moves is followed better by a mass of its own.
  if (control.source != WrenchSource::none && !s.perception.frames.enabled &&
      s.tool.kind == ToolKind::pad && !given("control.inertia"))
    control.inertia = InertiaShaping::light_normal;
  if (control.inertia == InertiaShaping::light_normal && !given("control.inertia_scale"))
    control.inertia_scale = kLighter;
  const double r = s.tool.radius.value_or(PadSettings().radius), voxel = s.perception.voxel;
  NormalSettings& normals = s.perception.normals;
  const int over = static_cast<int>(std::numbers::pi * r * r / (voxel * voxel));
  normals.k = std::max(normals.k, std::min(over, kMostNeighbours));
  normals.max_radius = std::max(normals.max_radius, 2.0 * r);
  s.preflight.joint_margin = std::max(s.preflight.joint_margin, kJointMargin);
  s.drawing.skip_unreachable = true;
  return s;
}

CoverPlan plan_cover(const Scenario& s, const Belief& belief, const Pose& X_WP,
                     const SettingErrors& errors, const std::function<void(double)>& progress) {
  if (!belief.perception)
    errors.raise({"perception.enabled"},
                 "perception.enabled is false: the lines of cover lie on what the cameras saw; "
                 "valid is true");
  const auto pad = covering(s);
  if (!pad)
    errors.raise({"tool.kind"},
                 "tool.kind: only a pad or a nozzle covers an area; valid is pad, or nozzle");
  require_foam(s, errors);
  require_tones(s, errors);
  const Eigen::AlignedBox2d box = extent_of(s, belief, X_WP);
  const double step =
      std::max({1e-3, pad->radius / 10.0, std::sqrt(box.sizes().prod() / kMostVertices)});
  CoverPlan plan;
  plan.grid = sample_surface(perceived_height(belief.perception, X_WP), box, step,
                             s.preflight.max_slope_deg, progress);
  know_between_points(belief.perception->cloud(), s.perception.voxel, X_WP, &plan.grid);
  doubt_heights(belief, X_WP, &plan.grid);
  plan.wish.footprint = footprint_of(*pad);
  plan.wish.spacing = 2.0 * pad->radius * (1.0 - s.cover.overlap);
  plan.wish.direction_deg = s.cover.direction_deg;
  plan.wish.margin = s.cover.margin;
  if (!s.cover.region.empty()) wish_for_region(s, X_WP, errors, &plan);
  plan.centres = footprint_centres(plan.grid, plan.wish);
  require_centres(plan, s, errors);
  // A canvas that moves comes into reach. Where the arm reaches nothing, its findings tell why.
  Centres within = plan.centres;
  if (!s.perception.frames.enabled)
    keep_within(plan.grid, reached_places(s, belief, X_WP, plan.grid, within), &within);
  if (std::ranges::count(within.allowed, 1) > 0) plan.centres = std::move(within);
  lay_lines(s, &plan);
  require_lines(plan, s, errors);
  return plan;
}

bool keep_within_reach(const Scenario& s, const PlannedDrawing& drawing, CoverPlan* plan) {
  const SurfaceGrid& g = plan->grid;
  std::vector<StrokePart> lost;
  for (const Finding& f : drawing.plan.preflight.findings) {
    const bool of_arm = f.problem >= Problem::out_of_reach && f.problem <= Problem::arm_collision;
    if (f.way != WayEnd::none) continue;  // it may be planned otherwise
    if (of_arm || f.problem == Problem::crawls) lost.push_back(f.part);
  }
  lost = merged(std::move(lost));
  std::vector<double> to_lost(g.size(), kFar), to_kept = to_lost;
  const auto measure = [&](const std::vector<StrokePart>& parts, std::vector<double>* nearest) {
    for (const StrokePart& part : parts)
      for (const Eigen::Vector2d& p : line_of(drawing.artwork, part)) {
        const Eigen::Vector3d at = g.lifted(p);
        around(g, at, plan->wish.spacing, [&](std::size_t v) {
          (*nearest)[v] = std::min((*nearest)[v], (g.point(v) - at).norm());
        });
      }
  };
  measure(lost, &to_lost);
  measure(rest_of(drawing.artwork.strokes, lost), &to_kept);
  std::vector<char> reached(g.size());
  for (std::size_t v = 0; v < g.size(); ++v) reached[v] = !(to_lost[v] < to_kept[v] + g.step);
  if (std::ranges::count(reached, 0) == 0) return false;
  keep_within(g, reached, &plan->centres);
  if (std::ranges::count(plan->centres.allowed, 1) == 0) return false;
  lay_lines(s, plan);
  return !plan->lines.passes.empty();
}

bool keep_drawn(const Scenario& s, const PlannedDrawing& drawing, Barred barred, CoverPlan* plan) {
  PlaneLines& kept = plan->lines.passes;
  const auto once = std::ssize(kept);
  std::vector<StrokePart> lost;
  for (const Finding& f : drawing.plan.preflight.findings)
    if ((f.way == WayEnd::none || barred == Barred::lost) && f.part.stroke < once)
      lost.push_back(f.part);
  if (lost.empty()) return false;
  const auto first = drawing.artwork.strokes.begin();
  kept.clear();
  for (const StrokePart& part : rest_of({first, first + once}, merged(std::move(lost)), kExact))
    kept.push_back(line_of(drawing.artwork, part));
  promise(s, inner_places(*plan, kept), true, plan);
  return true;
}

TrueCover true_cover(const Scenario& s, const Scene& scene, const Pose& X_WP,
                     const CoverPlan& plan) {
  TrueCover cover;
  cover.grid =
      same_places(plan.grid, canvas_height(scene.truth.canvas, X_WP), s.preflight.max_slope_deg);
  CoverWish wish = plan.wish;
  wish.margin = 0.0;
  Centres centres = footprint_centres(cover.grid, wish);
  const std::vector<char> reached = reached_places(s, scene.belief, X_WP, cover.grid, centres);
  for (std::size_t v = 0; v < reached.size(); ++v)
    centres.allowed[v] = centres.allowed[v] && reached[v];
  cover.reachable = swept(cover.grid, centres, wish.footprint.radius);
  return cover;
}

std::string cover_strokes(const CoverPlan& plan, const Scenario& s) {
  const Placement page = place(Artwork{.strokes = {Stroke{.points = {{0, 0}, {1, 1}}}}},
                               drawing_of_cover(s, {}).drawing.placement);
  std::string text = "x,y,force,stroke\n";
  int stroke = 0;
  const int times = plan.wish.share.empty() ? s.cover.passes : 1;
  for (int pass = 0; pass < times; ++pass)
    for (std::size_t l = 0; l < plan.lines.passes.size(); ++l, ++stroke)
      for (std::size_t i = 0; i < plan.lines.passes[l].size(); ++i) {
        const Eigen::Vector2d mm = page.to_page(plan.lines.passes[l][i]);
        text += fmt::format("{:.4f},{:.4f},{:.4f},{}\n", mm.x(), mm.y(), plan.forces[l][i], stroke);
      }
  return text;
}

Scenario drawing_of_cover(Scenario s, const std::filesystem::path& strokes) {
  DrawingSettings drawing;
  drawing.svg = strokes;
  drawing.unit = PageUnit::mm;
  drawing.keep_order = true;
  drawing.tilt_deg = s.drawing.tilt_deg;
  drawing.skip_unreachable = s.drawing.skip_unreachable;
  drawing.redraw = s.drawing.redraw;
  drawing.dry_run = s.drawing.dry_run;
  drawing.placement = shape_placement(s.drawing.placement.centre_m);
  s.drawing = drawing;
  s.path.tolerance = s.path.rounding = 0.1 * kExact;
  const double force = s.control.normal_force;
  const ForceRange range = force_range(s);
  s.pen.least_force = std::min(s.pen.least_force, force * range.least);
  s.pen.most_force = std::max(s.pen.most_force, force * range.most);
  return s;
}

}  // namespace impedraw
