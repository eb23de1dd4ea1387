#include "impedraw/experiment/preview_of.h"

#include <fmt/format.h>

#include "impedraw/drawing/layers.h"
#include "impedraw/planning/stroke_part.h"

namespace impedraw {

namespace {

PreviewLine line_of(const Stroke& stroke, const Placement& placement, double width) {
  PreviewLine line;
  for (const Eigen::Vector2d& p : stroke.points)
    line.points.push_back(placement.scale() * (p - placement.origin_mm));
  line.width.assign(line.points.size(), width);
  return line;
}

// The width that the pen draws at each point [mm].
std::vector<double> drawn_widths(const PlacedStroke& stroke, const PenSettings& pen, double force) {
  std::vector<double> widths(stroke.page.size(), pen.width_at(force));
  for (std::size_t i = 0; i < stroke.force.size(); ++i) widths[i] = pen.width_at(stroke.force[i]);
  return widths;
}

}  // namespace

std::vector<PenSum> sums_of(const DrawnPens& pens, const std::vector<PlacedStroke>& strokes,
                            const TipPath& path) {
  std::vector<PenSum> sums(pens.pens.size());
  double before = 0.0;
  for (const StrokeTimes& times : path.strokes()) {
    PenSum& sum = sums[static_cast<std::size_t>(pens.number_of(times.number))];
    ++sum.strokes;
    sum.length += 1e3 * plane_length(strokes[static_cast<std::size_t>(times.number)]);
    sum.time += times.end - std::exchange(before, times.end);
  }
  return sums;
}

std::string pen_text(const DrawnPen& pen, const PenSum& sum) {
  return fmt::format("{}: {} stroke{}, {:.0f} mm, {:.0f} s", pen.name.empty() ? "pen" : pen.name,
                     sum.strokes, sum.strokes == 1 ? "" : "s", sum.length, sum.time);
}

std::string ink_text(const DrawnPen& pen, const PenSum& sum) {
  return fmt::format(
      "{}; {}, {:.3g} mm wide at {:.3g} N{}", pen_text(pen, sum),
      colour_name(pen.colour.value_or(0)), pen.line.width, pen.line.nominal_force,
      pen.line.presses() ? fmt::format(", {:+.3g} mm/N", pen.line.width_per_newton) : "");
}

PreviewPicture preview_of(const Scenario& s, const SettingErrors& setting_errors,
                          const PlacedArtwork& artwork, const std::vector<DrawnPen>& pens,
                          const std::vector<PenSum>& sums) {
  const Artwork& drawn = artwork.shape.drawn;
  PreviewPicture picture;
  picture.title = s.name;
  Eigen::AlignedBox2d box;
  for (std::size_t i = 0; i < drawn.strokes.size(); ++i) {
    const Stroke& stroke = drawn.strokes[i];
    PreviewLine& line = picture.lines.emplace_back(line_of(stroke, artwork.placement, 1.0));
    line.pen = pens.size() > 1 ? stroke.layer : 0;
    line.width = drawn_widths(artwork.strokes[i], pens[static_cast<std::size_t>(line.pen)].line,
                              s.control.normal_force);
    for (const Eigen::Vector2d& p : line.points) box.extend(p);
  }
  if (drawn.hidden_mm > 0.0) {
    DrawingSettings all = s.drawing;
    all.visible = Visible::all;
    all.hatch.spacing_mm = 0.0;
    for (const Stroke& stroke : make_artwork(all, setting_errors).drawn.strokes) {
      const auto pen = std::min(static_cast<std::size_t>(stroke.layer), pens.size() - 1);
      picture.whole.push_back(line_of(stroke, artwork.placement, pens[pen].line.width));
    }
  }
  for (std::size_t k = 0; k < pens.size(); ++k)
    picture.pens.push_back(
        {pen_text(pens[k], sums[k]), pens[k].colour.value_or(0), pens[k].line.width});
  if (box.isEmpty()) box.extend(Eigen::Vector2d::Zero());
  picture.subtitle = fmt::format("{:.1f} × {:.1f} mm as drawn", box.sizes().x(), box.sizes().y());
  return picture;
}

}  // namespace impedraw
