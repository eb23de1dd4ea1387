#include "impedraw/planning/wrap/distortion.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace impedraw {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
constexpr double kChord = 5e-4;  // [m]

Matrix2d metric(const SurfaceSample& sample) {
  const Vector2d slope = -sample.n_P.head<2>() / sample.n_P.z();
  return Matrix2d::Identity() + slope * slope.transpose();
}

LocalStretch stretch_of(const SurfaceSample& sample, const Matrix2d& J) {
  const Matrix2d to_plane = J.inverse();
  const Vector2d squares =
      Eigen::SelfAdjointEigenSolver<Matrix2d>(to_plane.transpose() * metric(sample) * to_plane)
          .eigenvalues();
  return {std::sqrt(squares.y()), std::sqrt(squares.x())};
}

// Accumulates the extremes and weighted squares of one Distortion.
class Gathering {
 public:
  void lengths(double stretch, double weight) {
    if (weight_ == 0) result_.stretch_min = result_.stretch_max = stretch;
    result_.stretch_min = std::min(result_.stretch_min, stretch);
    result_.stretch_max = std::max(result_.stretch_max, stretch);
    squares_ += weight * (stretch - 1) * (stretch - 1);
    weight_ += weight;
  }
  void shapes(const LocalStretch& s) {
    if (!shaped_) result_.area_min = result_.area_max = s.area();
    shaped_ = true;
    result_.area_min = std::min(result_.area_min, s.area());
    result_.area_max = std::max(result_.area_max, s.area());
    result_.angle_max = std::max(result_.angle_max, s.angle());
  }
  Distortion result() const {
    Distortion d = result_;
    if (weight_ > 0) d.stretch_rms = std::sqrt(squares_ / weight_);
    return d;
  }
  double weight() const { return weight_; }

 private:
  Distortion result_;
  double squares_ = 0, weight_ = 0;
  bool shaped_ = false;
};

using Onto = std::function<std::optional<SurfaceSample>(const Vector2d& flat)>;

Distortion over_strokes(const std::vector<PlacedStroke>& strokes, const Onto& onto,
                        const std::function<LocalStretch(const SurfaceSample&)>& stretch) {
  Gathering gathering;
  for (const PlacedStroke& stroke : strokes) {
    for (std::size_t from = 0, k = 1; k < stroke.p_P.size(); from = k++) {
      while (k + 1 < stroke.p_P.size() && (stroke.p_P[k + 1] - stroke.p_P[from]).norm() <= kChord)
        ++k;
      const Vector2d& start = stroke.p_P[from];
      const Vector2d along = stroke.p_P[k] - start;
      const int chords = std::max(1, static_cast<int>(std::ceil(along.norm() / kChord)));
      const double length = along.norm() / chords;
      if (length == 0) continue;
      std::optional<SurfaceSample> last = onto(start);
      for (int i = 1; i <= chords; ++i) {
        const std::optional<SurfaceSample> next = onto(start + along * i / chords);
        if (last && next) {
          gathering.lengths((next->p_P - last->p_P).norm() / length, length);
          if (const auto middle = onto(start + along * (i - 0.5) / chords))
            gathering.shapes(stretch(*middle));
        }
        last = next;
      }
    }
  }
  Distortion result = gathering.result();
  result.page_length = gathering.weight();
  return result;
}

}  // namespace

double LocalStretch::angle() const {
  return 2 * std::asin((largest - smallest) / (largest + smallest));
}
double LocalStretch::length_error() const {
  return std::max(std::abs(largest - 1), std::abs(smallest - 1));
}

LocalStretch stretch_of_projection(const SurfaceSample& sample) {
  return stretch_of(sample, Matrix2d::Identity());
}
LocalStretch stretch_of_wrap(const SurfaceSample& sample, const FlatChart& chart) {
  return stretch_of(sample, chart.differential(sample.p_P.head<2>()));
}

Distortion distortion_of_projection(const std::vector<PlacedStroke>& strokes,
                                    const SurfaceHeight& surface) {
  return over_strokes(
      strokes,
      [&, last = SurfaceHeight::Sample()](const Vector2d& p) mutable {
        return surface(p.x(), p.y(), last);
      },
      stretch_of_projection);
}

Distortion distortion_of_wrap(const std::vector<PlacedStroke>& strokes,
                              const SurfaceHeight& surface, const FlatChart& chart) {
  return over_strokes(
      strokes,
      [&, last = SurfaceHeight::Sample()](const Vector2d& flat) mutable -> SurfaceHeight::Sample {
        const std::optional<Vector2d> plane = chart.to_plane(flat);
        return plane ? surface(plane->x(), plane->y(), last) : std::nullopt;
      },
      [&](const SurfaceSample& sample) { return stretch_of_wrap(sample, chart); });
}

}  // namespace impedraw
