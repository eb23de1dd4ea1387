#include "impedraw/experiment/artwork.h"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "impedraw/common/roll_pitch_yaw.h"
#include "impedraw/drawing/artwork_file.h"
#include "impedraw/drawing/bounded.h"
#include "impedraw/drawing/dashes.h"
#include "impedraw/drawing/hershey.h"
#include "impedraw/drawing/joined.h"
#include "impedraw/drawing/order.h"
#include "impedraw/drawing/simplify.h"
#include "impedraw/experiment/hatch_surface.h"

namespace impedraw {
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

void break_dashes(Artwork& artwork, bool apply) {
  const auto broken = [](const Stroke& stroke) { return stroke.dash >= 0; };
  if (apply) {
    artwork.strokes = dashed(artwork.strokes, artwork.dashes);
  } else if (const auto count =
                 std::count_if(artwork.strokes.begin(), artwork.strokes.end(), broken)) {
    artwork.warnings.push_back(fmt::format("{} dashed lines are drawn solid", count));
    for (Stroke& stroke : artwork.strokes) stroke.dash = -1;
  }
  artwork.dashes.clear();
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
  setting_errors.locate({"drawing.dashes", "drawing.svg"},
                        [&] { break_dashes(artwork, s.dashes); });

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

  setting_errors.locate({"drawing.hatch", "drawing.dashes", "drawing.svg", "drawing"},
                        [&] { require_few(artwork); });
  if (s.simplify_mm > 0.0) {
    for (Stroke& stroke : artwork.strokes) stroke = simplified(stroke, s.simplify_mm);
  }
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
