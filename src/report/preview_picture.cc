#include "impedraw/report/preview_picture.h"

#include <cmath>

#include "impedraw/report/relief.h"

namespace impedraw {

namespace {

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
  write_sheet(sheet, stem, preview.png_width);
}

}  // namespace impedraw
