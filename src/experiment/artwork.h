// Stage 1 of an experiment, Scenario → PlacedArtwork: what is drawn, and where it lies before the
// arm. The artwork is read or set, broken into dashes, hatched, simplified, put in the order in
// which it is drawn, and laid on the drawing plane.
#pragma once

#include <string>
#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/drawing/shapes.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/settings/setting_error.h"

namespace impedraw {

struct PlacedArtwork {
  Shape shape;          // as drawn and as desired, on the page
  Placement placement;  // of the page on the drawing plane
  Pose X_WP;            // drawing frame P, z out of the drawing plane
  // Both flat on the drawing plane and numbered as the artwork's strokes.
  std::vector<PlacedStroke> strokes;  // as drawn
  std::vector<PlacedStroke> desired;  // as they ought to come out
  std::vector<std::string> notes;     // what is not drawn as the artwork asks for; a line each
};

// Throws InputError, with where the setting to setting_errors was given.
PlacedArtwork load_artwork(const DrawingSettings& settings, const SettingErrors& setting_errors);

// X_WP: the drawing plane turned by its tilt about W's origin.
Pose drawing_frame(const DrawingSettings& settings);

// What a placement is made from: errors about where the drawing lies are about these.
const std::vector<std::string>& placement_setting_names();

// Where the drawing goes. Built-in shapes lie about the page's origin; they, and text whose size is
// given, keep their size (scale 1) unless the placement says one. Everything else is placed as it
// is asked for.
PlacementSettings placement_settings(const DrawingSettings& settings);

// The same settings give the same artwork. For a built-in shape it is the shape; else from the file
// or the text, in this order: ends joined, dashes, hatch (spaced on the canvas, whence the
// placement's scale counts), simplified, ordered; the target is then what is drawn. Its warnings
// tell what is not drawn as the artwork asks for. InputError, with where the setting to
// setting_errors was given.
Shape make_artwork(const DrawingSettings& settings, const SettingErrors& setting_errors);

}  // namespace impedraw
