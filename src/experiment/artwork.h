// Stage 1 of an experiment, Scenario → PlacedArtwork: what is drawn, and where. The artwork is read
// from a file or typeset, split into dashes, hatched, ordered for drawing, and placed
// on the drawing plane.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/drawing/hatch.h"
#include "impedraw/drawing/placement.h"
#include "impedraw/drawing/shapes.h"
#include "impedraw/drawing/stroke.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/planning/surface_height.h"
#include "impedraw/settings/setting_error.h"

namespace impedraw {

// Hatch lines that lie evenly on the surface over a placed page (drawing/hatch.h): by distances
// along it (planning/cover/surface_grid.h).

// For a page that is projected. Where there is no surface, the one about that place is continued.
// Rings are level lines of the distance from an area's outline or middle, on a grid of a third of
// the spacing: their corners are cut by that much.
HatchSurface hatch_surface(const SurfaceHeight& surface, const Placement& placement,
                           const std::vector<Area>& areas);

struct PlacedArtwork {
  Shape shape;          // as drawn and as desired, on the page
  Placement placement;  // of the page on the drawing plane
  Pose X_WP;            // drawing frame P, z out of the drawing plane
  // Both are flat on the drawing plane and numbered like the artwork's strokes.
  std::vector<PlacedStroke> strokes;               // as drawn
  std::optional<std::vector<PlacedStroke>> ideal;  // the ideal result, where it is another
  std::vector<std::string> notes;                  // deviations from the artwork, one line each

  const std::vector<PlacedStroke>& desired() const { return ideal ? *ideal : strokes; }
};

// `progress`: called now and then with the share of the ordering, which takes longest. `surface`:
// that hatch lines lie evenly on; null: on the drawing plane. Throws InputError with the setting's
// source location, from setting_errors.
PlacedArtwork load_artwork(const DrawingSettings& settings, const SettingErrors& setting_errors,
                           const std::function<void(double)>& progress = {},
                           const SurfaceHeight* surface = nullptr);

// True if the artwork depends on the surface.
bool hatches_surface(const DrawingSettings& settings);

// X_WP: the drawing plane, rotated by its tilt about W's origin.
Pose drawing_frame(const DrawingSettings& settings);

// The settings that determine the placement. Placement errors refer to these.
const std::vector<std::string>& placement_setting_names();

// The placement of the drawing. Built-in shapes lie around the page's origin. Built-in shapes,
// and text with a given size, keep their size (scale 1) unless the placement sets a scale.
// Everything else is placed as the settings specify.
PlacementSettings placement_settings(const DrawingSettings& settings);

// Makes a built-in shape, or processes the file or text in this order: join ends, dash, hatch,
// order. Hatch lines are spaced on the canvas, so the placement's scale matters. The
// target is then what is drawn. Warnings report deviations from the artwork. Deterministic. Throws
// InputError with the setting's source location, from setting_errors.
Shape make_artwork(const DrawingSettings& settings, const SettingErrors& setting_errors,
                   const std::function<void(double)>& progress = {},
                   const SurfaceHeight* surface = nullptr);

}  // namespace impedraw
