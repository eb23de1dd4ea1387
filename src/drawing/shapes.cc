#include "impedraw/drawing/shapes.h"

#include <cmath>
#include <numbers>

#include <fmt/core.h>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
constexpr double kSpacing = 0.1;      // [mm]
constexpr double kHalfWidth = 150;    // of the sine [mm]
constexpr double kPeriod = 150;       // [mm]
constexpr double kAmplitude = 50;     // [mm]
constexpr double kCircleRadius = 60;  // [mm]

// The sine's point at world y [mm from the centre]; the page's X is −y and its Y is −(x − 600).
Vector2d sine_at(double y) {
  return {-y, -kAmplitude * std::sin(2 * std::numbers::pi * (y + kHalfWidth) / kPeriod)};
}

Artwork one_stroke(const std::string& name, std::vector<Vector2d> points, bool closed = false) {
  Artwork artwork;
  artwork.name = name;
  artwork.layers = {name};
  for (const Vector2d& p : points) artwork.page.extend(p);
  artwork.strokes.push_back({std::move(points), closed, 0});
  return artwork;
}

std::vector<Vector2d> subdivided(const std::vector<Vector2d>& corners) {
  std::vector<Vector2d> points{corners.front()};
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Vector2d side = corners[i] - corners[i - 1];
    const int pieces = static_cast<int>(std::ceil(side.norm() / kSpacing));
    for (int k = 1; k <= pieces; ++k)
      points.push_back(corners[i - 1] + side * (static_cast<double>(k) / pieces));
  }
  return points;
}

std::vector<Vector2d> smooth_sine() {
  const double steepest = std::hypot(1.0, kAmplitude * 2 * std::numbers::pi / kPeriod);
  const int pieces = static_cast<int>(std::ceil(2 * kHalfWidth * steepest / kSpacing));
  std::vector<Vector2d> points;
  for (int i = 0; i <= pieces; ++i)
    points.push_back(sine_at(-kHalfWidth + 2 * kHalfWidth * i / pieces));
  return points;
}

std::vector<Vector2d> whole_circle() {
  const int pieces = static_cast<int>(std::ceil(2 * std::numbers::pi * kCircleRadius / kSpacing));
  std::vector<Vector2d> points;
  for (int i = 0; i < pieces; ++i) {
    const double angle = 2 * std::numbers::pi * i / pieces;
    points.push_back(kCircleRadius * Vector2d(std::cos(angle), std::sin(angle)));
  }
  points.push_back(points.front());
  return points;
}

}  // namespace

std::vector<std::string> shape_names() { return {"M", "sine", "sine10", "circle"}; }

Shape make_shape(const std::string& name) {
  if (name == "sine") return {one_stroke(name, smooth_sine())};
  if (name == "sine10") {
    std::vector<Vector2d> set_points;
    for (int i = 0; i < 10; ++i) set_points.push_back(sine_at(-kHalfWidth + i * 100.0 / 3.0));
    return {one_stroke(name, set_points), one_stroke(name, smooth_sine())};
  }
  if (name == "circle") return {one_stroke(name, whole_circle(), true)};
  if (name == "M") {
    const std::vector<Vector2d> corners{{-80, 80}, {-80, -80}, {0, 0}, {80, -80}, {80, 80}};
    return {one_stroke(name, corners), one_stroke(name, subdivided(corners))};
  }
  std::string known;
  for (const std::string& n : shape_names()) known += (known.empty() ? "" : ", ") + n;
  throw InputError(fmt::format("shape \"{}\": not known; there are {}", name, known));
}

}  // namespace impedraw
