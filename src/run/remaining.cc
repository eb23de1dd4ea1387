#include "impedraw/run/remaining.h"

#include <utility>

#include "impedraw/experiment/tool_fit.h"

namespace impedraw {
namespace {

double shortest_gap(const Experiment& e) { return std::max(kShortestGap, face_reach(e)); }

// The parts less what is taken out of them. Pieces of at most `shortest` [m] are dropped.
std::vector<StrokePart> less(const Experiment& e, const std::vector<StrokePart>& parts,
                             const std::vector<StrokePart>& taken, double shortest) {
  std::vector<StrokePart> gone = rest_of(e.plan.strokes, parts);
  gone.insert(gone.end(), taken.begin(), taken.end());
  return rest_of(e.plan.strokes, gone, shortest);
}

}  // namespace

double face_reach(const Experiment& e) {
  const ToolSettings& tool = e.scenario.tool;
  return tool.kind == ToolKind::pad ? 0.5 * tool.radius.value_or(PadSettings().radius) : 0.0;
}

bool overlaps(const StrokePart& part, const std::vector<StrokePart>& others) {
  return std::any_of(others.begin(), others.end(), [&part](const StrokePart& other) {
    return other.stroke == part.stroke && other.from < part.to && part.from < other.to;
  });
}

std::vector<PlacedStroke> strokes_of(const Experiment& e, const std::vector<StrokePart>& parts) {
  std::vector<PlacedStroke> strokes;
  for (const StrokePart& part : parts) {
    const PlacedStroke& whole = e.plan.strokes[static_cast<std::size_t>(part.stroke)];
    strokes.push_back(part.from <= 0.0 && part.to >= plane_length(whole)
                          ? whole
                          : part_of(whole, part.from - kRedrawOverlap, part.to + kRedrawOverlap));
  }
  return strokes;
}

std::vector<StrokePart> remaining(const Experiment& e, const InkWatch& ink,
                                  const std::vector<StrokePart>& given_up) {
  std::vector<StrokePart> done = ink.parts();
  done.insert(done.end(), given_up.begin(), given_up.end());
  return rest_of(e.plan.strokes, done, shortest_gap(e));
}

TipPath path_for(const Experiment& e, const std::vector<StrokePart>& parts,
                 const Eigen::Vector3d& p_KE, const Eigen::Vector3d& n_K, double hold,
                 const JointVector* q) {
  PathSettings settings = e.plan.path_settings;
  settings.highest_z = e.plan.path.highest_z();
  if (q) settings.heading = heading_of(e.scenario, e.belief.arm, *q);
  return plan_from(settings, e.surface(), strokes_of(e, parts), p_KE, n_K, hold,
                   stroke_limits(e.belief, e.plan, e.plan.path_settings));
}

void take_out(const Experiment& e, const OffSurface& off, std::vector<StrokePart>* parts) {
  const double at = nearest_place(e.plan.strokes[static_cast<std::size_t>(off.stroke)], off.p);
  std::vector<StrokePart> left = less(
      e, *parts, {{off.stroke, at - OffSurface::kAbout, at + OffSurface::kAbout}}, kShortestGap);
  if (plane_length(strokes_of(e, left)) >= plane_length(strokes_of(e, *parts))) throw;
  *parts = std::move(left);
}

TipPath path_without_misses(const Experiment& e, std::vector<StrokePart>* parts,
                            const Eigen::Vector3d& p_KE, const Eigen::Vector3d& n_K, double hold,
                            const JointVector* q) {
  return without_misses(e, parts, [&](const std::vector<StrokePart>& left) {
    return left.empty() ? TipPath{} : path_for(e, left, p_KE, n_K, hold, q);
  });
}

TipPath checked_path(const Experiment& e, std::vector<StrokePart>* parts,
                     const Eigen::Vector3d& p_KE, const Eigen::Vector3d& n_K, double hold,
                     const JointVector& q, BlockedPlaces* blocked) {
  PreflightSettings checks =
      preflight_settings(e.scenario, e.artwork.X_WP, e.belief.perception != nullptr, e.plan.rest_q);
  checks.normal_force = e.plan.load.normal_force;
  checks.height_error = height_error(e.belief);
  while (true) {
    TipPath path = path_without_misses(e, parts, p_KE, n_K, hold, &q);
    if (parts->empty() || !e.scenario.preflight.arm) return path;
    std::vector<PlacedStroke> strokes = strokes_of(e, *parts);
    for (std::size_t i = 0; i < strokes.size(); ++i) strokes[i].number = static_cast<int>(i);
    const std::vector<Finding> barred =
        check_transitions(path, strokes, e.belief.arm, e.belief.obstacle.get(), q, checks);
    if (barred.empty()) return path;
    for (const Finding& f : barred) {
      const StrokePart& stroke = (*parts)[static_cast<std::size_t>(f.part.stroke)];
      if (f.way == WayEnd::none)
        blocked->add_unreached({stroke.stroke, f.part.from, f.part.to});
      else
        blocked->add_stroke(stroke);
    }
    *parts = less(e, *parts, blocked->parts(), shortest_gap(e));
  }
}

}  // namespace impedraw
