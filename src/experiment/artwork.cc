#include "impedraw/experiment/artwork.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "impedraw/common/rotations.h"
#include "impedraw/drawing/artwork_file.h"
#include "impedraw/drawing/bounded.h"
#include "impedraw/drawing/dashes.h"
#include "impedraw/drawing/hershey.h"
#include "impedraw/drawing/joined.h"
#include "impedraw/drawing/order.h"
#include "impedraw/drawing/polyline.h"
#include "impedraw/planning/cover/surface_grid.h"

namespace impedraw {
namespace {

constexpr double kGridStep = 3e-3, kMostPlaces = 4e4;  // of the grid [m]; asked for
constexpr double kSteepest = 80.0;                     // beyond it is an edge [deg]
constexpr double kRingStep = 1.0 / 3.0;                // of the grid for rings [spacings]
constexpr double kMostRingPlaces = 1e6;
constexpr double kSeedReach = 2.0;  // of seeds from where the distance is 0 [steps]

using Eigen::Vector2d;

// The same surface, about a box.
SurfaceGrid resampled(const SurfaceGrid& grid, Eigen::AlignedBox2d box, double step) {
  box.extend(box.min() - Vector2d::Constant(3 * step));
  box.extend(box.max() + Vector2d::Constant(3 * step));
  const SurfaceHeight heights = [&grid](double x, double y) -> SurfaceHeight::Sample {
    return SurfaceSample{grid.lifted({x, y}), Eigen::Vector3d::UnitZ()};  // slopes do not matter
  };
  return sample_surface(heights, box, step, kSteepest);
}

// Distances to the vertices about a segment in the plane.
void seed(const SurfaceGrid& grid, const Vector2d& a, const Vector2d& b,
          std::vector<double>* seeds) {
  const Vector2d reach = Vector2d::Constant(kSeedReach * grid.step);
  const Vector2d low = (a.cwiseMin(b) - reach - grid.low) / grid.step,
                 high = (a.cwiseMax(b) + reach - grid.low) / grid.step;
  for (int j = std::max(0, static_cast<int>(low.y())); j <= std::min(grid.ny - 1.0, high.y()); ++j)
    for (int i = std::max(0, static_cast<int>(low.x())); i <= std::min(grid.nx - 1.0, high.x());
         ++i) {
      const std::size_t v = grid.index(i, j);
      const Vector2d p = grid.plane(v);
      const Vector2d foot = nearest_on_segment(a, b, p);
      if ((p - foot).norm() <= kSeedReach * grid.step)
        (*seeds)[v] = std::min((*seeds)[v], (grid.point(v) - grid.lifted(foot)).norm());
    }
}

std::vector<HatchLine> rings_on(const SurfaceGrid& surface, const Placement& placement,
                                const Outlines& region, HatchStyle style, double spacing_mm) {
  std::vector<HatchLine> lines;
  Outlines outlines = region;
  for (auto& outline : outlines)
    for (Vector2d& p : outline) p = placement.to_plane(p);
  const Eigen::AlignedBox2d box = outlines_box(outlines);
  if (box.isEmpty()) return lines;
  const double spacing = spacing_mm * placement.scale() / 1e3;  // [m]
  const double step =
      std::max(kRingStep * spacing, std::sqrt(box.sizes().prod() / kMostRingPlaces));
  const SurfaceGrid grid = resampled(surface, box, step);
  std::vector<double> seeds(grid.size(), kFar);
  if (style == HatchStyle::concentric) {
    seed(grid, box.center(), box.center(), &seeds);
  } else {
    for (const auto& outline : outlines)
      for (std::size_t i = 0; i < outline.size(); ++i)
        seed(grid, outline[i], outline[(i + 1) % outline.size()], &seeds);
  }
  const std::vector<double> distance = surface_distance(grid, std::move(seeds));
  const double rows =
      require_few_rows(*std::max_element(distance.begin(), distance.end()), spacing);
  for (double k = 0; k + 0.5 < rows; ++k)
    for (std::vector<Vector2d>& line : level_lines(grid, distance, (k + 0.5) * spacing)) {
      const bool closed = is_closed(line);
      for (Vector2d& p : line) p = placement.to_page(p);
      if (closed) line.back() = line.front();
      lines.push_back({std::move(line), static_cast<std::int64_t>(k)});
    }
  return lines;
}

}  // namespace

HatchSurface hatch_surface(const SurfaceHeight& surface, const Placement& placement,
                           const std::vector<Area>& areas) {
  Eigen::AlignedBox2d box;
  for (const Area& area : areas)
    for (const auto& outline : area.outlines)
      for (const Vector2d& p : outline) box.extend(placement.to_plane(p));
  const double step = std::max(kGridStep, std::sqrt(box.sizes().prod() / kMostPlaces));
  box.extend(box.min() - Vector2d::Constant(2 * step));
  box.extend(box.max() + Vector2d::Constant(2 * step));
  const auto grid =
      std::make_shared<const SurfaceGrid>(sample_surface(surface, box, step, kSteepest));
  HatchSurface on;
  on.distances = [grid, placement, middle = Vector2d(box.center())](const Vector2d& across) {
    const Vector2d rising = (placement.A * across).normalized();
    const auto distance = std::make_shared<const std::vector<double>>(
        distance_across(*grid, middle, {rising.y(), -rising.x()}));
    const double of_middle = across.dot(placement.to_page(middle)), mm = 1e3 / placement.scale();
    return [grid, distance, placement, of_middle, mm](const Vector2d& page_mm) {
      return of_middle + mm * grid->sample(*distance, placement.to_plane(page_mm));
    };
  };
  on.rings = [grid, placement](const Outlines& region, HatchStyle style, double spacing_mm) {
    return rings_on(*grid, placement, region, style, spacing_mm);
  };
  return on;
}

namespace {

Artwork given_artwork(const DrawingSettings& s, const SettingErrors& setting_errors) {
  if (s.svg.empty()) {
    setting_errors.locate({"drawing.text.font"}, [&] { read_hershey_font(s.text.font); });
    return setting_errors.locate({"drawing.text.text", "drawing.text", "drawing"},
                                 [&] { return make_text(s.text); });
  }
  if (!s.text.text.empty()) {
    setting_errors.raise({"drawing.text.text", "drawing.svg"},
                         "drawing.svg and drawing.text.text are both given; give one of them");
  }
  return setting_errors.locate({"drawing.svg", "drawing.unit"}, [&] {
    const bool single = s.text.as == SvgText::single;
    return read_artwork(s.svg,
                        {.visible = s.visible,
                         .layers = s.layers,
                         .single_font = single ? s.text.font : std::string()},
                        s.unit);
  });
}

// Bounds of a drawing: more takes a day to draw.
constexpr std::size_t kMostPoints = 5'000'000, kMostStrokes = 100'000;
constexpr double kLongestDrawing = 1000.0;  // [m] in the drawing plane

void require_few(const Artwork& artwork) {
  std::size_t points = 0;
  for (const Stroke& stroke : artwork.strokes) points += stroke.points.size();
  const auto refuse = [&](std::size_t count, const char* of, std::size_t most) {
    throw InputError(fmt::format("{}: {} {}, at most {} are drawn", artwork.name, count, of, most));
  };
  if (artwork.strokes.size() > kMostStrokes)
    refuse(artwork.strokes.size(), "strokes", kMostStrokes);
  if (points > kMostPoints) refuse(points, "points", kMostPoints);
}

void require_short(const std::vector<PlacedStroke>& strokes, const std::string& name) {
  double length = 0.0;
  for (const PlacedStroke& stroke : strokes) length += plane_length(stroke);
  if (length > kLongestDrawing)
    throw InputError(
        fmt::format("{}: {:.0f} m of strokes, at most {:.0f} m are drawn; draw it "
                    "smaller or in parts",
                    name, length, kLongestDrawing));
}

void hatch_in_time(const HatchSettings& settings, double scale, const HatchSurface& on,
                   Artwork* artwork) {
  constexpr double kSeconds = 30;  // of CPU time
  const auto shared = std::make_shared<Artwork>(std::move(*artwork));
  if (!done_within(kSeconds, [=] { apply_hatch(*shared, settings, scale, on); }))
    throw InputError(fmt::format(
        "{}: takes longer than {:.0f} s to hatch; a wider drawing.hatch.spacing takes less",
        shared->name, kSeconds));
  *artwork = std::move(*shared);
}

}  // namespace

PlacementSettings placement_settings(const DrawingSettings& s) {
  PlacementSettings placing = s.placement;
  const bool shape = s.svg.empty() && s.text.text.empty(),
             sized_text = s.svg.empty() && s.text.size_mm;
  if (shape) placing.about_page_origin = true;
  if ((shape || sized_text) && !has_size(placing)) placing.scale = 1.0;
  return placing;
}

Shape make_artwork(const DrawingSettings& s, const SettingErrors& setting_errors,
                   const std::function<void(double)>& progress, const SurfaceHeight* surface) {
  if (s.svg.empty() && s.text.text.empty()) return make_shape(s.shape);
  Artwork artwork = given_artwork(s, setting_errors);
  if (!s.layer.empty())
    setting_errors.locate({"drawing.layer"}, [&] { choose_layers(artwork, s.layer); });
  setting_errors.locate({"drawing.svg", "drawing.text.text", "drawing"},
                        [&] { require_few(artwork); });
  setting_errors.locate({"drawing.svg"},
                        [&] { artwork.strokes = dashed(artwork.strokes, artwork.dashes); });
  artwork.dashes.clear();

  if (!s.hatch.outline) drop_edges(artwork);
  if (s.hatch.spacing_mm > 0.0 && !artwork.areas.empty()) {
    // The areas count for the size, so that it is the same before and after.
    const Placement placement = setting_errors.locate(
        {"drawing.placement", "drawing"}, [&] { return place(artwork, placement_settings(s)); });
    const HatchSurface on = surface && hatches_surface(s)
                                ? hatch_surface(*surface, placement, artwork.areas)
                                : HatchSurface();
    setting_errors.locate({"drawing.hatch", "drawing"},
                          [&] { hatch_in_time(s.hatch, placement.scale(), on, &artwork); });
  } else if (!s.hatch.outline) {
    artwork.areas.clear();
    drop_empty_layers(artwork);
  }
  if (artwork.strokes.empty()) {
    setting_errors.raise(
        {"drawing.hatch", "drawing.svg"},
        fmt::format(
            "{}: nothing is left to draw: there are neither dashes nor outlines of filled areas; "
            "hatching draws areas",
            artwork.name));
  }

  setting_errors.locate({"drawing.hatch", "drawing.svg", "drawing"}, [&] { require_few(artwork); });
  if (!s.keep_order) {
    artwork.strokes = joined(std::move(artwork.strokes));
    artwork.strokes = in_order(artwork.strokes, shortest_order(artwork.strokes, {}, progress));
  }
  return {std::move(artwork)};
}

bool hatches_surface(const DrawingSettings& s) {
  return s.hatch.spacing_mm > 0.0 && s.mapping == Mapping::project && !s.svg.empty();
}

Pose drawing_frame(const DrawingSettings& s) {
  return {Eigen::Vector3d::Zero(), rotation_from_roll_pitch_yaw(s.tilt_deg).toRotationMatrix()};
}

const std::vector<std::string>& placement_setting_names() {
  static const std::vector<std::string> names = {"drawing.placement.scale",
                                                 "drawing.placement.width",
                                                 "drawing.placement.height",
                                                 "drawing.placement.fit_width",
                                                 "drawing.placement.fit_height",
                                                 "drawing.placement.fit_radius",
                                                 "drawing.placement.centre",
                                                 "drawing.placement",
                                                 "canvas",
                                                 "drawing"};
  return names;
}

PlacedArtwork load_artwork(const DrawingSettings& s, const SettingErrors& setting_errors,
                           const std::function<void(double)>& progress,
                           const SurfaceHeight* surface) {
  PlacedArtwork artwork;
  artwork.shape = make_artwork(s, setting_errors, progress, surface);
  artwork.placement = setting_errors.locate(
      placement_setting_names(), [&] { return place(artwork.shape.drawn, placement_settings(s)); });
  artwork.X_WP = drawing_frame(s);
  artwork.strokes = placed_strokes(artwork.shape.drawn, artwork.placement);
  setting_errors.locate(placement_setting_names(),
                        [&] { require_short(artwork.strokes, artwork.shape.drawn.name); });
  if (artwork.shape.ideal) artwork.ideal = placed_strokes(*artwork.shape.ideal, artwork.placement);
  artwork.notes = artwork.shape.drawn.warnings;
  return artwork;
}

}  // namespace impedraw
