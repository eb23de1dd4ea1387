// The command-line options of a drawing, and the scenario they resolve to.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "impedraw/experiment/place_surface.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

struct DrawOptions {
  std::filesystem::path scenario;
  // Of this program, where none is named; no message cites it. Empty: the standard bowl, with the
  // sine (bowl-sine.yaml) or with svg or text (artwork.yaml).
  std::filesystem::path built_in;
  std::string shape;
  std::filesystem::path svg;
  std::filesystem::path image;  // a picture to draw, in place of svg
  bool trace = false;           // centre lines
  std::string text;             // to draw
  bool no_perception = false;
  std::string layer;              // that are drawn, by number or name; empty: all
  bool keep_order = false;        // of a file's strokes
  bool skip_unreachable = false;  // omits what fails the pre-flight
  // fixed; auto: of the canvas; surface: of the drawing on it; empty: auto where an arm of one's
  // own cannot draw on the canvas and the scenario does not place it.
  std::string place;
  SurfaceWish surface;                   // for place surface
  bool resume = false;                   // continues the run in `out`
  bool overwrite = false;                // replaces a finished run in `out`
  std::string arm;                       // sim, iiwa-lcm, franka; empty: as the scenario says
  std::filesystem::path out;             // empty: runs/<name> in the working directory
  std::vector<std::string> assignments;  // --set
};

// The scenario with all command-line options applied. `places` gets the source location of each
// setting. Throws InputError.
Scenario resolve(const DrawOptions& options, Places* places = nullptr);

}  // namespace impedraw
