// ./impedraw place: a page on 127.0.0.1 that shows the object, on which the drawing is dragged,
// turned and scaled, and tells at once what of it can be drawn. Saving writes a scenario.
//
// Questions of the page, and of anybody without one (--headless), each with a placement
// {"x", "y": of the drawing's middle in the drawing plane [m], "turn": from the given one [deg],
// "size": times the given one}:
//   check   what of it can be drawn, quickly:
//           {"share", "length_mm", "time_s", "width_mm", "height_mm", "lost_mm": {trouble: mm}}
//   plan    the same share, by the whole pre-flight, which takes seconds: {"share"}
//   save    writes the scenario: {"file"}; "overwrite": true replaces a file that is there
//   end     ends the command
#pragma once

#include <filesystem>

#include "impedraw/experiment/draw_options.h"

namespace impedraw {

struct PlaceOptions {
  std::filesystem::path save = "placed.yaml";
  int port = 0;           // 0: a free one
  bool headless = false;  // no browser is opened
};

// options.scenario may name a mesh in place of a scenario. Returns at ctrl-C or `end`.
int place_by_hand(DrawOptions options, const PlaceOptions& place);

}  // namespace impedraw
