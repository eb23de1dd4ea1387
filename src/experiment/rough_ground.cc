#include "impedraw/experiment/rough_ground.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include <fmt/format.h>

#include "impedraw/common/in_parallel.h"
#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {

// In flat noise finer patches are in use, at most, in places.
bool is_rough(const Belief& belief, const Plan& plan) {
  constexpr double kOther = 0.02, kLeast = 0.1, kSpacing = 2e-3;  // [rad], [1], [m]
  if (!belief.perception) return false;
  const Pose& X_WP = plan.path_settings.X_WP;
  std::atomic<long> places = 0, other = 0;
  in_parallel(static_cast<int>(plan.strokes.size()), [&](int number) {
    const PlacedStroke& stroke = plan.strokes[static_cast<std::size_t>(number)];
    SurfaceHeight::Sample last;
    for (std::size_t i = 0; i < stroke.p_P.size(); ++i) {
      const Eigen::Vector2d to = stroke.p_P[i], from = i > 0 ? stroke.p_P[i - 1] : to;
      const int pieces = std::max(1, static_cast<int>(std::ceil((to - from).norm() / kSpacing)));
      for (int k = 1; k <= pieces; ++k) {
        const Eigen::Vector2d at = from + (to - from) * k / pieces;
        const auto sample = belief.surface(at.x(), at.y(), last);
        if (!sample) continue;
        const SurfaceEstimate there = belief.perception->estimate(X_WP * sample->p_P);
        ++places;
        other += there.status == SurfaceStatus::ok &&
                 there.n_W.cross(X_WP.R * sample->n_P).norm() > kOther;
      }
    }
  });
  return static_cast<double>(other) > kLeast * static_cast<double>(places);
}

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
