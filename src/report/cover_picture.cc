#include "impedraw/report/cover_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>

#include <cairo.h>

#include "impedraw/report/sheet.h"

namespace impedraw {
namespace {

constexpr Colour kText{0.13, 0.15, 0.18}, kFaint{0.42, 0.45, 0.50}, kOutside{1.0, 1.0, 1.0};
constexpr Colour kNotPromised{0.83, 0.84, 0.86}, kOnce{0.45, 0.72, 0.55}, kTwice{0.13, 0.45, 0.33},
    kMissed{0.85, 0.16, 0.16};
constexpr double kFont = 5.0, kGap = 8.0, kTop = 24.0, kBelow = 18.0;  // [mm]
constexpr int kWidth = 1600;                                           // [px]

Colour between(const Colour& a, const Colour& b, double t) {
  return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)};
}

// Blue for too little, white for the mean, red for too much, to ± one half.
Colour of_dose(double dose) {
  if (std::isnan(dose)) return kOutside;
  const double t = std::clamp((dose - 1.0) / 0.5, -1.0, 1.0);
  return between({0.97, 0.97, 0.97}, t < 0.0 ? Colour{0.13, 0.30, 0.65} : Colour{0.70, 0.09, 0.12},
                 std::abs(t));
}

Colour of_class(Treated treated) {
  switch (treated) {
    case Treated::not_promised:
      return kNotPromised;
    case Treated::once:
      return kOnce;
    case Treated::twice:
      return kTwice;
    case Treated::missed:
      return kMissed;
    default:
      return kOutside;
  }
}

void draw_map(cairo_t* cr, const CoverPicture& p, double left,
              const std::function<Colour(std::size_t)>& colour) {
  cairo_surface_t* image = cairo_image_surface_create(CAIRO_FORMAT_RGB24, p.ny, p.nx);
  cairo_surface_flush(image);
  for (int i = 0; i < p.nx; ++i) {
    auto* pixels =
        reinterpret_cast<std::uint32_t*>(cairo_image_surface_get_data(image) +
                                         (p.nx - 1 - i) * cairo_image_surface_get_stride(image));
    for (int j = 0; j < p.ny; ++j) {
      const Colour c = colour(static_cast<std::size_t>(j) * static_cast<std::size_t>(p.nx) +
                              static_cast<std::size_t>(i));
      const auto channel = [](double x) {
        return static_cast<std::uint32_t>(std::lround(255 * x));
      };
      pixels[p.ny - 1 - j] = channel(c.r) << 16 | channel(c.g) << 8 | channel(c.b);
    }
  }
  cairo_surface_mark_dirty(image);
  cairo_save(cr);
  cairo_translate(cr, left, kTop);
  cairo_scale(cr, 1e3 * p.step, 1e3 * p.step);
  cairo_set_source_surface(cr, image, 0, 0);
  cairo_pattern_set_filter(cairo_get_source(cr), CAIRO_FILTER_NEAREST);
  cairo_paint(cr);
  cairo_restore(cr);
  cairo_surface_destroy(image);
}

double write(cairo_t* cr, double x, double y, const std::string& text, double size, bool bold) {
  cairo_select_font_face(cr, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cr, size);
  cairo_move_to(cr, x, y);
  cairo_show_text(cr, text.c_str());
  cairo_text_extents_t extents;
  cairo_text_extents(cr, text.c_str(), &extents);
  return x + extents.x_advance;
}

double entry(cairo_t* cr, double x, double y, const Colour& colour, const std::string& text) {
  set_colour(cr, colour);
  cairo_rectangle(cr, x, y - 0.75 * kFont, kFont, kFont);
  cairo_fill(cr);
  set_colour(cr, kFaint);
  return write(cr, x + 1.4 * kFont, y, text, 0.85 * kFont, false) + kFont;
}

}  // namespace

void write_cover(const CoverPicture& p, const std::filesystem::path& stem) {
  const double width = 1e3 * p.step * p.ny, height = 1e3 * p.step * p.nx;
  const double least = 150.0, panel = std::max(width, least);
  const Eigen::Vector2d size(2.0 * panel + 3.0 * kGap, height + kTop + kBelow);
  write_svg_and_png(stem, size, kWidth, [&](cairo_t* cr) {
    set_colour(cr, kOutside);
    cairo_paint(cr);
    set_colour(cr, kText);
    write(cr, kGap, 1.6 * kFont, p.title, 1.2 * kFont, true);
    set_colour(cr, kFaint);
    write(cr, kGap, 3.0 * kFont, p.subtitle, 0.85 * kFont, false);
    const double right = 2.0 * kGap + panel, below = kTop + height + 1.6 * kFont;
    draw_map(cr, p, kGap, [&](std::size_t v) { return of_class(p.treated[v]); });
    draw_map(cr, p, right, [&](std::size_t v) { return of_dose(p.dose[v]); });
    double x = entry(cr, kGap, below, kOnce, "once");
    x = entry(cr, x, below, kTwice, "twice or more");
    x = entry(cr, x, below, kMissed, "missed");
    entry(cr, x, below, kNotPromised, "not promised");
    x = entry(cr, right, below, of_dose(0.5), "half");
    x = entry(cr, x, below, of_dose(1.0), "mean of pressure × way");
    entry(cr, x, below, of_dose(1.5), "one and a half");
  });
}

}  // namespace impedraw
