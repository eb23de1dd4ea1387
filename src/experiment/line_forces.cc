#include "impedraw/experiment/line_forces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace impedraw {
namespace {

constexpr double kSameWidth = 0.05;  // relative; a difference that nobody sees
constexpr double kAlike = 1.25;      // ratio of widths that is told where they are drawn alike
constexpr double kSameForce = 1e-9;  // [N]

// The widths or forces asked of the lines, and the length that the pen cannot give.
struct Asked {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;  // [mm] or [N]
  double length = 0.0, lighter = 0.0, heavier = 0.0;                   // in all, drawn so [m]

  void add(double asked, double got, double piece) {
    least = std::min(least, asked);
    most = std::max(most, asked);
    length += piece;
    if (got < asked * (1.0 - kSameWidth)) lighter += piece;
    if (got > asked * (1.0 + kSameWidth)) heavier += piece;
  }
};

std::string told(const Asked& asked, const char* what, const char* unit, double a, double b) {
  return fmt::format(
      "{} of {:.3g} to {:.3g} {} are asked for, the pen can {:.3g} to {:.3g}: of {:.0f} mm, "
      "{:.0f} mm are drawn lighter and {:.0f} mm heavier than asked",
      what, asked.least, asked.most, unit, std::min(a, b), std::max(a, b), 1e3 * asked.length,
      1e3 * asked.lighter, 1e3 * asked.heavier);
}

// The setting of the layer's pen; null: it has none.
const LayerPenSettings* setting_of(const Scenario& s, const std::string& layer, std::size_t place) {
  const auto found = std::ranges::find_if(
      s.pens, [&](const LayerPenSettings& pen) { return is_layer(pen.layer, layer, place); });
  return found == s.pens.end() ? nullptr : &*found;
}

// Entries that differ in force and speed alone are one pen; without more than these it is `pen`.
int number_of(const Scenario& s, const LayerPenSettings* given) {
  const auto body = [](LayerPenSettings pen) {
    pen.layer.clear();
    pen.force.reset();
    pen.speed.reset();
    return pen;
  };
  if (!given || body(*given) == LayerPenSettings()) return -1;
  const auto same = std::ranges::find_if(
      s.pens, [&](const LayerPenSettings& pen) { return body(pen) == body(*given); });
  return static_cast<int>(same - s.pens.begin());
}

// Speed, waits, pauses and changes of pens, of the layers' names and their pens.
void give_pace(const Scenario& s, PlacedArtwork* artwork) {
  const Artwork& drawn = artwork->shape.drawn;
  int last = 0;  // a layer; before the first one the pen is in anyhow
  int number = -2, changes = 0;
  const bool moves = s.perception.frames.enabled;
  std::string paused;
  for (std::size_t i = 0; i < drawn.strokes.size(); ++i) {
    const int layer = drawn.strokes[i].layer;
    const std::string& name = drawn.layers[static_cast<std::size_t>(layer)];
    const LayerMarks marks = layer_marks(name);
    const LayerPenSettings* const given = setting_of(s, name, static_cast<std::size_t>(layer));
    const double speed = marks.speed * (given && given->speed ? *given->speed : s.path.draw_speed);
    PlacedStroke& placed = artwork->strokes[i];
    if (speed != s.path.draw_speed) placed.speed = speed;
    const int before = std::exchange(number, number_of(s, given));
    const bool changed = i > 0 && number != before;
    changes += changed;
    if (i > 0 && layer == last) continue;
    last = layer;
    placed.wait = marks.wait;
    placed.pause = marks.pause && (!changed || moves);
    if (placed.pause) paused += (paused.empty() ? "'" : ", '") + name + "'";
  }
  if (!paused.empty())
    artwork->notes.push_back("a pause before the layer " + paused +
                             ": a person lets the run go on (Enter, the live page, SIGUSR1)");
  if (changes > 0)
    artwork->notes.push_back(
        moves ? "on a canvas that moves one pen draws all layers: pens are not changed"
              : fmt::format("pens are changed {} time{}, and a person lets the run go on each "
                            "time; the time for it is not planned",
                            changes, changes == 1 ? "" : "s"));
}

// All lines once for each of the cutter's passes, with the force and the depth of that pass.
void give_cuts(const Scenario& s, const CutterSettings& cutter, PlacedArtwork* artwork) {
  const auto lay = [](auto* lines, std::size_t n, std::size_t passes) {
    lines->reserve(n * passes);
    for (std::size_t i = n; i < n * passes; ++i) lines->push_back((*lines)[i - n]);
  };
  const std::vector<double> depths = depths_of(s.tool);
  const std::size_t n = artwork->strokes.size();
  lay(&artwork->shape.drawn.strokes, n, depths.size());
  if (auto& ideal = artwork->shape.ideal)
    lay(&ideal->strokes, ideal->strokes.size(), depths.size());
  const auto cut = [&](std::vector<PlacedStroke>* lines) {
    const std::size_t one = lines->size();
    lay(lines, one, depths.size());
    for (std::size_t i = 0; i < lines->size(); ++i) {
      PlacedStroke& line = (*lines)[i];
      const std::size_t pass = i / one;
      if (pass > 0) line.number += static_cast<int>(pass * one);
      if (pass > 0) line.depth = depths[pass];
      const double speed = line.speed > 0.0 ? line.speed : s.path.draw_speed,
                   before = pass > 0 ? depths[pass - 1] : 0.0;
      line.force.assign(line.p_P.size(), cut_forces(cutter, depths[pass], before, speed).normal);
    }
  };
  cut(&artwork->strokes);
  if (artwork->ideal) cut(&*artwork->ideal);
}

}  // namespace

std::vector<DrawnPen> layer_pens(const Scenario& s, const Artwork& artwork,
                                 const SettingErrors& setting_errors) {
  for (std::size_t i = 0; i < s.pens.size(); ++i) {
    bool used = false;
    for (std::size_t k = 0; k < artwork.layers.size(); ++k)
      used = used || setting_of(s, artwork.layers[k], k) == &s.pens[i];
    const std::string at = fmt::format("pens.{}", i);
    if (!used)
      setting_errors.raise(
          {at + ".layer", at, "pens"},
          fmt::format("{}.layer is '{}', no layer of {}; there are {}", at, s.pens[i].layer,
                      artwork.name, fmt::join(artwork.layers, ", ")));
    if (!s.pens[i].colour.empty() && !named_colour(s.pens[i].colour))
      setting_errors.raise({at + ".colour", at, "pens"},
                           fmt::format("{}.colour is '{}'; valid are #rrggbb and names such as red",
                                       at, s.pens[i].colour));
  }
  std::vector<DrawnPen> pens;
  for (std::size_t k = 0; k < artwork.layers.size(); ++k) {
    DrawnPen& pen = pens.emplace_back(DrawnPen{s.pen, layer_marks(artwork.layers[k]).name});
    for (const Stroke& stroke : artwork.strokes)
      if (stroke.layer == static_cast<int>(k) && !pen.colour) pen.colour = stroke.colour;
    const LayerPenSettings* const given = setting_of(s, artwork.layers[k], k);
    pen.number = number_of(s, given);
    if (!given) continue;
    if (!given->colour.empty()) pen.colour = named_colour(given->colour);
    pen.line.width = given->width.value_or(s.pen.width);
    pen.line.width_per_newton = given->width_per_newton.value_or(s.pen.width_per_newton);
    pen.line.nominal_force = given->nominal_force.value_or(s.pen.nominal_force);
  }
  return pens;
}

void give_forces(const Scenario& s, const SettingErrors& setting_errors, PlacedArtwork* artwork) {
  const std::vector<DrawnPen> pens = layer_pens(s, artwork->shape.drawn, setting_errors);
  give_pace(s, artwork);
  if (s.pen.check && s.control.source == WrenchSource::none)
    setting_errors.raise({"pen.check", "control.wrench"},
                         "pen.check needs a measured wrench, and control.wrench is none; valid are "
                         "the other sources, or pen.check false");
  if (s.pen.check && !s.pen.spot && !s.perception.enabled)
    setting_errors.raise({"pen.check"},
                         "pen.check: without perception nothing tells where the drawing begins; "
                         "valid is pen.spot, a known place");
  if (const auto cutter = cutter_of(s.tool)) {
    give_cuts(s, *cutter, artwork);
    return;
  }
  if (s.pen.least_force > s.pen.most_force)
    setting_errors.raise({"pen.least_force", "pen.most_force"},
                         fmt::format("pen.least_force is {} N, above pen.most_force, {} N",
                                     s.pen.least_force, s.pen.most_force));
  const double scale = artwork->placement.scale();
  const bool follows = s.perception.enabled || s.blind.height == BlindHeight::touch;
  const std::vector<Stroke>& drawn = artwork->shape.drawn.strokes;
  Asked widths, forces;
  bool presses = false;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const Stroke& stroke = drawn[i];
    PlacedStroke& placed = artwork->strokes[i];
    const auto layer = static_cast<std::size_t>(stroke.layer);
    const PenSettings& pen = pens[layer].line;
    const LayerPenSettings* const given = setting_of(s, artwork->shape.drawn.layers[layer], layer);
    const double plain =
        given ? given->force.value_or(s.control.normal_force) : s.control.normal_force;
    presses = presses || pen.presses();
    const bool by_force = stroke.by_force && !stroke.press.empty();
    const std::size_t n = stroke.points.size();
    std::vector<double> force;
    for (std::size_t k = 0; k < n; ++k) {
      double asked = stroke.press.empty() ? stroke.width : stroke.press[k];
      if (!by_force) asked *= scale;
      const double piece = 0.5 * ((k > 0 ? (placed.p_P[k] - placed.p_P[k - 1]).norm() : 0.0) +
                                  (k + 1 < n ? (placed.p_P[k + 1] - placed.p_P[k]).norm() : 0.0));
      const bool known = asked > 0.0 || !stroke.press.empty();
      force.push_back(by_force                 ? pen.within(asked)
                      : known && pen.presses() ? pen.force_for(asked)
                                               : plain);
      if (known)
        by_force ? forces.add(asked, force.back(), piece)
                 : widths.add(asked, pen.width_at(force.back()), piece);
    }
    const bool same = std::ranges::all_of(
        force, [&](double f) { return std::abs(f - s.control.normal_force) < kSameForce; });
    if (follows && !same) placed.force = std::move(force);
  }
  if (!follows && (forces.length > 0.0 || (presses && widths.length > 0.0))) {
    artwork->notes.push_back(
        "widths and forces of lines are passed over: without perception the force is a spring's");
    return;
  }
  if (presses && widths.lighter + widths.heavier > 0.0)
    artwork->notes.push_back(told(widths, "lines", "mm", s.pen.width_at(s.pen.least_force),
                                  s.pen.width_at(s.pen.most_force)));
  if (!presses && widths.most > kAlike * widths.least)
    artwork->notes.push_back(fmt::format(
        "lines of {:.3g} to {:.3g} mm are drawn alike: this pen's width does not change with the "
        "force (pen.width_per_newton is 0)",
        widths.least, widths.most));
  if (forces.lighter + forces.heavier > 0.0)
    artwork->notes.push_back(told(forces, "forces", "N", s.pen.least_force, s.pen.most_force));
}

double hardest(const Scenario& scenario, const std::vector<PlacedStroke>& strokes) {
  double most = scenario.control.normal_force;
  for (const PlacedStroke& stroke : strokes)
    for (const double f : stroke.force) most = std::max(most, f);
  return most;
}

}  // namespace impedraw
