#include "impedraw/experiment/roughness_note.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {
namespace {

constexpr double kCalm = 6e-5;          // RMS residual [m]
constexpr double kLeastSpacing = 2e-3;  // of the places, at least [m]
constexpr double kMostPlaces = 500;

}  // namespace

std::optional<std::string> roughness_note(const std::vector<PlacedStroke>& strokes,
                                          const SurfaceHeight& surface, const Pose& X_WP,
                                          const SurfaceEstimator& seen) {
  double length = 0.0;
  for (const PlacedStroke& stroke : strokes) length += StrokeRuler(stroke).length();
  const double spacing = std::max(kLeastSpacing, length / kMostPlaces);
  double squares = 0.0, places = 0.0;
  SurfaceHeight::Sample last;
  for (const PlacedStroke& stroke : strokes) {
    const StrokeRuler ruler(stroke);
    for (double s = 0.0; s <= ruler.length(); s += spacing) {
      const Eigen::Vector2d p_P = ruler.at(stroke.start + s).p_P;
      const auto sample = surface(p_P.x(), p_P.y(), last);
      if (!sample) continue;
      const Roughness roughness = seen.roughness(X_WP * sample->p_P);
      squares += roughness.residual * roughness.residual;
      places += 1.0;
    }
  }
  const double rms = places > 0.0 ? std::sqrt(squares / places) : 0.0;
  if (rms < kCalm) return std::nullopt;
  return fmt::format(
      "the surface is rough under the line, {:.2g} mm RMS within patches that the pen follows: the "
      "force may scatter by more than ± 0.6 N; slower (path.draw_speed) is calmer",
      1e3 * rms);
}

}  // namespace impedraw
