#include "impedraw/report/distortion_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <cairo.h>
#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/report/sheet.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
constexpr Colour kStroke{0.09, 0.24, 0.52};
constexpr std::array<Colour, 5> kScale{{{0.96, 0.95, 0.91},
                                        {0.99, 0.85, 0.58},
                                        {0.96, 0.62, 0.31},
                                        {0.82, 0.31, 0.18},
                                        {0.48, 0.08, 0.14}}};

Colour colour_of(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * (kScale.size() - 1);
  const std::size_t k = std::min(static_cast<std::size_t>(at), kScale.size() - 2);
  const double s = at - static_cast<double>(k);
  return between(kScale[k], kScale[k + 1], s);
}

// One value per vertex of the patch.
struct Errors {
  std::vector<double> projected, wrapped;
};

Errors errors_of(const FlatChart& chart) {
  Errors errors;
  for (const SurfaceSample& sample : chart.patch().samples) {
    errors.projected.push_back(stretch_of_projection(sample).length_error());
    errors.wrapped.push_back(stretch_of_wrap(sample, chart).length_error());
  }
  return errors;
}

// End of the colour scale: the smallest round number above nearly all errors. A few vertices at a
// rim must not make the rest of the map pale.
double scale_end(const Errors& errors) {
  std::vector<double> all = errors.projected;
  all.insert(all.end(), errors.wrapped.begin(), errors.wrapped.end());
  const auto high =
      all.begin() + static_cast<std::ptrdiff_t>(0.995 * static_cast<double>(all.size() - 1));
  std::nth_element(all.begin(), high, all.end());
  for (double decade = 0.001; decade < 100; decade *= 10) {
    for (const double step : {1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 7.5}) {
      if (step * decade >= *high) return step * decade;
    }
  }
  return 100;
}

Vector2d view(const Vector2d& plane) { return {-1e3 * plane.y(), -1e3 * plane.x()}; }

// One pixel per cell, the mean of its corners; up is +x.
void draw_map(cairo_t* cr, const SurfacePatch& patch, const std::vector<double>& error,
              double end) {
  const int width = patch.rows - 1, height = patch.columns - 1;
  // upper left in the view
  const Vector2d far = view(patch.corner + patch.spacing * Vector2d(height, width));
  cairo_save(cr);
  cairo_translate(cr, far.x(), far.y());
  cairo_scale(cr, 1e3 * patch.spacing, 1e3 * patch.spacing);
  const Raster map = raster(height, width, [&](int row, int column) -> std::optional<Colour> {
    const int n = patch.node(height - 1 - row, width - 1 - column);
    if (!patch.cell[n]) return std::nullopt;
    double sum = 0;
    for (const int corner : {n, n + 1, n + patch.columns, n + patch.columns + 1})
      sum += error[patch.vertex[corner]];
    return colour_of(sum / 4 / end);
  });
  paint(cr, map, CAIRO_FILTER_BILINEAR);
  cairo_restore(cr);
}

void draw_strokes(cairo_t* cr, const std::vector<PlacedStroke>& strokes, double width) {
  round_lines(cr);
  cairo_set_line_width(cr, width);
  set_colour(cr, kStroke);
  for (const PlacedStroke& stroke : strokes) {
    Line2d line;
    for (const Vector2d& p : stroke.p_P) line.push_back(view(p));
    trace(cr, line);
  }
  cairo_stroke(cr);
}

Eigen::AlignedBox2d extent(const DistortionPicture& picture) {
  Eigen::AlignedBox2d box;
  for (const SurfaceSample& sample : picture.chart.patch().samples)
    box.extend(view(sample.p_P.head<2>()));
  const double air = 0.02 * box.sizes().maxCoeff();
  return {box.min() - Vector2d::Constant(air), box.max() + Vector2d::Constant(air)};
}

// "−2.4", never "−0.0"
std::string signed_percent(double stretch) {
  const double percent = 100 * (stretch - 1);
  return std::abs(percent) < 0.05
             ? "0.0"
             : fmt::format("{}{:.1f}", percent < 0 ? "−" : "+", std::abs(percent));
}

struct PanelLayout {
  Eigen::AlignedBox2d area;  // of each map
  double font, width, height, top, gap;
};

PanelLayout lay_out(const DistortionPicture& picture) {
  PanelLayout l;
  l.area = extent(picture);
  l.font = 0.034 * std::max(l.area.sizes().x(), 0.6 * l.area.sizes().y());
  l.gap = 1.5 * l.font;
  l.top = 5.6 * l.font;
  l.width = 2 * l.area.sizes().x() + 4 * l.gap + 6 * l.font;
  l.height = l.top + l.area.sizes().y() + 5.8 * l.font;
  return l;
}

void draw_colour_bar(cairo_t* cr, const PanelLayout& l, double end) {
  const double x = 2 * l.area.sizes().x() + 3 * l.gap, high = 0.8 * l.area.sizes().y(),
               width = 1.2 * l.font;
  const double y = l.top + 0.1 * l.area.sizes().y();
  cairo_pattern_t* gradient = cairo_pattern_create_linear(0, y + high, 0, y);
  for (std::size_t k = 0; k < kScale.size(); ++k) {
    cairo_pattern_add_color_stop_rgb(gradient, static_cast<double>(k) / (kScale.size() - 1),
                                     kScale[k].r, kScale[k].g, kScale[k].b);
  }
  cairo_rectangle(cr, x, y, width, high);
  cairo_set_source(cr, gradient);
  cairo_fill_preserve(cr);
  cairo_pattern_destroy(gradient);
  set_colour(cr, kFrameColour);
  cairo_set_line_width(cr, 0.06 * l.font);
  cairo_stroke(cr);
  set_colour(cr, kFaintColour);
  for (int k = 0; k <= 5; ++k) {
    write_words(cr, x + width + 0.4 * l.font, y + high * (1 - k / 5.0) + 0.3 * l.font,
                fmt::format("{:g} %", 100 * end * k / 5), 0.85 * l.font);
  }
}

void draw_panel(cairo_t* cr, const PanelLayout& l, double left, const std::string& name,
                const Distortion& d, const DistortionPicture& picture,
                const std::vector<double>& error, const std::vector<PlacedStroke>& strokes,
                double end) {
  const Vector2d size = l.area.sizes();
  set_colour(cr, kTextColour);
  write_words(cr, left, l.top - 0.7 * l.font, name, l.font, true);
  set_colour(cr, kFaintColour);
  const double below = l.top + size.y();
  write_words(
      cr, left, below + 1.6 * l.font,
      fmt::format("along the strokes {} to {} %, RMS {:.2f} %", signed_percent(d.stretch_min),
                  signed_percent(d.stretch_max), 100 * d.stretch_rms),
      0.85 * l.font);
  write_words(cr, left, below + 3.0 * l.font,
              fmt::format("areas {} to {} %, angles up to {:.1f}°", signed_percent(d.area_min),
                          signed_percent(d.area_max), d.angle_max * 180 / std::numbers::pi),
              0.85 * l.font);
  cairo_save(cr);
  cairo_rectangle(cr, left, l.top, size.x(), size.y());
  cairo_clip(cr);
  cairo_translate(cr, left - l.area.min().x(), l.top - l.area.min().y());
  draw_map(cr, picture.chart.patch(), error, end);
  draw_strokes(cr, strokes, 0.0035 * size.maxCoeff());
  cairo_restore(cr);
  set_colour(cr, kFrameColour);
  cairo_set_line_width(cr, 0.06 * l.font);
  cairo_rectangle(cr, left, l.top, size.x(), size.y());
  cairo_stroke(cr);
}

// Length of the scale bar: the largest of 1, 2, 5, 10, … mm within a third of a map.
void draw_ruler(cairo_t* cr, const PanelLayout& l) {
  double length = 1;
  for (const double next : {2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0}) {
    if (next <= l.area.sizes().x() / 3) length = next;
  }
  const double y = l.height - 1.0 * l.font, x = l.gap;
  set_colour(cr, kTextColour);
  cairo_set_line_width(cr, 0.12 * l.font);
  stroke_line(cr, {{x, y}, {x + length, y}});
  write_words(cr, x + length + 0.5 * l.font, y + 0.3 * l.font,
              fmt::format("{:g} mm, seen from above", length), 0.85 * l.font);
}

void draw(cairo_t* cr, const DistortionPicture& picture, const PanelLayout& l, const Errors& errors,
          double end) {
  set_colour(cr, {1, 1, 1});
  cairo_paint(cr);
  set_colour(cr, kTextColour);
  write_words(cr, l.gap, 1.9 * l.font, picture.title, 1.25 * l.font, true);
  set_colour(cr, kFaintColour);
  write_words(
      cr, l.gap, 3.3 * l.font,
      "colour: by how much a page length comes out too long or too short, in the worst direction",
      0.85 * l.font);
  draw_panel(cr, l, l.gap, "projected along the drawing axis", picture.of_projected, picture,
             errors.projected, picture.projected, end);
  draw_panel(cr, l, 2 * l.gap + l.area.sizes().x(), "wrapped", picture.of_wrapped, picture,
             errors.wrapped, picture.wrapped, end);
  draw_colour_bar(cr, l, end);
  draw_ruler(cr, l);
}

}  // namespace

void write_distortion(const DistortionPicture& picture, const std::filesystem::path& stem) {
  const PanelLayout layout = lay_out(picture);
  const Errors errors = errors_of(picture.chart);
  const double end = scale_end(errors);

  write_svg_and_png(stem, {layout.width, layout.height}, picture.png_width,
                    [&](cairo_t* cr) { draw(cr, picture, layout, errors, end); });
}

}  // namespace impedraw
