#include "impedraw/report/relief_drawing.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace impedraw {

namespace {
using Line = std::vector<Eigen::Vector2d>;
constexpr std::size_t kMostCorners = 20000;  // of an outline that is drawn
constexpr double kInside = 0.8;              // brightness of what is seen through a hole
}  // namespace

void extend(Line& line, const Eigen::Vector2d& p, double step, bool always) {
  if (line.empty() || always || (p - line.back()).norm() >= step) line.push_back(p);
}

void trace(cairo_t* cr, const Line& line) {
  if (line.empty()) return;
  cairo_move_to(cr, line[0].x(), line[0].y());
  for (const Eigen::Vector2d& p : line) cairo_line_to(cr, p.x(), p.y());
}

void draw_relief(cairo_t* cr, const Relief& r) {
  if (r.columns == 0) return;
  cairo_surface_t* image = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, r.columns, r.rows);
  cairo_surface_flush(image);
  for (int i = 0; i < r.rows; ++i) {
    auto* pixels = reinterpret_cast<std::uint32_t*>(cairo_image_surface_get_data(image) +
                                                    i * cairo_image_surface_get_stride(image));
    for (int j = 0; j < r.columns; ++j) {
      const double light = r.shade(i, j), whole = 255.0 * (r.inside(i, j) ? kInside : 1.0);
      const auto channel = [light, whole](double dark, double bright) {
        return static_cast<std::uint32_t>(
            std::lround(whole * (dark + (bright - dark) * std::min(light, 1.0))));
      };
      pixels[j] = std::isfinite(light) ? 0xff000000u | channel(0.80, 0.995) << 16 |
                                             channel(0.77, 0.985) << 8 | channel(0.71, 0.96)
                                       : 0u;
    }
  }
  cairo_surface_mark_dirty(image);
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
  cairo_set_source_surface(cr, image, 0, 0);
  cairo_pattern_set_filter(cairo_get_source(cr), CAIRO_FILTER_BILINEAR);
  cairo_pattern_set_extend(cairo_get_source(cr), clipped ? CAIRO_EXTEND_PAD : CAIRO_EXTEND_NONE);
  cairo_paint(cr);
  cairo_restore(cr);
  cairo_surface_destroy(image);
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
    const double dash[] = {1.5, 2.0};
    set_colour(cr, kOutline, 0.6);
    cairo_set_dash(cr, dash, 2, 0.0);
    for (const Line& line : r.outline) trace(cr, line);
    cairo_stroke(cr);
    cairo_set_dash(cr, nullptr, 0, 0.0);
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
