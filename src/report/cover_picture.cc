#include "impedraw/report/cover_picture.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <cairo.h>
#include <fmt/format.h>

#include "impedraw/report/sheet.h"

namespace impedraw {
namespace {

constexpr Colour kOutside{1.0, 1.0, 1.0};
constexpr Colour kNotPromised{0.83, 0.84, 0.86}, kOnce{0.45, 0.72, 0.55}, kTwice{0.13, 0.45, 0.33},
    kMissed{0.85, 0.16, 0.16};
constexpr double kFont = 5.0, kGap = 8.0, kTop = 24.0, kBelow = 18.0, kMargin = 5.0;  // [mm]
constexpr int kPictureWidth = 1600;                                                   // [px]

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

// The places that are not outside, and some about them.
Eigen::AlignedBox2i shown(const CoverPicture& p) {
  const auto margin = static_cast<int>(std::ceil(kMargin / (1e3 * p.step)));
  Eigen::AlignedBox2i box, whole(Eigen::Vector2i(0, 0), Eigen::Vector2i(p.nx - 1, p.ny - 1));
  for (int v = 0; v < p.nx * p.ny; ++v)
    if (p.treated[static_cast<std::size_t>(v)] != Treated::outside)
      box.extend(Eigen::Vector2i(v % p.nx, v / p.nx));
  if (box.isEmpty()) return whole;
  return whole.intersection({box.min().array() - margin, box.max().array() + margin});
}

// Up is +x, left +y.
void draw_map(cairo_t* cr, const CoverPicture& p, const Eigen::AlignedBox2i& box, double left,
              const std::function<Colour(std::size_t)>& colour) {
  cairo_save(cr);
  cairo_translate(cr, left, kTop);
  cairo_scale(cr, 1e3 * p.step, 1e3 * p.step);
  const Eigen::Vector2i size = box.sizes();
  const Raster map = raster(size.x() + 1, size.y() + 1, [&](int row, int column) {
    return colour(static_cast<std::size_t>((box.max().y() - column) * p.nx + box.max().x() - row));
  });
  paint(cr, map, CAIRO_FILTER_NEAREST);
  cairo_restore(cr);
}

double entry(cairo_t* cr, double x, double y, const Colour& colour, const std::string& text) {
  set_colour(cr, colour);
  cairo_rectangle(cr, x, y - 0.75 * kFont, kFont, kFont);
  cairo_fill(cr);
  set_colour(cr, kFaintColour);
  const double at = x + 1.4 * kFont;
  return at + write_words(cr, at, y, text, 0.85 * kFont) + kFont;
}

}  // namespace

void write_cover(const CoverPicture& p, const std::filesystem::path& stem) {
  const Eigen::AlignedBox2i box = shown(p);
  const double width = 1e3 * p.step * (box.sizes().y() + 1),
               height = 1e3 * p.step * (box.sizes().x() + 1);
  const double least = 150.0, panel = std::max(width, least);
  const Eigen::Vector2d size(2.0 * panel + 3.0 * kGap, height + kTop + kBelow);
  write_svg_and_png(stem, size, kPictureWidth, [&](cairo_t* cr) {
    set_colour(cr, kOutside);
    cairo_paint(cr);
    set_colour(cr, kTextColour);
    write_words(cr, kGap, 1.6 * kFont, p.title, 1.2 * kFont, true);
    set_colour(cr, kFaintColour);
    write_words(cr, kGap, 3.0 * kFont,
                fmt::format("{}; {:.0f} × {:.0f} mm are shown", p.subtitle, width, height),
                0.85 * kFont);
    const double right = 2.0 * kGap + panel, below = kTop + height + 1.6 * kFont;
    draw_map(cr, p, box, kGap, [&](std::size_t v) { return of_class(p.treated[v]); });
    draw_map(cr, p, box, right, [&](std::size_t v) { return of_dose(p.dose[v]); });
    double x = entry(cr, kGap, below, kOnce, "once");
    x = entry(cr, x, below, kTwice, "twice or more");
    x = entry(cr, x, below, kMissed, "missed");
    entry(cr, x, below, kNotPromised, "not promised");
    x = entry(cr, right, below, of_dose(0.5), "half");
    x = entry(cr, x, below, of_dose(1.0), "mean of " + p.dose_is);
    entry(cr, x, below, of_dose(1.5), "one and a half");
  });
}

}  // namespace impedraw
