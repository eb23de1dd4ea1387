// The surface as the planner sees it: what stands above a point of the drawing plane, looking along
// −z. It may be the true canvas or a cloud.
#pragma once

#include <functional>
#include <optional>

#include <Eigen/Core>

#include "impedraw/common/errors.h"

namespace impedraw {

struct SurfaceSample {
  Eigen::Vector3d p_P;                             // on the surface, at the x and y asked for [m]
  Eigen::Vector3d n_P = Eigen::Vector3d::UnitZ();  // unit, outward
};

// Nothing where there is no surface at (x, y) [m].
using SurfaceHeight = std::function<std::optional<SurfaceSample>(double x, double y)>;

// From p to where the surface begins, seen along z [m]: searched for in circles of up to
// `searched`, nothing if none meets it.
std::optional<double> distance_off(const SurfaceHeight& surface, const Eigen::Vector2d& p,
                                   double searched = 0.5);

// A point of a stroke that has no surface.
class OffSurface : public InputError {
 public:
  OffSurface(const std::string& what, int number, const Eigen::Vector2d& at)
      : InputError(what), stroke(number), p(at) {}
  int stroke;         // PlacedStroke::number
  Eigen::Vector2d p;  // in the drawing plane [m]
};

// The sample above p. OffSurface if there is none: names the stroke (counted from 0), the point on
// the page [mm] and in the world [m], and how far from the surface it is, which is searched for in
// circles of up to 0.5 m.
SurfaceSample sample_or_throw(const SurfaceHeight& surface, const Eigen::Vector2d& p,
                              const Eigen::Vector2d& page_mm, int stroke);

}  // namespace impedraw
