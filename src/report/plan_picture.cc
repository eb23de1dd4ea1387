#include "impedraw/report/plan_picture.h"

#include <cmath>
#include <map>

#include "impedraw/report/relief.h"
#include "impedraw/report/sheet.h"

namespace impedraw {
namespace {

constexpr double kWidth = 0.7;  // of a line [mm]
constexpr Colour kDrawable{0.09, 0.24, 0.52};
constexpr Colour kProblems[] = {{0.84, 0.10, 0.12}, {0.93, 0.49, 0.06}, {0.62, 0.13, 0.66},
                                {0.05, 0.55, 0.42}, {0.55, 0.34, 0.16}, {0.90, 0.35, 0.60},
                                {0.45, 0.45, 0.45}, {0.60, 0.72, 0.10}, {0.35, 0.20, 0.80},
                                {0.80, 0.62, 0.00}, {0.45, 0.00, 0.10}, {0.00, 0.35, 0.20},
                                {0.95, 0.60, 0.55}};  // one for each problem

using Eigen::Vector2d;

constexpr Colour kHidden{0.80, 0.80, 0.80}, kAir{0.55, 0.70, 0.90}, kNumber{0.35, 0.35, 0.35};
constexpr std::size_t kMostNumbers = 60;
constexpr double kSameWidth = 0.05;  // relative

// The line in pieces of about one width.
void draw_line(cairo_t* cr, const PreviewLine& line) {
  std::vector<Vector2d> piece{line.points.front()};
  double width = line.width.front();
  const auto draw = [&] {
    if (piece.size() == 1) piece.push_back(piece.front() + Vector2d(0.01, 0.0));  // a dot
    cairo_set_line_width(cr, width);
    trace(cr, piece);
    cairo_stroke(cr);
  };
  for (std::size_t i = 1; i < line.points.size(); ++i) {
    const double next = 0.5 * (line.width[i - 1] + line.width[i]);
    if (piece.size() > 1 && std::abs(next - width) > kSameWidth * width) {
      draw();
      piece = {line.points[i - 1]};
    }
    if (piece.size() == 1) width = next;
    piece.push_back(line.points[i]);
  }
  draw();
}

void draw_ways(cairo_t* cr, const std::vector<PreviewLine>& lines, double fine) {
  set_dash(cr, 4.0 * fine, 4.0 * fine);
  cairo_set_line_width(cr, fine);
  set_colour(cr, kAir);
  for (std::size_t i = 1; i < lines.size(); ++i)
    trace(cr, {lines[i - 1].points.back(), lines[i].points.front()});
  cairo_stroke(cr);
  set_dash(cr);
}

}  // namespace

void write_plan(const PlanPicture& plan, const std::filesystem::path& stem) {
  // In page orientation: right is −y of P, down is −x.
  const auto view = [](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return {-1e3 * p.y(), -1e3 * p.x(), 1e3 * p.z()};
  };
  // By problem, "" first, and pen.
  std::map<std::pair<std::string, int>, std::vector<std::vector<Eigen::Vector2d>>> groups;
  Eigen::AlignedBox2d box;
  for (const PlanLine& line : plan.lines) {
    std::vector<Eigen::Vector2d> thin;
    for (const Eigen::Vector3d& p : line.points) thin.push_back(view(p).head<2>());
    if (thin.size() == 1)
      thin.push_back(thin.front() +
                     Eigen::Vector2d(0.01, 0.0));  // a dot, drawn by the round line cap
    for (const Eigen::Vector2d& p : thin) box.extend(p);
    groups[{line.problem, line.problem.empty() ? line.pen : 0}].push_back(std::move(thin));
  }
  for (auto& [group, lines] : groups) decimate_to(lines, 0.02, 150000);
  const Relief relief = make_relief(plan.canvas_vertices, plan.canvas_triangles, view);
  if (relief.columns > 0) box.extend(relief.area);
  if (box.isEmpty()) box.extend(Eigen::Vector2d::Zero());

  Sheet sheet;
  sheet.title = plan.title;
  sheet.subtitle = plan.subtitle;
  sheet.area = with_margin(box, 0.03);
  sheet.u_name = "y of the drawing plane [mm]";
  sheet.v_name = "x of the drawing plane [mm]";
  sheet.u_sign = sheet.v_sign = -1.0;
  std::vector<LegendEntry> looks;  // of the groups
  std::size_t next = 0;
  for (const auto& [group, lines] : groups) {
    const auto& [problem, pen] = group;
    if (!problem.empty())
      looks.push_back({kProblems[next++ % std::size(kProblems)], 1.6 * kWidth, problem});
    else if (const auto k = static_cast<std::size_t>(pen); k < plan.pens.size())
      looks.push_back({colour_from(plan.pens[k].colour), plan.pens[k].width, plan.pens[k].text});
    else
      looks.push_back({kDrawable, kWidth, "can be drawn"});
  }
  sheet.legend = looks;
  if (!relief.contours.empty()) sheet.legend.push_back({kContour, 0.3, "height contours"});
  sheet.content = [&](cairo_t* cr) {
    draw_relief(cr, relief);
    round_lines(cr);
    std::size_t i = 0;
    for (const auto& [group, lines] : groups) {  // strokes that cannot be drawn lie on top
      cairo_set_line_width(cr, looks[i].width);
      set_colour(cr, looks[i++].colour);
      for (const auto& line : lines) trace(cr, line);
      cairo_stroke(cr);
    }
  };
  write_sheet(sheet, stem);
}

void write_preview(const PreviewPicture& preview, const std::filesystem::path& stem) {
  Eigen::AlignedBox2d box;
  for (const std::vector<PreviewLine>* lines : {&preview.lines, &preview.whole})
    for (const PreviewLine& line : *lines)
      for (const Vector2d& p : line.points) box.extend(p);
  if (box.isEmpty()) box.extend(Vector2d::Zero());
  Sheet sheet;
  sheet.title = preview.title;
  sheet.subtitle = preview.subtitle;
  sheet.area = with_margin(box, 0.03);
  sheet.u_name = "to the right [mm]";
  sheet.v_name = "down [mm]";
  const double fine = std::max(0.1, sheet.area.sizes().maxCoeff() / 800.0);  // of thin lines [mm]
  for (const PreviewPen& pen : preview.pens)
    sheet.legend.push_back({colour_from(pen.colour), pen.width, pen.text});
  if (!preview.whole.empty()) sheet.legend.push_back({kHidden, 4.0 * fine, "hidden, not drawn"});
  sheet.legend.push_back({kAir, fine, "in the air"});
  sheet.content = [&](cairo_t* cr) {
    round_lines(cr);
    set_colour(cr, kHidden);
    for (const PreviewLine& line : preview.whole) draw_line(cr, line);
    for (const PreviewLine& line : preview.lines) {
      set_colour(cr, colour_from(preview.pens[static_cast<std::size_t>(line.pen)].colour));
      draw_line(cr, line);
    }
    draw_ways(cr, preview.lines, fine);
    if (preview.lines.size() > kMostNumbers) return;
    set_colour(cr, kNumber);
    cairo_set_font_size(cr, 16.0 * fine);
    for (std::size_t i = 0; i < preview.lines.size(); ++i) {
      const Vector2d& p = preview.lines[i].points.front();
      show_text(cr, p.x() + 4.0 * fine, p.y() - 4.0 * fine, std::to_string(i + 1));
    }
  };
  sheet.png_width = 1400;
  write_sheet(sheet, stem);
}

}  // namespace impedraw
