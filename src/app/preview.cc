#include <numeric>

#include <fmt/format.h>

#include "impedraw/app/commands.h"
#include "impedraw/common/errors.h"
#include "impedraw/drawing/layers.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/line_forces.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/stroke_part.h"
#include "impedraw/report/preview_picture.h"
#include "impedraw/terminal/say.h"

namespace impedraw {

namespace fs = std::filesystem;

namespace {

// A pen's part of the drawing.
struct PenSum {
  std::size_t strokes = 0;
  double length = 0.0, time = 0.0;  // [mm], [s]; time on a plane, with the ways to its strokes
};

PreviewLine line_of(const Stroke& stroke, const Placement& placement, double width) {
  PreviewLine line;
  for (const Eigen::Vector2d& p : stroke.points)
    line.points.push_back(placement.scale() * (p - placement.origin_mm));
  line.width.assign(line.points.size(), width);
  line.pen = stroke.layer;
  return line;
}

// The width that the pen draws at each point [mm].
std::vector<double> drawn_widths(const PlacedStroke& stroke, const PenSettings& pen, double force) {
  std::vector<double> widths(stroke.page.size(), pen.width_at(force));
  for (std::size_t i = 0; i < stroke.force.size(); ++i) widths[i] = pen.width_at(stroke.force[i]);
  return widths;
}

std::vector<PenSum> sums_of(const Scenario& s, const PlacedArtwork& artwork, std::size_t pens) {
  std::vector<PenSum> sums(pens);
  PathSettings flat = s.path;
  flat.start_p_WE = {s.drawing.placement.centre_m.x(), s.drawing.placement.centre_m.y(), 0.1};
  const TipPath path = plan_tip_path(artwork.strokes, level_surface(0.0), flat);
  double before = 0.0;
  for (std::size_t i = 0; i < artwork.strokes.size(); ++i) {
    PenSum& sum = sums[static_cast<std::size_t>(artwork.shape.drawn.strokes[i].layer)];
    ++sum.strokes;
    sum.length += 1e3 * plane_length(artwork.strokes[i]);
    sum.time += path.strokes()[i].end - before;
    before = path.strokes()[i].end;
  }
  return sums;
}

}  // namespace

int preview(const DrawOptions& options) {
  Places places;
  const Scenario scenario = resolve(options, &places);
  const SettingErrors setting_errors(places);
  PlacedArtwork artwork = load_artwork(scenario.drawing, setting_errors);
  give_forces(scenario, setting_errors, &artwork);
  const Artwork& drawn = artwork.shape.drawn;
  const std::vector<DrawnPen> pens = layer_pens(scenario, drawn, setting_errors);
  const std::vector<PenSum> sums = sums_of(scenario, artwork, pens.size());

  PreviewPicture picture;
  Eigen::AlignedBox2d box;
  for (std::size_t i = 0; i < drawn.strokes.size(); ++i) {
    const Stroke& stroke = drawn.strokes[i];
    PreviewLine& line = picture.lines.emplace_back(line_of(stroke, artwork.placement, 1.0));
    line.width = drawn_widths(artwork.strokes[i], pens[static_cast<std::size_t>(stroke.layer)].line,
                              scenario.control.normal_force);
    for (const Eigen::Vector2d& p : line.points) box.extend(p);
  }
  if (drawn.hidden_mm > 0.0) {
    DrawingSettings all = scenario.drawing;
    all.visible = Visible::all;
    all.hatch.spacing_mm = 0.0;
    for (const Stroke& stroke : make_artwork(all, setting_errors).drawn.strokes)
      picture.whole.push_back(line_of(stroke, artwork.placement, scenario.pen.width));
  }
  const double time = std::accumulate(sums.begin(), sums.end(), 0.0,
                                      [](double t, const PenSum& sum) { return t + sum.time; });
  const std::string size =
      fmt::format("{:.1f} × {:.1f} mm as drawn", box.sizes().x(), box.sizes().y());
  const auto strokes = [](std::size_t n) {
    return fmt::format("{} stroke{}", n, n == 1 ? "" : "s");
  };
  std::string text = fmt::format("{}: {}, {}, about {:.0f} s on a plane\n", drawn.name,
                                 strokes(drawn.strokes.size()), size, time);
  for (std::size_t k = 0; k < pens.size(); ++k) {
    const DrawnPen& pen = pens[k];
    const std::string what =
        fmt::format("{}: {}, {:.0f} mm, {:.0f} s", pen.name.empty() ? "pen" : pen.name,
                    strokes(sums[k].strokes), sums[k].length, sums[k].time);
    picture.pens.push_back({what, pen.colour.value_or(0), pen.line.width});
    text += fmt::format(
        "  pen          {}; {}, {:.3g} mm wide at {:.3g} N{}\n", what,
        colour_name(pen.colour.value_or(0)), pen.line.width, pen.line.nominal_force,
        pen.line.presses() ? fmt::format(", {:+.3g} mm/N", pen.line.width_per_newton) : "");
  }
  if (drawn.hidden_mm > 0.0)
    text += fmt::format("  hidden       {:.1f} mm on the page\n", drawn.hidden_mm);
  if (drawn.doubled_mm > 0.0)
    text += fmt::format("  doubled      {:.1f} mm on the page\n", drawn.doubled_mm);
  for (const std::string& note : artwork.notes) text += "  note         " + note + "\n";
  picture.title = scenario.name;
  picture.subtitle = fmt::format("{}, about {:.0f} s on a plane", size, time);
  fs::path stem = options.out.empty() ? fs::path(scenario.name + "-preview") : options.out;
  if (stem.extension() == ".png" || stem.extension() == ".svg") stem.replace_extension();
  if (stem.has_parent_path()) fs::create_directories(stem.parent_path());
  write_preview(picture, stem);
  say(stdout, "{}picture  {}.png\n", text, fs::absolute(stem).lexically_normal().string());
  return kFinished;
}

}  // namespace impedraw
