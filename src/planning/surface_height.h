// The planner's view of the surface: a height field over the drawing plane, seen along −z. It may
// be the true canvas or a cloud.
#pragma once

#include <functional>
#include <optional>
#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include "impedraw/common/errors.h"

namespace impedraw {

struct SurfaceSample {
  Eigen::Vector3d p_P;                             // on the surface, at the queried x and y [m]
  Eigen::Vector3d n_P = Eigen::Vector3d::UnitZ();  // unit, outward
  // Cosine of the steepest slope known there: where n_P is smoothed and steep, that of the normal
  // that the pen will follow. No more than n_P.z() counts.
  double steepest = 1.0;
};

class SurfaceHeight {
 public:
  using Sample = std::optional<SurfaceSample>;

  SurfaceHeight() = default;
  // From ask(x, y), for one sheet, or ask(x, y, last).
  template <class Ask>
  SurfaceHeight(Ask ask) {
    if constexpr (std::is_invocable_v<Ask&, double, double>)
      ask_ = [ask = std::move(ask)](double x, double y, Sample&) mutable { return ask(x, y); };
    else
      ask_ = std::move(ask);
  }

  // Returns nullopt where there is no surface at (x, y) [m]; of several sheets the upper one.
  Sample operator()(double x, double y) const {
    Sample last;
    return ask_(x, y, last);
  }
  // For one who asks along a line, with the last answer: of several sheets the one that it lies
  // on, if it is near.
  Sample operator()(double x, double y, Sample& last) const { return ask_(x, y, last); }

 private:
  std::function<Sample(double x, double y, Sample& last)> ask_;
};

// Distance from p to the surface's edge, seen along z [m]. Searches on circles of radius up to
// `searched` [m]; nullopt if none meets the surface.
std::optional<double> distance_off(const SurfaceHeight& surface, const Eigen::Vector2d& p,
                                   double searched = 0.5);

// Thrown for a stroke point without surface.
class OffSurface : public InputError {
 public:
  OffSurface(const std::string& what, int number, const Eigen::Vector2d& at)
      : InputError(what), stroke(number), p(at) {}
  // Along the stroke, to either side of such a point: left out with it [m].
  static constexpr double kAbout = 3e-3;
  int stroke;         // PlacedStroke::number
  Eigen::Vector2d p;  // in the drawing plane [m]
};

// Returns the sample above p. Throws OffSurface if there is none. The error names the stroke
// (counted from 0), the point on the page [mm] and in the world [m], and its distance from the
// surface, searched up to 0.5 m.
SurfaceSample sample_or_throw(const SurfaceHeight& surface, const Eigen::Vector2d& p,
                              const Eigen::Vector2d& page_mm, int stroke,
                              SurfaceHeight::Sample& last);

}  // namespace impedraw
