#include "impedraw/report/cover_picture.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <cairo.h>
#include <fmt/format.h>

#include "impedraw/report/sheet.h"

namespace impedraw {
namespace {

constexpr Colour kText{0.13, 0.15, 0.18}, kFaint{0.42, 0.45, 0.50}, kOutside{1.0, 1.0, 1.0};
constexpr Colour kNotPromised{0.83, 0.84, 0.86}, kOnce{0.45, 0.72, 0.55}, kTwice{0.13, 0.45, 0.33},
    kMissed{0.85, 0.16, 0.16};
constexpr double kFont = 5.0, kGap = 8.0, kTop = 24.0, kBelow = 18.0, kMargin = 5.0;  // [mm]
constexpr int kWidth = 1600;                                                          // [px]

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

// Up is +x, left +y.
void draw_map(cairo_t* cr, const CoverPicture& p, double left,
              const std::function<Colour(std::size_t)>& colour) {
  cairo_save(cr);
  cairo_translate(cr, left, kTop);
  cairo_scale(cr, 1e3 * p.step, 1e3 * p.step);
  paint_raster(cr, p.nx, p.ny, CAIRO_FILTER_NEAREST, [&](int row, int column) {
    return colour(static_cast<std::size_t>(p.ny - 1 - column) * static_cast<std::size_t>(p.nx) +
                  static_cast<std::size_t>(p.nx - 1 - row));
  });
  cairo_restore(cr);
}

// The part about the places that are not outside.
CoverPicture cropped(const CoverPicture& p) {
  int low[] = {p.nx, p.ny}, high[] = {-1, -1};
  const int margin = static_cast<int>(std::ceil(kMargin / (1e3 * p.step)));
  for (std::size_t v = 0; v < p.treated.size(); ++v) {
    if (p.treated[v] == Treated::outside) continue;
    const int at[] = {static_cast<int>(v) % p.nx, static_cast<int>(v) / p.nx},
              size[] = {p.nx, p.ny};
    for (int i = 0; i < 2; ++i) {
      low[i] = std::min(low[i], std::max(0, at[i] - margin));
      high[i] = std::max(high[i], std::min(size[i] - 1, at[i] + margin));
    }
  }
  if (high[0] < 0) return p;
  CoverPicture part{p.title, p.subtitle, high[0] - low[0] + 1, high[1] - low[1] + 1, p.step};
  for (int j = low[1]; j <= high[1]; ++j)
    for (int i = low[0]; i <= high[0]; ++i) {
      const auto v = static_cast<std::size_t>(j) * static_cast<std::size_t>(p.nx) +
                     static_cast<std::size_t>(i);
      part.treated.push_back(p.treated[v]);
      part.dose.push_back(p.dose[v]);
    }
  return part;
}

double entry(cairo_t* cr, double x, double y, const Colour& colour, const std::string& text) {
  set_colour(cr, colour);
  cairo_rectangle(cr, x, y - 0.75 * kFont, kFont, kFont);
  cairo_fill(cr);
  set_colour(cr, kFaint);
  const double at = x + 1.4 * kFont;
  return at + write_words(cr, at, y, text, 0.85 * kFont) + kFont;
}

}  // namespace

void write_cover(const CoverPicture& whole, const std::filesystem::path& stem) {
  const CoverPicture p = cropped(whole);
  const double width = 1e3 * p.step * p.ny, height = 1e3 * p.step * p.nx;
  const double least = 150.0, panel = std::max(width, least);
  const Eigen::Vector2d size(2.0 * panel + 3.0 * kGap, height + kTop + kBelow);
  write_svg_and_png(stem, size, kWidth, [&](cairo_t* cr) {
    set_colour(cr, kOutside);
    cairo_paint(cr);
    set_colour(cr, kText);
    write_words(cr, kGap, 1.6 * kFont, p.title, 1.2 * kFont, true);
    set_colour(cr, kFaint);
    write_words(cr, kGap, 3.0 * kFont, p.subtitle, 0.85 * kFont);
    const double right = 2.0 * kGap + panel, below = kTop + height + 1.6 * kFont;
    draw_map(cr, p, kGap, [&](std::size_t v) { return of_class(p.treated[v]); });
    draw_map(cr, p, right, [&](std::size_t v) { return of_dose(p.dose[v]); });
    double x = entry(cr, kGap, below, kOnce, "once");
    x = entry(cr, x, below, kTwice, "twice or more");
    x = entry(cr, x, below, kMissed, "missed");
    entry(cr, x, below, kNotPromised,
          fmt::format("not promised; {:.0f} mm wide, {:.0f} high", width, height));
    x = entry(cr, right, below, of_dose(0.5), "half");
    x = entry(cr, x, below, of_dose(1.0), "mean of pressure × way");
    entry(cr, x, below, of_dose(1.5), "one and a half");
  });
}

}  // namespace impedraw
