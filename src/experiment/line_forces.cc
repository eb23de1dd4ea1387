#include "impedraw/experiment/line_forces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace impedraw {

namespace {

constexpr double kSameWidth = 0.05;  // relative; a difference that nobody sees
constexpr double kSameForce = 1e-9;  // [N]

// What is asked of the lines, and how much of their length the pen cannot give.
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

}  // namespace

void give_forces(const Scenario& s, const SettingErrors& setting_errors, PlacedArtwork* artwork) {
  const PenSettings& pen = s.pen;
  if (pen.least_force > pen.most_force)
    setting_errors.raise({"pen.least_force", "pen.most_force"},
                         fmt::format("pen.least_force is {} N, above pen.most_force, {} N",
                                     pen.least_force, pen.most_force));
  const double scale = artwork->placement.scale();
  const bool follows = s.perception.enabled || s.blind.height == BlindHeight::touch;
  const std::vector<Stroke>& drawn = artwork->shape.drawn.strokes;
  Asked widths, forces;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const Stroke& stroke = drawn[i];
    PlacedStroke& placed = artwork->strokes[i];
    const bool by_force = stroke.by_force && !stroke.press.empty();
    const std::size_t n = stroke.points.size();
    std::vector<double> force;
    for (std::size_t k = 0; k < n; ++k) {
      double asked = stroke.press.empty() ? stroke.width : stroke.press[k];
      if (!by_force) asked *= scale;
      if (!(asked > 0.0) && stroke.press.empty()) break;
      const double piece = 0.5 * ((k > 0 ? (placed.p_P[k] - placed.p_P[k - 1]).norm() : 0.0) +
                                  (k + 1 < n ? (placed.p_P[k + 1] - placed.p_P[k]).norm() : 0.0));
      if (by_force) {
        force.push_back(pen.within(asked));
        forces.add(asked, force.back(), piece);
      } else {
        force.push_back(pen.presses() ? pen.force_for(asked) : s.control.normal_force);
        widths.add(asked, pen.width_at(force.back()), piece);
      }
    }
    const bool same = std::ranges::all_of(
        force, [&](double f) { return std::abs(f - s.control.normal_force) < kSameForce; });
    if (follows && !same) placed.force = std::move(force);
  }
  if (!follows && (forces.length > 0.0 || (pen.presses() && widths.length > 0.0))) {
    artwork->notes.push_back(
        "widths and forces of lines are passed over: without perception the force is a spring's");
    return;
  }
  if (pen.presses() && widths.lighter + widths.heavier > 0.0)
    artwork->notes.push_back(told(widths, "lines", "mm", pen.width_at(pen.least_force),
                                  pen.width_at(pen.most_force)));
  if (!pen.presses() && widths.most > widths.least * (1.0 + kSameWidth))
    artwork->notes.push_back(fmt::format(
        "lines of {:.3g} to {:.3g} mm are drawn alike: this pen's width does not change with the "
        "force (pen.width_per_newton is 0)",
        widths.least, widths.most));
  if (forces.lighter + forces.heavier > 0.0)
    artwork->notes.push_back(told(forces, "forces", "N", pen.least_force, pen.most_force));
}

double hardest(const Scenario& scenario, const std::vector<PlacedStroke>& strokes) {
  double most = scenario.control.normal_force;
  for (const PlacedStroke& stroke : strokes)
    for (const double f : stroke.force) most = std::max(most, f);
  return most;
}

}  // namespace impedraw
