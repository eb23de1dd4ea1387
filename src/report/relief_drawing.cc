#include "impedraw/report/relief_drawing.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace impedraw {

namespace {
using Line = std::vector<Eigen::Vector2d>;
constexpr std::size_t kMostCorners = 20000;  // of an outline that is drawn
constexpr double kInside = 0.8;              // brightness of what is seen through a hole
}  // namespace

void extend(Line& line, const Eigen::Vector2d& p, double step, bool always) {
  if (line.empty() || always || (p - line.back()).norm() >= step) line.push_back(p);
}

void draw_relief(cairo_t* cr, const Relief& r) {
  if (r.columns == 0) return;
  cairo_save(cr);
  // A sheet's outline is exact, the cells are not. Cairo's time grows with the square of a ragged
  // one.
  std::size_t corners = 0;
  for (const Line& line : r.outline) corners += line.size();
  const bool outlined = corners > 0 && corners <= kMostCorners, clipped = outlined && r.is_sheet;
  if (clipped) {
    for (const Line& line : r.outline) trace(cr, line);
    cairo_clip(cr);
  }
  cairo_translate(cr, r.area.min().x(), r.area.min().y());
  cairo_scale(cr, r.area.sizes().x() / r.columns, r.area.sizes().y() / r.rows);
  paint_raster(
      cr, r.rows, r.columns, CAIRO_FILTER_BILINEAR,
      [&r](int i, int j) -> std::optional<Colour> {
        const double light = r.shade(i, j), whole = r.inside(i, j) ? kInside : 1.0;
        if (!std::isfinite(light)) return std::nullopt;
        const Colour c = between({0.80, 0.77, 0.71}, {0.995, 0.985, 0.96}, std::min(light, 1.0));
        return Colour{whole * c.r, whole * c.g, whole * c.b};
      },
      clipped ? CAIRO_EXTEND_PAD : CAIRO_EXTEND_NONE);
  cairo_restore(cr);
  cairo_set_line_width(cr, 0.3);
  set_colour(cr, kContour, 0.55);
  for (const Line& line : r.contours) {
    Line thin;
    for (std::size_t i = 0; i < line.size(); ++i) extend(thin, line[i], 1.0, i + 1 == line.size());
    trace(cr, thin);
  }
  cairo_stroke(cr);
  cairo_set_line_width(cr, 0.7);
  if (outlined && !r.is_sheet) {  // what the body hides is dashed
    set_colour(cr, kOutline, 0.6);
    set_dash(cr, 1.5, 2.0);
    for (const Line& line : r.outline) trace(cr, line);
    cairo_stroke(cr);
    set_dash(cr);
  }
  set_colour(cr, kOutline);
  if (outlined) {
    for (const Line& line : r.seen_outline) trace(cr, line);
  }
  cairo_stroke(cr);
}

Eigen::AlignedBox2d with_margin(Eigen::AlignedBox2d box, double share) {
  const double margin = std::max(1.0, share * box.sizes().maxCoeff());
  box.min().array() -= margin;
  box.max().array() += margin;
  return box;
}

}  // namespace impedraw
