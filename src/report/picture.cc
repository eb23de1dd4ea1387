#include "report/picture.h"

#include <algorithm>
#include <cmath>

#include <cairo.h>
#include <fmt/format.h>

#include "report/relief.h"
#include "report/sheet.h"
#include "report/statistics.h"

namespace impedraw {
namespace {

constexpr Colour kTarget{0.98, 0.72, 0.38}, kInk{0.09, 0.24, 0.52}, kFar{0.84, 0.10, 0.12}, kStray{0.62, 0.13, 0.66};
constexpr Colour kContour{0.55, 0.50, 0.42}, kOutline{0.36, 0.33, 0.29};

using View = std::function<Eigen::Vector2d(const Eigen::Vector3d&)>;
using Line = std::vector<Eigen::Vector2d>;

enum class Kind { on, far, stray };

// The ink as lines of one kind each, thinned to what the eye can tell; neighbours of different kind share a point.
struct InkDrawing {
  std::vector<Line> targets;
  std::vector<std::pair<Kind, Line>> ink;
  bool any(Kind kind) const {
    return std::any_of(ink.begin(), ink.end(), [kind](const auto& line) { return line.first == kind; });
  }
};

// Appends p unless it is nearer than `step` to the last point kept.
void extend(Line& line, const Eigen::Vector2d& p, double step, bool always) {
  if (line.empty() || always || (p - line.back()).norm() >= step) line.push_back(p);
}

InkDrawing prepare(const RunData& run, const Drawn& drawn, const View& view, const PictureSettings& settings) {
  double length = 0.0;  // [mm]
  for (const auto& target : drawn.targets) {
    for (std::size_t i = 0; i + 1 < target.size(); ++i) length += 1e3 * (target[i + 1] - target[i]).norm();
  }
  const double step = std::max(0.1, length / 40000.0);  // keeps a large drawing's SVG below a megabyte or so
  InkDrawing out;
  for (const auto& target : drawn.targets) {
    Line line;
    for (std::size_t i = 0; i < target.size(); ++i) extend(line, view(target[i]), step, i + 1 == target.size());
    out.targets.push_back(std::move(line));
  }
  const std::vector<bool> up = pen_must_be_up(run, drawn);
  const auto kind_of = [&](std::size_t i) {
    return up[i] ? Kind::stray : drawn.error[i] > 1e-3 * settings.highlight ? Kind::far : Kind::on;
  };
  // Touching down and lifting, within half a second of a stroke's ends, belongs to its ink.
  for (std::size_t k = 0; k < drawn.lines.size(); ++k) {
    const InkLine& ink = drawn.lines[k];
    const bool joined = k > 0 && drawn.lines[k - 1].end == ink.begin;
    Kind kind = kind_of(ink.begin);
    Line line;
    if (joined) line.push_back(view(run.contact_point[ink.begin - 1]));
    for (std::size_t i = ink.begin; i < ink.end; ++i) {
      const Eigen::Vector2d p = view(run.contact_point[i]);
      const Kind next = kind_of(i);
      extend(line, p, step, i + 1 == ink.end || next != kind);
      if (next == kind) continue;
      out.ink.emplace_back(kind, std::move(line));
      line = {p};
      kind = next;
    }
    out.ink.emplace_back(kind, std::move(line));
  }
  return out;
}

void trace(cairo_t* cr, const Line& line) {
  if (line.empty()) return;
  cairo_move_to(cr, line[0].x(), line[0].y());
  for (const Eigen::Vector2d& p : line) cairo_line_to(cr, p.x(), p.y());
}

void draw_ink(cairo_t* cr, const InkDrawing& d, const PictureSettings& settings) {
  cairo_set_line_cap(cr, CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(cr, CAIRO_LINE_JOIN_ROUND);
  cairo_set_line_width(cr, settings.target_width);
  set_colour(cr, kTarget);
  for (const Line& line : d.targets) trace(cr, line);
  cairo_stroke(cr);
  cairo_set_line_width(cr, settings.ink_width);
  for (const auto& [kind, colour] : {std::pair{Kind::on, kInk}, {Kind::far, kFar}, {Kind::stray, kStray}}) {
    set_colour(cr, colour);
    for (const auto& [k, line] : d.ink) {
      if (k == kind) trace(cr, line);
    }
    cairo_stroke(cr);
  }
}

void draw_relief(cairo_t* cr, const Relief& r) {
  if (r.columns == 0) return;
  cairo_surface_t* image = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, r.columns, r.rows);
  cairo_surface_flush(image);
  for (int i = 0; i < r.rows; ++i) {
    auto* pixels = reinterpret_cast<std::uint32_t*>(cairo_image_surface_get_data(image) + i * cairo_image_surface_get_stride(image));
    for (int j = 0; j < r.columns; ++j) {
      const double light = r.shade(i, j);
      const auto channel = [light](double dark, double bright) {
        return static_cast<std::uint32_t>(std::lround(255.0 * (dark + (bright - dark) * std::min(light, 1.0))));
      };
      pixels[j] = std::isfinite(light) ? 0xff000000u | channel(0.80, 0.995) << 16 | channel(0.77, 0.985) << 8 | channel(0.71, 0.96) : 0u;
    }
  }
  cairo_surface_mark_dirty(image);
  cairo_save(cr);
  if (!r.outline.empty()) {  // the outline is exact, the cells are not
    for (const Line& line : r.outline) trace(cr, line);
    cairo_clip(cr);
  }
  cairo_translate(cr, r.area.min().x(), r.area.min().y());
  cairo_scale(cr, r.area.sizes().x() / r.columns, r.area.sizes().y() / r.rows);
  cairo_set_source_surface(cr, image, 0, 0);
  cairo_pattern_set_filter(cairo_get_source(cr), CAIRO_FILTER_BILINEAR);
  cairo_pattern_set_extend(cairo_get_source(cr), CAIRO_EXTEND_PAD);
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
  set_colour(cr, kOutline);
  for (const Line& line : r.outline) trace(cr, line);
  cairo_stroke(cr);
}

Sheet common_sheet(const RunData& run, const Drawn& drawn, const InkDrawing& ink, const PictureSettings& settings) {
  Sheet sheet;
  const auto scenario = run.attributes.find("scenario");
  sheet.title = !settings.title.empty() ? settings.title : scenario != run.attributes.end() ? scenario->second : "drawing";
  std::vector<double> error;
  for (std::size_t i = 0; i < run.rows(); ++i) {
    if (std::isfinite(drawn.error[i])) error.push_back(1e3 * drawn.error[i]);
  }
  sheet.subtitle = error.empty() ? "no ink"
                                 : fmt::format("ink error {:.3f} mm RMS, {:.3f} mm at most", root_mean_square(error), maximum(error));
  sheet.legend = {{kTarget, settings.target_width, "target"}, {kInk, settings.ink_width, "ink"}};
  if (ink.any(Kind::far)) sheet.legend.push_back({kFar, settings.ink_width, fmt::format("ink more than {:g} mm off", settings.highlight)});
  if (ink.any(Kind::stray)) sheet.legend.push_back({kStray, settings.ink_width, "ink while the pen had to be up"});
  return sheet;
}

// The box of all that is drawn, with some air.
Eigen::AlignedBox2d extent(const InkDrawing& d) {
  Eigen::AlignedBox2d box;
  for (const Line& line : d.targets) {
    for (const Eigen::Vector2d& p : line) box.extend(p);
  }
  for (const auto& [kind, line] : d.ink) {
    for (const Eigen::Vector2d& p : line) box.extend(p);
  }
  if (box.isEmpty()) box.extend(Eigen::Vector2d::Zero());
  return box;
}

Eigen::AlignedBox2d with_margin(Eigen::AlignedBox2d box, double share) {
  const double margin = std::max(1.0, share * box.sizes().maxCoeff());
  box.min().array() -= margin;
  box.max().array() += margin;
  return box;
}

}  // namespace

void write_ink_top(const RunData& run, const Drawn& drawn, const std::filesystem::path& stem, const PictureSettings& settings) {
  const auto view = [](const Eigen::Vector3d& p) -> Eigen::Vector2d { return {-1e3 * p.y(), -1e3 * p.x()}; };
  const InkDrawing ink = prepare(run, drawn, view, settings);
  const Relief relief = make_relief(run.canvas_vertices, run.canvas_triangles,
                                    [](const Eigen::Vector3d& p) -> Eigen::Vector3d { return {-1e3 * p.y(), -1e3 * p.x(), 1e3 * p.z()}; });
  Sheet sheet = common_sheet(run, drawn, ink, settings);
  sheet.area = with_margin(relief.columns > 0 ? relief.area.merged(extent(ink)) : extent(ink), 0.03);
  sheet.u_name = "y [mm]";
  sheet.v_name = "x [mm]";
  sheet.u_sign = sheet.v_sign = -1.0;
  if (!relief.contours.empty()) sheet.legend.push_back({kContour, 0.3, fmt::format("height, every {:g} mm", relief.contour_step)});
  sheet.content = [&](cairo_t* cr) {
    draw_relief(cr, relief);
    draw_ink(cr, ink, settings);
  };
  write_sheet(sheet, stem, settings.png_width);
}

void write_ink_page(const RunData& run, const Drawn& drawn, const std::function<Eigen::Vector2d(const Eigen::Vector3d&)>& to_page,
                    const Eigen::AlignedBox2d& page, const std::filesystem::path& stem, const PictureSettings& settings) {
  const InkDrawing ink = prepare(run, drawn, to_page, settings);
  Sheet sheet = common_sheet(run, drawn, ink, settings);
  const bool no_page = page.isEmpty() || page.sizes().minCoeff() <= 0.0;
  sheet.area = no_page ? with_margin(extent(ink), 0.05) : with_margin(page.merged(extent(ink)), 0.03);
  sheet.u_name = "X on the page [mm]";
  sheet.v_name = "Y on the page [mm]";
  sheet.content = [&](cairo_t* cr) { draw_ink(cr, ink, settings); };
  write_sheet(sheet, stem, settings.png_width);
}

}  // namespace impedraw
