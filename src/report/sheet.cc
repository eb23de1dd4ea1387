#include "impedraw/report/sheet.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <cairo-svg.h>
#include <fmt/format.h>
#include <zlib.h>

#include "impedraw/files/durable_file.h"

namespace impedraw {
namespace {

constexpr Colour kText{0.13, 0.15, 0.18}, kFaint{0.42, 0.45, 0.50}, kFrame{0.70, 0.72, 0.75};

// Sizes scale with the picture's width, so that text in a README has the same size for every
// drawing.
struct Layout {
  double width, height;                 // of the whole [mm]
  double font;                          // size [mm]
  Eigen::Vector2d origin;               // of the frame's upper left corner
  std::vector<Eigen::Vector2d> legend;  // where each entry begins (its text's baseline)
};

double text_width(cairo_t* cr, const std::string& text) {
  cairo_text_extents_t extents;
  cairo_text_extents(cr, text.c_str(), &extents);
  return extents.x_advance;
}

Layout lay_out(const Sheet& sheet, cairo_t* cr) {
  Layout l;
  const double frame = sheet.area.sizes().x();
  l.font = 0.026 * std::max(frame, 0.7 * sheet.area.sizes().y());
  l.origin = {5.2 * l.font, sheet.subtitle.empty() ? 2.6 * l.font : 4.1 * l.font};
  l.width = l.origin.x() + frame + 1.6 * l.font;
  double x = l.origin.x(), y = l.origin.y() + sheet.area.sizes().y() + 5.0 * l.font;
  set_font(cr, 0.92 * l.font);
  for (const LegendEntry& entry : sheet.legend) {
    const double needed = 3.0 * l.font + text_width(cr, entry.text);
    if (x > l.origin.x() && x + needed > l.width - l.font) {
      x = l.origin.x();
      y += 1.6 * l.font;
    }
    l.legend.push_back({x, y});
    x += needed + 1.6 * l.font;
  }
  l.height = y + (sheet.legend.empty() ? -1.0 : 1.2) * l.font;
  return l;
}

void say(cairo_t* cr, double x, double y, const std::string& text, double align = 0.0) {
  cairo_move_to(cr, x - align * text_width(cr, text), y);
  cairo_show_text(cr, text.c_str());
}

void draw_axes(const Sheet& sheet, const Layout& l, cairo_t* cr) {
  const Eigen::Vector2d size = sheet.area.sizes(), low = sheet.area.min(), high = sheet.area.max();
  const double left = l.origin.x(), top = l.origin.y(), bottom = top + size.y(),
               tick = 0.4 * l.font;
  const double range = size.maxCoeff();
  cairo_set_line_width(cr, 0.06 * l.font);
  set_colour(cr, kFrame);
  cairo_rectangle(cr, left, top, size.x(), size.y());
  cairo_stroke(cr);
  set_font(cr, 0.85 * l.font);
  const auto label = [](double value) {
    return fmt::format("{}{:.0f}", value < -0.5 ? "−" : "", std::abs(value));
  };
  for (const double c : ticks(low.x(), high.x(), range)) {
    const double x = left + c - low.x();
    set_colour(cr, kFrame);
    cairo_move_to(cr, x, bottom);
    cairo_line_to(cr, x, bottom + tick);
    cairo_stroke(cr);
    set_colour(cr, kFaint);
    say(cr, x, bottom + 1.45 * l.font, label(sheet.u_sign * c), 0.5);
  }
  for (const double c : ticks(low.y(), high.y(), range)) {
    const double y = top + c - low.y();
    set_colour(cr, kFrame);
    cairo_move_to(cr, left, y);
    cairo_line_to(cr, left - tick, y);
    cairo_stroke(cr);
    set_colour(cr, kFaint);
    say(cr, left - 0.7 * l.font, y + 0.3 * l.font, label(sheet.v_sign * c), 1.0);
  }
  set_colour(cr, kText);
  set_font(cr, 0.92 * l.font);
  say(cr, left + 0.5 * size.x(), bottom + 2.9 * l.font, sheet.u_name, 0.5);
  cairo_save(cr);
  cairo_translate(cr, 1.3 * l.font, top + 0.5 * size.y());
  cairo_rotate(cr, -0.5 * std::numbers::pi);
  say(cr, 0.0, 0.0, sheet.v_name, 0.5);
  cairo_restore(cr);
}

void draw(const Sheet& sheet, const Layout& l, cairo_t* cr) {
  set_colour(cr, {1, 1, 1});
  cairo_paint(cr);
  set_colour(cr, kText);
  set_font(cr, 1.25 * l.font, true);
  say(cr, l.origin.x(), 1.8 * l.font, sheet.title);
  if (!sheet.subtitle.empty()) {
    set_colour(cr, kFaint);
    set_font(cr, 0.92 * l.font);
    say(cr, l.origin.x(), 3.3 * l.font, sheet.subtitle);
  }
  cairo_save(cr);
  cairo_rectangle(cr, l.origin.x(), l.origin.y(), sheet.area.sizes().x(), sheet.area.sizes().y());
  cairo_clip(cr);
  cairo_translate(cr, l.origin.x() - sheet.area.min().x(), l.origin.y() - sheet.area.min().y());
  sheet.content(cr);
  cairo_restore(cr);
  draw_axes(sheet, l, cr);
  set_font(cr, 0.92 * l.font);
  for (std::size_t k = 0; k < sheet.legend.size(); ++k) {
    const Eigen::Vector2d at = l.legend[k];
    set_colour(cr, sheet.legend[k].colour);
    cairo_set_line_cap(cr, CAIRO_LINE_CAP_BUTT);
    cairo_set_line_width(cr, sheet.legend[k].width);
    cairo_move_to(cr, at.x(), at.y() - 0.33 * l.font);
    cairo_line_to(cr, at.x() + 2.2 * l.font, at.y() - 0.33 * l.font);
    cairo_stroke(cr);
    set_colour(cr, kText);
    say(cr, at.x() + 2.8 * l.font, at.y(), sheet.legend[k].text);
  }
}

void require(cairo_status_t status, const std::filesystem::path& path) {
  if (status != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error("cannot write " + path.string() + ": " +
                             cairo_status_to_string(status));
}

cairo_status_t append_to_string(void* to, const unsigned char* data, unsigned int bytes) {
  static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(data), bytes);
  return CAIRO_STATUS_SUCCESS;
}

void put_big_endian(std::string& out, std::uint32_t x) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>((x >> shift) & 0xff);
}

void put_png_chunk(std::string& out, const std::string& name, const std::string& data) {
  put_big_endian(out, static_cast<std::uint32_t>(data.size()));
  const std::size_t begin = out.size();
  out += name;
  out += data;
  put_big_endian(
      out, static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(out.data() + begin),
                                            static_cast<uInt>(out.size() - begin))));
}

// The image as PNG. Each row is told as what differs from the one above, and deflated lightly: a
// fifth larger than by Cairo's writer, which tries all filters on each row, in half the time.
std::string png_of(cairo_surface_t* image) {
  constexpr char kAbove = 2;
  const int width = cairo_image_surface_get_width(image),
            height = cairo_image_surface_get_height(image);
  cairo_surface_flush(image);
  const unsigned char* const pixels = cairo_image_surface_get_data(image);
  std::string rows(static_cast<std::size_t>(height) * (3 * static_cast<std::size_t>(width) + 1), 0);
  char* to = rows.data();
  const std::vector<std::uint32_t> none(static_cast<std::size_t>(width));
  const std::uint32_t* above = none.data();
  for (int i = 0; i < height; ++i) {
    const auto* const row = reinterpret_cast<const std::uint32_t*>(
        pixels + static_cast<std::ptrdiff_t>(i) * cairo_image_surface_get_stride(image));
    *to++ = kAbove;
    for (int j = 0; j < width; ++j)
      for (int shift = 16; shift >= 0; shift -= 8)
        *to++ = static_cast<char>((row[j] >> shift) - (above[j] >> shift));
    above = row;
  }
  uLongf size = compressBound(rows.size());
  std::string packed(size, '\0');
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
            reinterpret_cast<const Bytef*>(rows.data()), rows.size(), 3);
  packed.resize(size);
  std::string head, out = "\x89PNG\r\n\x1a\n";
  put_big_endian(head, static_cast<std::uint32_t>(width));
  put_big_endian(head, static_cast<std::uint32_t>(height));
  head += {8, 2, 0, 0, 0};  // bits, RGB, deflate, filters by row, not interlaced
  put_png_chunk(out, "IHDR", head);
  put_png_chunk(out, "IDAT", packed);
  put_png_chunk(out, "IEND", {});
  return out;
}

}  // namespace

void set_font(cairo_t* cr, double size, bool bold) {
  cairo_select_font_face(cr, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cr, size);
}

double write_words(cairo_t* cr, double x, double y, const std::string& text, double size, bool bold,
                   double align) {
  set_font(cr, size, bold);
  const double width = text_width(cr, text);
  cairo_move_to(cr, x - align * width, y);
  cairo_show_text(cr, text.c_str());
  return width;
}

void paint_raster(cairo_t* cr, int rows, int columns, cairo_filter_t filter,
                  const std::function<std::optional<Colour>(int row, int column)>& colour) {
  cairo_surface_t* image = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, columns, rows);
  cairo_surface_flush(image);
  for (int i = 0; i < rows; ++i) {
    auto* pixels = reinterpret_cast<std::uint32_t*>(cairo_image_surface_get_data(image) +
                                                    i * cairo_image_surface_get_stride(image));
    for (int j = 0; j < columns; ++j) {
      const std::optional<Colour> c = colour(i, j);
      const auto channel = [](double x) {
        return static_cast<std::uint32_t>(std::lround(255 * x));
      };
      pixels[j] = c ? 0xff000000u | channel(c->r) << 16 | channel(c->g) << 8 | channel(c->b) : 0u;
    }
  }
  cairo_surface_mark_dirty(image);
  cairo_set_source_surface(cr, image, 0, 0);
  cairo_pattern_set_filter(cairo_get_source(cr), filter);
  cairo_paint(cr);
  cairo_surface_destroy(image);
}

void set_colour(cairo_t* cr, const Colour& colour, double alpha) {
  cairo_set_source_rgba(cr, colour.r, colour.g, colour.b, alpha);
}

std::vector<double> ticks(double low, double high, double range) {
  std::vector<double> places;
  if (!std::isfinite(low) || !std::isfinite(high) || !std::isfinite(range)) return places;
  double step = 1.0;
  for (double tens = 1.0; range / step > 8.0; tens *= 10.0) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      step = factor * tens;
      if (range / step <= 8.0) break;
    }
  }
  // Counted, not summed up: far from zero a step may be lost to rounding.
  const double first = std::ceil(low / step), last = std::floor((high + 1e-9) / step);
  for (int k = 0; first + k <= last && k <= 10; ++k) places.push_back((first + k) * step);
  return places;
}

void write_svg_and_png(const std::filesystem::path& stem, const Eigen::Vector2d& size,
                       int png_width, const std::function<void(cairo_t*)>& draw) {
  std::filesystem::path path = stem;
  path += ".svg";
  std::string content;
  cairo_surface_t* svg =
      cairo_svg_surface_create_for_stream(append_to_string, &content, size.x(), size.y());
  cairo_svg_surface_set_document_unit(svg, CAIRO_SVG_UNIT_MM);
  cairo_t* cr = cairo_create(svg);
  draw(cr);
  cairo_destroy(cr);
  cairo_surface_finish(svg);
  const cairo_status_t svg_status = cairo_surface_status(svg);
  cairo_surface_destroy(svg);
  require(svg_status, path);
  write_whole(path, content);

  path = stem;
  path += ".png";
  const double scale = png_width / size.x();
  cairo_surface_t* png = cairo_image_surface_create(
      CAIRO_FORMAT_RGB24, png_width, static_cast<int>(std::lround(scale * size.y())));
  cr = cairo_create(png);
  cairo_scale(cr, scale, scale);
  draw(cr);
  cairo_destroy(cr);
  const cairo_status_t png_status = cairo_surface_status(png);
  if (png_status == CAIRO_STATUS_SUCCESS) content = png_of(png);
  cairo_surface_destroy(png);
  require(png_status, path);
  write_whole(path, content);
}

void write_sheet(const Sheet& sheet, const std::filesystem::path& stem, int png_width) {
  cairo_surface_t* measure = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, 1, 1);
  cairo_t* cr = cairo_create(measure);
  const Layout layout = lay_out(sheet, cr);
  cairo_destroy(cr);
  cairo_surface_destroy(measure);

  write_svg_and_png(stem, {layout.width, layout.height}, png_width,
                    [&](cairo_t* on) { draw(sheet, layout, on); });
}

}  // namespace impedraw
