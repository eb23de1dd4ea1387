// What a scenario draws, made ready: read or set, broken into dashes, hatched, simplified, and put
// in the order in which it is drawn.
#pragma once

#include "impedraw/drawing/shapes.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/settings/setting_error.h"

namespace impedraw {

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
