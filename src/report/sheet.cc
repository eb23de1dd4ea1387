#include "impedraw/report/sheet.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <cairo-svg.h>
#include <fmt/format.h>
#include <png.h>

#include "impedraw/files/durable_file.h"

namespace impedraw {
namespace {

// Sizes scale with the picture's width, so that text in a README has the same size for every
// drawing.
struct Layout {
  double width, height;                 // of the whole [mm]
  double font;                          // size [mm]
  Eigen::Vector2d origin;               // of the frame's upper left corner
  std::vector<Eigen::Vector2d> legend;  // where each entry begins (its text's baseline)
};

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

void draw_axes(const Sheet& sheet, const Layout& l, cairo_t* cr) {
  const Eigen::Vector2d size = sheet.area.sizes(), low = sheet.area.min(), high = sheet.area.max();
  const double left = l.origin.x(), top = l.origin.y(), bottom = top + size.y(),
               tick = 0.4 * l.font;
  const double range = size.maxCoeff();
  cairo_set_line_width(cr, 0.06 * l.font);
  set_colour(cr, kFrameColour);
  cairo_rectangle(cr, left, top, size.x(), size.y());
  cairo_stroke(cr);
  set_font(cr, 0.85 * l.font);
  const auto label = [](double value) {
    return fmt::format("{}{:.0f}", value < -0.5 ? "−" : "", std::abs(value));
  };
  for (const double c : ticks(low.x(), high.x(), range)) {
    const double x = left + c - low.x();
    set_colour(cr, kFrameColour);
    stroke_line(cr, {{x, bottom}, {x, bottom + tick}});
    set_colour(cr, kFaintColour);
    show_text(cr, x, bottom + 1.45 * l.font, label(sheet.u_sign * c), 0.5);
  }
  for (const double c : ticks(low.y(), high.y(), range)) {
    const double y = top + c - low.y();
    set_colour(cr, kFrameColour);
    stroke_line(cr, {{left, y}, {left - tick, y}});
    set_colour(cr, kFaintColour);
    show_text(cr, left - 0.7 * l.font, y + 0.3 * l.font, label(sheet.v_sign * c), 1.0);
  }
  set_colour(cr, kTextColour);
  set_font(cr, 0.92 * l.font);
  show_text(cr, left + 0.5 * size.x(), bottom + 2.9 * l.font, sheet.u_name, 0.5);
  cairo_save(cr);
  cairo_translate(cr, 1.3 * l.font, top + 0.5 * size.y());
  cairo_rotate(cr, -0.5 * std::numbers::pi);
  show_text(cr, 0.0, 0.0, sheet.v_name, 0.5);
  cairo_restore(cr);
}

void draw(const Sheet& sheet, const Layout& l, cairo_t* cr) {
  set_colour(cr, {1, 1, 1});
  cairo_paint(cr);
  set_colour(cr, kTextColour);
  set_font(cr, 1.25 * l.font, true);
  show_text(cr, l.origin.x(), 1.8 * l.font, sheet.title);
  if (!sheet.subtitle.empty()) {
    set_colour(cr, kFaintColour);
    set_font(cr, 0.92 * l.font);
    show_text(cr, l.origin.x(), 3.3 * l.font, sheet.subtitle);
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
    cairo_set_line_width(cr, std::min(sheet.legend[k].width, 0.9 * l.font));
    const double y = at.y() - 0.33 * l.font;
    stroke_line(cr, {{at.x(), y}, {at.x() + 2.2 * l.font, y}});
    set_colour(cr, kTextColour);
    show_text(cr, at.x() + 2.8 * l.font, at.y(), sheet.legend[k].text);
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

// The image as PNG, unfiltered and deflated lightly: a sixth larger than by Cairo's writer, which
// tries all filters on each row, in a third of the time.
std::string png_of(cairo_surface_t* image) {
  cairo_surface_flush(image);
  const int height = cairo_image_surface_get_height(image);
  const unsigned char* const pixels = cairo_image_surface_get_data(image);
  std::string out;
  png_structp png = png_create_write_struct(
      PNG_LIBPNG_VER_STRING, nullptr,
      [](png_structp, png_const_charp what) { throw std::runtime_error(what); }, nullptr);
  png_infop info = png_create_info_struct(png);
  const auto append = [](png_structp to, png_bytep bytes, std::size_t count) {
    append_to_string(png_get_io_ptr(to), bytes, static_cast<unsigned int>(count));
  };
  png_set_write_fn(png, &out, append, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(cairo_image_surface_get_width(image)),
               static_cast<png_uint_32>(height), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);
  png_set_compression_level(png, 3);
  png_write_info(png, info);
  png_set_bgr(png);  // a pixel is blue, green, red and a byte without meaning
  png_set_filler(png, 0, PNG_FILLER_AFTER);
  for (int i = 0; i < height; ++i)
    png_write_row(png,
                  pixels + static_cast<std::ptrdiff_t>(i) * cairo_image_surface_get_stride(image));
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return out;
}

void svg_file(std::filesystem::path path, const Eigen::Vector2d& size,
              const std::function<void(cairo_t*)>& draw) {
  path += ".svg";
  std::string content;
  cairo_surface_t* svg =
      cairo_svg_surface_create_for_stream(append_to_string, &content, size.x(), size.y());
  cairo_svg_surface_set_document_unit(svg, CAIRO_SVG_UNIT_MM);
  cairo_t* cr = cairo_create(svg);
  draw(cr);
  cairo_destroy(cr);
  cairo_surface_finish(svg);
  const cairo_status_t status = cairo_surface_status(svg);
  cairo_surface_destroy(svg);
  require(status, path);
  write_whole(path, content);
}

void png_file(std::filesystem::path path, const Eigen::Vector2d& size, int width,
              const std::function<void(cairo_t*)>& draw) {
  path += ".png";
  const double scale = width / size.x();
  cairo_surface_t* png = cairo_image_surface_create(
      CAIRO_FORMAT_RGB24, width, static_cast<int>(std::lround(scale * size.y())));
  cairo_t* cr = cairo_create(png);
  cairo_scale(cr, scale, scale);
  draw(cr);
  cairo_destroy(cr);
  const cairo_status_t status = cairo_surface_status(png);
  std::string content;
  if (status == CAIRO_STATUS_SUCCESS) content = png_of(png);
  cairo_surface_destroy(png);
  require(status, path);
  write_whole(path, content);
}

Layout layout_of(const Sheet& sheet) {
  cairo_surface_t* measure = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, 1, 1);
  cairo_t* cr = cairo_create(measure);
  const Layout layout = lay_out(sheet, cr);
  cairo_destroy(cr);
  cairo_surface_destroy(measure);
  return layout;
}

}  // namespace

void set_font(cairo_t* cr, double size, bool bold) {
  cairo_select_font_face(cr, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cr, size);
}

double text_width(cairo_t* cr, const std::string& text) {
  cairo_text_extents_t extents;
  cairo_text_extents(cr, text.c_str(), &extents);
  return extents.x_advance;
}

double show_text(cairo_t* cr, double x, double y, const std::string& text, double align) {
  const double width = text_width(cr, text);
  cairo_move_to(cr, x - align * width, y);
  cairo_show_text(cr, text.c_str());
  return width;
}

double write_words(cairo_t* cr, double x, double y, const std::string& text, double size, bool bold,
                   double align) {
  set_font(cr, size, bold);
  return show_text(cr, x, y, text, align);
}

Raster raster(int rows, int columns,
              const std::function<std::optional<Colour>(int row, int column)>& colour) {
  Raster image(cairo_image_surface_create(CAIRO_FORMAT_ARGB32, columns, rows),
               cairo_surface_destroy);
  cairo_surface_flush(image.get());
  const int stride = cairo_image_surface_get_stride(image.get());
  for (int i = 0; i < rows; ++i) {
    auto* pixels =
        reinterpret_cast<std::uint32_t*>(cairo_image_surface_get_data(image.get()) + i * stride);
    for (int j = 0; j < columns; ++j) {
      const std::optional<Colour> c = colour(i, j);
      const auto channel = [](double x) {
        return static_cast<std::uint32_t>(std::lround(255 * x));
      };
      pixels[j] = c ? 0xff000000u | channel(c->r) << 16 | channel(c->g) << 8 | channel(c->b) : 0u;
    }
  }
  cairo_surface_mark_dirty(image.get());
  return image;
}

void keep_deflated(const Raster& image) {
  auto png = std::make_unique<std::string>();
  if (cairo_surface_write_to_png_stream(image.get(), append_to_string, png.get()) !=
      CAIRO_STATUS_SUCCESS)
    return;  // Cairo deflates it anew
  const auto* data = reinterpret_cast<const unsigned char*>(png->data());
  const std::size_t size = png->size();
  if (cairo_surface_set_mime_data(
          image.get(), CAIRO_MIME_TYPE_PNG, data, size,
          [](void* owner) { delete static_cast<std::string*>(owner); },
          png.get()) == CAIRO_STATUS_SUCCESS)
    png.release();
}

void paint(cairo_t* cr, const Raster& image, cairo_filter_t filter, cairo_extend_t beyond) {
  cairo_set_source_surface(cr, image.get(), 0, 0);
  cairo_pattern_set_filter(cairo_get_source(cr), filter);
  cairo_pattern_set_extend(cairo_get_source(cr), beyond);
  cairo_paint(cr);
}

void load_fonts() {
  // All pictures hint a font's letters as the first surface does that measures some of them.
  const Raster image(cairo_image_surface_create(CAIRO_FORMAT_ARGB32, 1, 1), cairo_surface_destroy);
  cairo_t* cr = cairo_create(image.get());
  set_font(cr, 10.0);
  text_width(cr, "0");
  cairo_destroy(cr);
}

Colour colour_from(std::uint32_t rgb) {
  const auto part = [&](int shift) { return static_cast<double>(rgb >> shift & 0xff) / 255.0; };
  return {part(16), part(8), part(0)};
}

Colour between(const Colour& a, const Colour& b, double t) {
  return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)};
}

void round_lines(cairo_t* cr) {
  cairo_set_line_cap(cr, CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(cr, CAIRO_LINE_JOIN_ROUND);
}

void set_dash(cairo_t* cr, double on, double off) {
  const double lengths[] = {on, off};
  cairo_set_dash(cr, lengths, on > 0.0 ? 2 : 0, 0.0);
}

void trace(cairo_t* cr, const Line2d& line) {
  if (line.empty()) return;
  cairo_move_to(cr, line[0].x(), line[0].y());
  for (const Eigen::Vector2d& p : line) cairo_line_to(cr, p.x(), p.y());
}

void stroke_line(cairo_t* cr, const Line2d& line) {
  trace(cr, line);
  cairo_stroke(cr);
}

void extend(Eigen::AlignedBox2d* box, const std::vector<Line2d>& lines) {
  for (const Line2d& line : lines)
    for (const Eigen::Vector2d& p : line) box->extend(p);
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
  svg_file(stem, size, draw);
  png_file(stem, size, png_width, draw);
}

void write_svg(const Sheet& sheet, const std::filesystem::path& stem) {
  const Layout l = layout_of(sheet);
  svg_file(stem, {l.width, l.height}, [&](cairo_t* on) { draw(sheet, l, on); });
}

void write_png(const Sheet& sheet, const std::filesystem::path& stem) {
  const Layout l = layout_of(sheet);
  png_file(stem, {l.width, l.height}, sheet.png_width, [&](cairo_t* on) { draw(sheet, l, on); });
}

void write_sheet(const Sheet& sheet, const std::filesystem::path& stem) {
  write_svg(sheet, stem);
  write_png(sheet, stem);
}

Line2d decimated(const Line2d& line, double tolerance) {
  constexpr double kPi = std::numbers::pi;
  Line2d out;
  if (line.empty()) return out;
  out.push_back(line.front());
  // The wedge, as angles from the direction `axis`. `open`: no limit yet.
  double axis = 0.0, low = -kPi, high = kPi, farthest = 0.0;
  bool open = true;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const auto from_last = [&] { return Eigen::Vector2d(line[i] - out.back()); };
    Eigen::Vector2d d = from_last();
    double distance = d.norm();
    const auto turn = [&] {
      return open ? 0.0 : std::remainder(std::atan2(d.y(), d.x()) - axis, 2.0 * kPi);
    };
    double angle = turn();
    if (distance < farthest || angle < low || angle > high) {
      out.push_back(line[i - 1]);
      low = -kPi, high = kPi, farthest = 0.0, open = true;
      d = from_last();
      distance = d.norm();
      angle = 0.0;
    }
    farthest = distance;
    if (distance <= tolerance) continue;  // every direction passes it
    if (open) axis = std::atan2(d.y(), d.x());
    open = false;
    const double half = std::asin(tolerance / distance);
    low = std::max(low, angle - half);
    high = std::min(high, angle + half);
  }
  if (line.size() > 1) out.push_back(line.back());
  return out;
}

double decimate_to(std::vector<Line2d>& lines, double finest, std::size_t most) {
  std::vector<Line2d> thin(lines.size());
  for (double tolerance = finest;; tolerance *= std::numbers::sqrt2) {
    std::size_t points = 0;
    for (std::size_t k = 0; k < lines.size(); ++k) {
      thin[k] = decimated(lines[k], tolerance);
      points += thin[k].size();
    }
    if (points > most && tolerance < 200.0 * finest) continue;
    lines.swap(thin);
    return tolerance;
  }
}

Envelope envelope(std::span<const double> t, const std::function<double(std::size_t)>& v,
                  std::size_t points) {
  Envelope e;
  const std::size_t n = t.size(), bins = std::max<std::size_t>(1, points / 2);
  const auto add = [&](std::size_t i, double value) {
    e.t.push_back(t[i]);
    e.v.push_back(value);
  };
  if (n <= points) {
    for (std::size_t i = 0; i < n; ++i) add(i, v(i));
    return e;
  }
  for (std::size_t b = 0; b < bins; ++b) {
    const std::size_t begin = b * n / bins, end = (b + 1) * n / bins;
    std::size_t least = end, largest = end;
    double low = 0.0, high = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const double value = v(i);
      if (!std::isfinite(value)) continue;
      if (least == end || value < low) least = i, low = value;
      if (largest == end || value > high) largest = i, high = value;
    }
    if (least == end) {
      add(begin, LogRow::kNone);
    } else {
      add(std::min(least, largest), least < largest ? low : high);
      if (least != largest) add(std::max(least, largest), least < largest ? high : low);
    }
  }
  return e;
}

}  // namespace impedraw
