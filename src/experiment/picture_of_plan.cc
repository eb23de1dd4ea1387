#include "impedraw/experiment/picture_of_plan.h"
#include "impedraw/experiment/height_sources.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "impedraw/experiment/plan_limits.h"
#include "impedraw/experiment/plan_summary.h"
#include "impedraw/experiment/preview_of.h"
#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {

namespace {

// "off canvas", for a legend.
std::string words_of(Problem problem) {
  std::string words = name_of(problem);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

// Each part of a stroke where it lies on the surface, in P.
PlanLine plan_line(const PlacedStroke& stroke, const SurfaceHeight& surface, double z,
                   const std::string& problem) {
  PlanLine line{{}, problem};
  SurfaceHeight::Sample found;
  const auto add = [&](const Eigen::Vector2d& p) {
    const auto sample = surface(p.x(), p.y(), found);
    line.points.push_back(sample ? sample->p_P : Eigen::Vector3d(p.x(), p.y(), z));
  };
  const std::vector<Eigen::Vector2d>& corners = stroke.p_P;
  add(corners.front());
  Eigen::Vector2d last = corners.front();
  for (std::size_t k = 1; k < corners.size(); ++k) {
    const Eigen::Vector2d way = corners[k] - last;
    if (way.norm() < kPictureDetail && k + 1 < corners.size()) continue;
    const int pieces = std::max(1, static_cast<int>(std::ceil(way.norm() / kPictureSpacing)));
    for (int i = 1; i <= pieces; ++i) add(last + way * i / pieces);
    last = corners[k];
  }
  return line;
}

// The surface as the plan knows it: with cameras, that of the cloud, on a grid.
void add_surface(const PlannedDrawing& e, PlanPicture* picture) {
  const Pose X_PW = e.artwork.X_WP.inverse();
  if (!e.belief.perception) {
    if (e.belief.height_unknown()) return;
    for (const Eigen::Vector3d& v_W : e.belief.obstacle->mesh().vertices)
      picture->canvas_vertices.push_back(X_PW * v_W);
    picture->canvas_triangles = e.belief.obstacle->mesh().triangles;
    return;
  }
  TriangleMesh grid = surface_grid(e.surface(), e.belief.perception->cloud(), X_PW);
  picture->canvas_vertices = std::move(grid.vertices);
  picture->canvas_triangles = std::move(grid.triangles);
}

}  // namespace

std::vector<PlanLine> lines_of_findings(const PlannedDrawing& e, const SurfaceHeight& surface) {
  const Pose X_PW = e.artwork.X_WP.inverse();
  std::vector<PlanLine> lines;
  std::optional<StrokeRuler> ruler;
  for (const Finding& f : e.plan.preflight.findings) {
    const PlacedStroke& whole = e.artwork.strokes[static_cast<std::size_t>(f.part.stroke)];
    if (!ruler || &ruler->stroke() != &whole) ruler.emplace(whole);
    const PlacedStroke part = ruler->part(f.part.from, f.part.to);
    lines.push_back(plan_line(part, surface, (X_PW * f.p_W).z(), words_of(f.problem)));
  }
  return lines;
}

PlanPicture picture_of_plan(const PlannedDrawing& e, const SurfaceHeight& surface) {
  PlanPicture picture;
  picture.title = e.scenario.name;
  picture.subtitle = fmt::format(
      "{} strokes, {:.2f} m; {}", e.plan.requested.size(), e.plan.path.pen_down_length(),
      e.plan.preflight.findings.empty()
          ? "all can be drawn"
          : fmt::format("{:.0f} mm cannot be drawn", 1e3 * length_not_drawable(e)));
  add_surface(e, &picture);
  for (std::size_t i = 0; i < e.plan.strokes.size(); ++i) {
    picture.lines.push_back(plan_line(e.plan.strokes[i], surface, 0.0, ""));
    if (e.plan.pens) picture.lines.back().pen = e.plan.pens->number_of(static_cast<int>(i));
  }
  if (e.plan.pens && e.plan.pens->pens.size() > 1) {
    const std::vector<PenSum> sums = sums_of(*e.plan.pens, e.plan.strokes, e.plan.path);
    for (std::size_t k = 0; k < sums.size(); ++k) {
      const DrawnPen& pen = e.plan.pens->pens[k];
      picture.pens.push_back({pen_text(pen, sums[k]), pen.colour.value_or(0), pen.line.width});
    }
  }
  for (PlanLine& line : lines_of_findings(e, surface)) picture.lines.push_back(std::move(line));
  // The map of roughness: a dot for each point of the cloud.
  if (e.belief.perception) {
    const Pose X_PW = e.artwork.X_WP.inverse();
    PlanLine dot{{Eigen::Vector3d::Zero()}, "rougher than the cameras resolve"};
    for (const Eigen::Vector3d& p_W : e.belief.perception->cloud().points) {
      if (!is_unresolved(e.belief.perception->roughness(p_W))) continue;
      dot.points.front() = X_PW * p_W;
      picture.lines.push_back(dot);
    }
  }
  return picture;
}

}  // namespace impedraw
