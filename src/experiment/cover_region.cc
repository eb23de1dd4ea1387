#include "impedraw/experiment/cover_region.h"

#include <fmt/format.h>

#include "impedraw/canvas/mesh_file.h"
#include "impedraw/common/file_extension.h"
#include "impedraw/drawing/artwork_file.h"
#include "impedraw/drawing/layers.h"
#include "impedraw/drawing/regions.h"
#include "impedraw/experiment/place_wish.h"

namespace impedraw {
namespace {

// The vertices under the faces of a colour, of a mesh that is placed as canvas.mesh is.
std::vector<char> painted(const Scenario& s, const SurfaceGrid& g, const Pose& X_WP) {
  CanvasSettings placed = s.canvas;
  placed.kind = CanvasKind::mesh;
  placed.mesh.file = s.cover.region;
  const Canvas faces(make_mesh(placed));
  const Eigen::Vector3d up = X_WP.R.col(2);
  std::vector<char> inside(g.size(), 0);
  for (std::size_t v = 0; v < g.size(); ++v) {
    if (!g.known[v]) continue;
    const auto hit = faces.ray(X_WP * g.point(v) + kJudged * up, -up);
    inside[v] = hit && hit->t <= 2.0 * kJudged;
  }
  return inside;
}

}  // namespace

CoverRegion region_of(const Scenario& s, const SurfaceGrid& g, const Pose& X_WP) {
  if (is_mesh_file(s.cover.region)) return {painted(s, g, X_WP), {}};
  if (lower_extension(s.cover.region) != ".svg")
    throw InputError(s.cover.region.string() + ": valid is an .svg with filled areas, or a mesh " +
                     "with a colour of six hexadecimal digits, as part.ply#c01020");
  Artwork artwork = read_artwork(
      s.cover.region,
      {.may_be_empty = true, .visible = s.drawing.visible, .layers = s.drawing.layers});
  if (!s.drawing.layer.empty()) choose_layers(artwork, s.drawing.layer);
  // An area is as it is painted; the lines about it, which the rest of these tell of, do not count.
  std::vector<std::string>& left_out = artwork.warnings;
  std::erase_if(left_out, [](const std::string& w) { return w.find("lines ") != w.npos; });
  if (artwork.areas.empty())
    throw InputError(fmt::format("{}: has no filled area to cover{}; valid is an SVG with one",
                                 s.cover.region.string(),
                                 left_out.empty() ? "" : " (" + left_out.front() + ")"));
  // A region has a middle, unlike the shape that this drawing would be without it.
  PlacementSettings placing = placement_settings(s.drawing);
  placing.about_page_origin = s.drawing.placement.about_page_origin;
  const Placement placement = place(artwork, placing);
  Eigen::AlignedBox2d box = artwork.page;
  for (const Area& area : artwork.areas)
    for (const auto& outline : area.outlines)
      for (const Eigen::Vector2d& p : outline) box.extend(p);
  const RegionMath math(box);
  std::vector<Eigen::Vector2d> page(g.size());
  for (std::size_t v = 0; v < g.size(); ++v) page[v] = placement.to_page(g.plane(v));
  CoverRegion region{std::vector<char>(g.size(), 0), std::vector<double>(g.size(), 0.0),
                     artwork.warnings};
  for (const Area& area : artwork.areas) {
    const RegionIndex index(math.region(area));
    for (std::size_t v = 0; v < g.size(); ++v) {
      if (!index.inside(page[v])) continue;
      region.inside[v] = 1;
      const double tone = area.tone_at ? area.tone_at(page[v]) : area.tone;
      region.tones[v] += (1.0 - region.tones[v]) * tone;
    }
  }
  return region;
}

}  // namespace impedraw
