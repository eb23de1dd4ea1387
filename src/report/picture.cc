#include "impedraw/report/picture.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <cairo.h>
#include <fmt/format.h>

#include "impedraw/metrics/statistics.h"
#include "impedraw/report/relief.h"
#include "impedraw/report/sheet.h"

namespace impedraw {
namespace {

constexpr Colour kTarget{0.98, 0.72, 0.38}, kInk{0.09, 0.24, 0.52}, kFar{0.84, 0.10, 0.12},
    kStray{0.62, 0.13, 0.66}, kLeftOut{0.0, 0.52, 0.42};

using View = std::function<Eigen::Vector2d(const Eigen::Vector3d&)>;

// Point spacing and finest tolerance of lines [mm]; smaller details are not visible.
// kMostPoints points make an SVG of 3 MB.
constexpr double kSpacing = 0.1, kFinest = 0.02;
constexpr std::size_t kMostPoints = 150000;

enum class Kind { on, far, stray };

struct Style {
  Kind kind = Kind::on;
  double width = 0.0;  // [mm]
  int pen = 0;
  bool operator==(const Style&) const = default;
};

// The ink as lines of one style each, thinned to the visible detail. Adjacent lines of different
// style share a point.
struct InkDrawing {
  std::vector<Line2d> targets;
  std::vector<Line2d> left_out;
  std::vector<Line2d> ink;
  std::vector<Style> style;  // of each ink line
  bool any(Kind kind) const {
    return std::any_of(style.begin(), style.end(),
                       [kind](const Style& s) { return s.kind == kind; });
  }
};

// Line2d width at force f, quantised to barely visible steps. Keeps the width `before` while it is
// within one step.
double drawn_width(const PenSettings& pen, double f, double before) {
  if (pen.width_per_newton == 0.0) return pen.width;
  const double step = 0.05 * pen.width;
  const double width = pen.width_at(f);
  return std::abs(width - before) <= step ? before : step * std::round(width / step);
}

InkDrawing prepare(const RunData& run, const InkMatch& drawn, const View& view,
                   const PictureSettings& settings) {
  InkDrawing out;
  for (const auto& target : drawn.targets) {
    Line2d line;
    for (std::size_t i = 0; i < target.size(); ++i)
      extend(line, view(target[i]), kSpacing, i + 1 == target.size());
    out.targets.push_back(std::move(line));
  }
  decimate_to(out.targets, kFinest, kMostPoints);
  for (const auto& part : settings.left_out) {
    Line2d& line = out.left_out.emplace_back();
    for (const Eigen::Vector3d& p_W : part) line.push_back(view(p_W));
  }
  decimate_to(out.left_out, kFinest, kMostPoints);
  const std::vector<bool> up = pen_must_be_up(run, drawn);
  // The width changes at most once per millimetre, so a noisy force does not fragment the line.
  const auto style_at = [&](std::size_t i, const Style& before, double length) {
    const Kind kind = up[i]                                        ? Kind::stray
                      : drawn.error[i] > 1e-3 * settings.highlight ? Kind::far
                                                                   : Kind::on;
    const int number = settings.pens ? settings.pens->number_of(run.stroke[i]) : 0;
    const PenSettings& pen =
        settings.pens ? settings.pens->pens[static_cast<std::size_t>(number)].line : settings.pen;
    const bool same = length < 1.0 && number == before.pen;
    return Style{kind, same ? before.width : drawn_width(pen, run.f[i], before.width), number};
  };
  const auto keep = [&out](const Style& style, Line2d line) {
    out.style.push_back(style);
    out.ink.push_back(std::move(line));
  };
  // A stroke's ink includes touchdown and lift-off within half a second of its ends.
  for (std::size_t k = 0; k < drawn.lines.size(); ++k) {
    const InkLine& ink = drawn.lines[k];
    const bool joined = k > 0 && drawn.lines[k - 1].end == ink.begin;
    Style style = style_at(ink.begin, {}, 1.0);
    Line2d line;
    double length = 0.0;  // with this width [mm]
    if (joined) line.push_back(view(run.contact_point[ink.begin - 1]));
    for (std::size_t i = ink.begin; i < ink.end; ++i) {
      const Eigen::Vector2d p = view(run.contact_point[i]);
      if (i > ink.begin) length += 1e3 * (run.contact_point[i] - run.contact_point[i - 1]).norm();
      const Style next = style_at(i, style, length);
      extend(line, p, kSpacing, i + 1 == ink.end || next != style);
      if (next == style) continue;
      keep(style, std::move(line));
      line = {p};
      if (next.width != style.width) length = 0.0;
      style = next;
    }
    keep(style, std::move(line));
  }
  decimate_to(out.ink, kFinest, kMostPoints);
  return out;
}

Colour colour_of(const PictureSettings& settings, int pen) {
  if (!settings.pens) return kInk;
  const auto colour = settings.pens->pens[static_cast<std::size_t>(pen)].colour;
  return colour ? colour_from(*colour) : kInk;
}

void draw_ink(cairo_t* cr, const InkDrawing& d, const PictureSettings& settings) {
  round_lines(cr);
  cairo_set_line_width(cr, settings.target_width);
  set_colour(cr, kTarget);
  for (const Line2d& line : d.targets) trace(cr, line);
  cairo_stroke(cr);
  if (!d.left_out.empty()) {
    set_dash(cr, 2.0 * settings.pen.width, 2.0 * settings.pen.width);
    cairo_set_line_width(cr, settings.pen.width);
    set_colour(cr, kLeftOut);
    for (const Line2d& line : d.left_out) trace(cr, line);
    cairo_stroke(cr);
    set_dash(cr);
  }
  for (const auto& [kind, colour] :
       {std::pair{Kind::on, kInk}, {Kind::far, kFar}, {Kind::stray, kStray}}) {
    std::map<std::pair<int, double>, std::vector<const Line2d*>> of_style;
    for (std::size_t i = 0; i < d.ink.size(); ++i) {
      if (d.style[i].kind == kind)
        of_style[{d.style[i].pen, d.style[i].width}].push_back(&d.ink[i]);
    }
    for (const auto& [style, lines] : of_style) {
      set_colour(cr, kind == Kind::on ? colour_of(settings, style.first) : colour);
      cairo_set_line_width(cr, style.second);
      for (const Line2d* line : lines) trace(cr, *line);
      cairo_stroke(cr);
    }
  }
}

Sheet common_sheet(const RunData& run, const InkMatch& drawn, const InkDrawing& ink,
                   const PictureSettings& settings) {
  Sheet sheet;
  const auto scenario = run.attributes.find("scenario");
  sheet.title = !settings.title.empty()            ? settings.title
                : scenario != run.attributes.end() ? scenario->second
                                                   : "drawing";
  std::vector<double> error;
  for (std::size_t i = 0; i < run.rows(); ++i) {
    if (std::isfinite(drawn.error[i])) error.push_back(1e3 * drawn.error[i]);
  }
  sheet.subtitle = error.empty() ? "no ink"
                                 : fmt::format("ink error {:.3f} mm RMS, {:.3f} mm at most",
                                               root_mean_square(error), maximum(error));
  const PenSettings& pen = settings.pen;
  std::string ink_text = "ink";
  if (pen.width_per_newton != 0.0)
    ink_text += fmt::format(", {:g} mm wide at {:g} N, {:+g} mm/N", pen.width, pen.nominal_force,
                            pen.width_per_newton);
  sheet.legend = {{kTarget, settings.target_width, "target"}, {kInk, pen.width, ink_text}};
  if (settings.pens && settings.pens->pens.size() > 1) {
    sheet.legend.pop_back();
    for (std::size_t i = 0; i < settings.pens->pens.size(); ++i)
      sheet.legend.push_back({colour_of(settings, static_cast<int>(i)),
                              settings.pens->pens[i].line.width, settings.pens->pens[i].name});
  }
  if (!ink.left_out.empty())
    sheet.legend.push_back({kLeftOut, pen.width, "left out: cannot be drawn"});
  if (ink.any(Kind::far))
    sheet.legend.push_back(
        {kFar, pen.width, fmt::format("ink more than {:g} mm off", settings.highlight)});
  if (ink.any(Kind::stray))
    sheet.legend.push_back({kStray, pen.width, "ink while the pen had to be up"});
  return sheet;
}

// Bounding box of the drawing, with a margin.
Eigen::AlignedBox2d extent(const InkDrawing& d) {
  Eigen::AlignedBox2d box;
  for (const std::vector<Line2d>* lines : {&d.targets, &d.ink, &d.left_out}) extend(&box, *lines);
  if (box.isEmpty()) box.extend(Eigen::Vector2d::Zero());
  return box;
}

// (right, down, towards the viewer) [mm]
Eigen::Vector3d seen_along_axis(const Eigen::Matrix3d& R_PW, const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d p = R_PW * p_W;
  return {-1e3 * p.y(), -1e3 * p.x(), 1e3 * p.z()};
}

Picture picture_of(Sheet sheet) {
  const auto drawn = std::make_shared<const Sheet>(std::move(sheet));
  return {[drawn](const std::filesystem::path& stem) { write_svg(*drawn, stem); },
          [drawn](const std::filesystem::path& stem) { write_png(*drawn, stem); }};
}

}  // namespace

std::shared_ptr<const Relief> ink_relief(const std::vector<Eigen::Vector3d>& vertices,
                                         const std::vector<Eigen::Vector3i>& triangles,
                                         const Eigen::Matrix3d& R_WP) {
  load_fonts();  // whoever makes the background early has the fonts at hand, too
  return std::make_shared<const Relief>(make_relief(
      vertices, triangles, [R_PW = Eigen::Matrix3d(R_WP.transpose())](const Eigen::Vector3d& p_W) {
        return seen_along_axis(R_PW, p_W);
      }));
}

Picture ink_top(const RunData& run, const InkMatch& drawn, const PictureSettings& settings) {
  const Eigen::Matrix3d R_PW = settings.R_WP.transpose();
  const auto view = [&R_PW](const Eigen::Vector3d& p_W) -> Eigen::Vector2d {
    return seen_along_axis(R_PW, p_W).head<2>();
  };
  const InkDrawing ink = prepare(run, drawn, view, settings);
  const std::shared_ptr<const Relief> below =
      settings.relief ? settings.relief
                      : ink_relief(run.canvas_vertices, run.canvas_triangles, settings.R_WP);
  const Relief& relief = *below;
  Sheet sheet = common_sheet(run, drawn, ink, settings);
  sheet.area =
      with_margin(relief.columns > 0 ? relief.area.merged(extent(ink)) : extent(ink), 0.03);
  sheet.u_name = "y [mm]";
  sheet.v_name = "x [mm]";
  sheet.u_sign = sheet.v_sign = -1.0;
  if (!relief.outline.empty() && !relief.is_sheet)
    sheet.legend.push_back({kOutline, 0.7, "edge or hole; dashed: hidden"});
  if (!relief.contours.empty())
    sheet.legend.push_back(
        {kContour, 0.3, fmt::format("height, every {:g} mm", relief.contour_step)});
  sheet.content = [below, ink, settings](cairo_t* cr) {
    draw_relief(cr, *below);
    draw_ink(cr, ink, settings);
  };
  return picture_of(std::move(sheet));
}

Picture ink_page(const RunData& run, const InkMatch& drawn,
                 const std::function<Eigen::Vector2d(const Eigen::Vector3d&)>& to_page,
                 const Eigen::AlignedBox2d& page, const PictureSettings& settings) {
  const InkDrawing ink = prepare(run, drawn, to_page, settings);
  Sheet sheet = common_sheet(run, drawn, ink, settings);
  const bool no_page = page.isEmpty() || page.sizes().minCoeff() <= 0.0;
  sheet.area =
      no_page ? with_margin(extent(ink), 0.05) : with_margin(page.merged(extent(ink)), 0.03);
  sheet.u_name = "X on the page [mm]";
  sheet.v_name = "Y on the page [mm]";
  sheet.content = [ink, settings](cairo_t* cr) { draw_ink(cr, ink, settings); };
  return picture_of(std::move(sheet));
}

}  // namespace impedraw
