// Artwork as the rest of the program sees it: strokes on a page.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

// One pen-down line on the page: x to the right, y down (as in SVG), millimetres.
struct Stroke {
  std::vector<Eigen::Vector2d> points;  // [mm], at least one; consecutive points differ
  bool closed = false;                  // the last point repeats the first
  int layer = 0;                        // index into Artwork::layers
};

struct Artwork {
  std::string name;                        // "sine", or the file's name
  std::vector<Stroke> strokes;
  std::vector<std::string> layers;         // at least one where there are strokes
  Eigen::AlignedBox2d page;                // [mm]; of the viewport where the artwork has one, else of its strokes
  std::vector<std::string> warnings;       // what the artwork asks for and does not get
};

}  // namespace impedraw
