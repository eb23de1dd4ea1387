// Artwork in the form that the rest of the program uses: strokes on a page, with their layers,
// dashes and filled areas.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

// Limits of a file: points, each this far from the page's origin at most [mm]. usvg's single
// precision is off by 0.1 mm there.
inline constexpr std::size_t kMostPoints = 5'000'000;
inline constexpr double kFarthest = 1e6;

// The part of an SVG that is drawn: what the eye sees, or all as if nothing were hidden.
enum class Visible { as_painted, all };

// One pen-down line on the page: x to the right, y down (as in SVG), millimetres.
struct Stroke {
  std::vector<Eigen::Vector2d> points = {};  // [mm], at least one; consecutive points differ
  bool closed = false;                       // the last point repeats the first
  int layer = 0;                             // index into Artwork::layers
  int dash = -1;             // index into Artwork::dashes; −1: unbroken. Applied by dashes.h
  bool edge = false;         // the outline of an area that is filled, not stroked
  std::uint32_t colour = 0;  // 0xRRGGBB
  double width = 0;          // as painted [mm]; 0: not known
  // Weight of the line at each point; empty: `width` all along. Widths [mm], or forces [N].
  std::vector<double> press = {};
  bool by_force = false;  // press holds forces
};

// A stroke with other points and the same layer, dash, colour and width; press is left empty.
Stroke like(const Stroke& stroke, std::vector<Eigen::Vector2d> points = {}, bool closed = false);

// A dash pattern: lengths drawn and left out alternate, and the pattern repeats.
struct Dash {
  // [pattern's unit]; an even number of them, none negative, their sum > 0
  std::vector<double> lengths;
  double offset = 0;  // where in the pattern a line starts [pattern's unit]
  // maps a displacement on the page to the pattern, which measures its length [pattern's unit/mm]
  Eigen::Matrix2d to_pattern = Eigen::Matrix2d::Identity();
  bool dots = false;  // lengths of 0 are drawn as dots
};

// A filled region.
struct Area {
  // [mm]; each is closed by a line from its last point to its first
  std::vector<std::vector<Eigen::Vector2d>> outlines;
  bool even_odd = false;  // fill rule; else nonzero winding
  int layer = 0;
  std::uint32_t colour = 0;  // 0xRRGGBB
  // The share of the white paper that a hatch inks: 0 nothing, 1 all. One that varies gives it at a
  // point of the page; none: even.
  double tone = 1;
  std::function<double(const Eigen::Vector2d& page_mm)> tone_at = {};
};

struct Artwork {
  std::string name = {};  // "sine", or the file's name
  std::vector<Stroke> strokes = {};
  std::vector<std::string> layers = {};  // at least one if there are strokes
  // the viewport's box if the artwork has one, else that of its strokes [mm]
  Eigen::AlignedBox2d page = {};
  std::vector<std::string> warnings = {};  // features of the artwork that are not drawn
  std::vector<Dash> dashes = {};
  std::vector<Area> areas = {};  // in painting order
  double hidden_mm = 0;          // length that clip paths, masks and what lies above hide: left out
  double doubled_mm = 0;         // length that lay on other strokes: left out
};

// Removes layers without strokes, unless they have areas that are to be filled: layers are pens.
void drop_empty_layers(Artwork& artwork, bool keep_areas = false);

struct StrokeStatistics {
  std::size_t strokes = 0, points = 0;
  double pen_down_mm = 0;  // length of the strokes
  // length of the straight moves from each stroke's end to the next one's start
  double pen_up_mm = 0;
};
StrokeStatistics stroke_statistics(const std::vector<Stroke>& strokes);

// The box of all points [mm]; empty without strokes.
Eigen::AlignedBox2d bounds_of(const std::vector<Stroke>& strokes);

}  // namespace impedraw
