// Artwork as the rest of the program sees it: strokes on a page, and what the page says beyond them
// of how they look.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

// One pen-down line on the page: x to the right, y down (as in SVG), millimetres.
struct Stroke {
  std::vector<Eigen::Vector2d> points = {};  // [mm], at least one; consecutive points differ
  bool closed = false;                       // the last point repeats the first
  int layer = 0;                             // index into Artwork::layers
  int dash = -1;      // index into Artwork::dashes; −1: unbroken. Applied by dashes.h
  bool edge = false;  // the outline of an area that is filled, not stroked
};

// How a line is broken: lengths drawn and left out in turn, endlessly.
struct Dash {
  std::vector<double>
      lengths;        // [pattern's unit], an even number of them, none negative, their sum > 0
  double offset = 0;  // where in the pattern a line begins [pattern's unit]
  Eigen::Matrix2d to_pattern = Eigen::Matrix2d::
      Identity();     // [pattern's unit per mm]: of a way on the page; its length counts
  bool dots = false;  // lengths of 0 are drawn, as dots
};

// What a fill covers.
struct Area {
  std::vector<std::vector<Eigen::Vector2d>>
      outlines;           // [mm], each closed by a line from its last point to its first
  bool even_odd = false;  // else by winding number
  int layer = 0;
};

struct Artwork {
  std::string name = {};  // "sine", or the file's name
  std::vector<Stroke> strokes = {};
  std::vector<std::string> layers = {};  // at least one where there are strokes
  // [mm]; of the viewport where the artwork has one, else of its strokes
  Eigen::AlignedBox2d page = {};
  std::vector<std::string> warnings = {};  // what the artwork asks for and does not get
  std::vector<Dash> dashes = {};
  std::vector<Area> areas = {};  // in the order in which they are painted
};

// Layers are pens: one without strokes is none.
void drop_empty_layers(Artwork& artwork);

struct StrokeStatistics {
  std::size_t strokes = 0, points = 0;
  double pen_down_mm = 0;  // length of the strokes
  // of the straight ways from one's end to the next one's start, in the order they have
  double pen_up_mm = 0;
};
StrokeStatistics stroke_statistics(const std::vector<Stroke>& strokes);

}  // namespace impedraw
