// A Cairo drawing with the same look in SVG and PNG: a titled frame with millimetre axes and a
// legend. Private to src/report.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <cairo.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

// Reduces the number of points of lines and curves for display. Private to src/report.

using Line2d = std::vector<Eigen::Vector2d>;

// Removes points that lie within `tolerance` of the remaining line; the ends stay. Works in one
// pass. From the last kept point, it intersects the wedges of directions that pass each following
// point within the tolerance. A point nearer than its predecessor ends the search, so a line that
// turns back keeps its tip.
Line2d decimated(const Line2d& line, double tolerance);

// Decimates all lines with one tolerance: the smallest finest · 2^(k/2) that leaves at most `most`
// points in total. Stops at about 200 times the finest. Returns the tolerance.
double decimate_to(std::vector<Line2d>& lines, double finest, std::size_t most);

// A curve thinned without losing peaks: each bin of steps keeps its smallest and largest value.

struct Envelope {
  std::vector<double> t, v;  // in order of time; NaN if a whole bin has no value
};

// Returns at most about `points` points: the smallest and the largest value of each bin, each at
// its own time. Short series stay complete. v(i) is the value at t[i].
Envelope envelope(std::span<const double> t, const std::function<double(std::size_t)>& v,
                  std::size_t points);

struct Colour {
  double r, g, b;
};
inline constexpr Colour kTextColour{0.13, 0.15, 0.18}, kFaintColour{0.42, 0.45, 0.50},
    kFrameColour{0.70, 0.72, 0.75};

struct LegendEntry {
  Colour colour;
  double width;  // of the line [mm]
  std::string text;
};

struct Sheet {
  std::string title, subtitle;
  Eigen::AlignedBox2d area;    // shown inside the frame, view coordinates (u right, v down) [mm]
  std::string u_name, v_name;  // axis titles
  double u_sign = 1.0, v_sign = 1.0;  // a tick at view coordinate c is labelled sign · c
  std::vector<LegendEntry> legend;
  std::function<void(cairo_t*)> content;  // draws in view coordinates, clipped to the frame
  int png_width = 1600;                   // [px]
};

// Writes `stem`.svg (one unit per millimetre) or `stem`.png (png_width wide), or both. Throws
// std::runtime_error naming the file if it cannot be written.
void write_svg(const Sheet& sheet, const std::filesystem::path& stem);
void write_png(const Sheet& sheet, const std::filesystem::path& stem);
void write_sheet(const Sheet& sheet, const std::filesystem::path& stem);

// Writes a picture of `size` [mm] as SVG and PNG. `draw` draws it in millimetres and is called once
// for each format. Throws as write_sheet().
void write_svg_and_png(const std::filesystem::path& stem, const Eigen::Vector2d& size,
                       int png_width, const std::function<void(cairo_t*)>& draw);

// Places of an axis's ticks from `low` to `high`, at a step of 1, 2 or 5 times a power of ten (at
// least 1) that divides `range` into at most eight. None where a number is not finite.
std::vector<double> ticks(double low, double high, double range);

Colour colour_from(std::uint32_t rgb);                       // 0xRRGGBB
Colour between(const Colour& a, const Colour& b, double t);  // t: 0 … 1
void set_colour(cairo_t* cr, const Colour& colour, double alpha = 1.0);
void round_lines(cairo_t* cr);                                  // caps and joins
void set_dash(cairo_t* cr, double on = 0.0, double off = 0.0);  // of 0: solid
void trace(cairo_t* cr, const Line2d& line);                    // adds it to the path
void stroke_line(cairo_t* cr, const Line2d& line);
void extend(Eigen::AlignedBox2d* box, const std::vector<Line2d>& lines);
double text_width(cairo_t* cr, const std::string& text);  // with the font that is set
// Text that begins at x, or with align 1 ends there. Returns its width.
double show_text(cairo_t* cr, double x, double y, const std::string& text, double align = 0.0);

void set_font(cairo_t* cr, double size, bool bold = false);

// The same in a font of this size.
double write_words(cairo_t* cr, double x, double y, const std::string& text, double size,
                   bool bold = false, double align = 0.0);

// An image of rows × columns pixels. `colour(row, column)` gives nothing where it is transparent.
using Raster = std::shared_ptr<cairo_surface_t>;
Raster raster(int rows, int columns,
              const std::function<std::optional<Colour>(int row, int column)>& colour);
// Deflates an image that pictures in SVG will show, once for all of them.
void keep_deflated(const Raster& image);
// Paints it, one user unit a pixel, from the origin to the right and down. `beyond`: what is
// painted outside.
void paint(cairo_t* cr, const Raster& image, cairo_filter_t filter,
           cairo_extend_t beyond = CAIRO_EXTEND_NONE);

// Makes fontconfig read its files, which the first text would wait for.
void load_fonts();

}  // namespace impedraw
