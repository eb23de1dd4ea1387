// Lays the page on the surface like a sheet and preserves lengths as far as the surface permits.
// Projection along −z stretches lengths by up to 1 / cos(slope) instead. A developable surface
// (plane, cylinder, cone) needs no stretch. Any other surface does (Gauss).
//
// Flat coordinates [m] have the drawing plane's axes and origin. Placed strokes
// (drawing/placement.h) are flat. The wrap maps flat points to the drawing plane, from which the
// planner projects them onto the surface. The centre is a fixed point. Directions there are those
// of the plane, up to the tilt of the tangent plane.
//
// The patch below the drawing's convex hull (including the centre) and a margin around it is
// flattened as one piece: least-squares conformal map, then as-rigid-as-possible. The stretch is
// thereby distributed over that patch, and another patch of the same surface gives another map:
// on a hill of 68° half a drawing, alone, lies 1.4 to 2.6 mm RMS elsewhere.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "impedraw/drawing/placement.h"
#include "impedraw/planning/stroke_part.h"
#include "impedraw/planning/surface_height.h"
#include "impedraw/planning/wrap/flat_chart.h"

namespace impedraw {

struct WrapSettings {
  double spacing = 3e-3;  // grid spacing in the drawing plane [m]
  // margin of the patch around the drawing's hull, in flat lengths [m], at least two spacings
  double margin = 0.02;
  // distance between a page line's image and its polyline, in the drawing plane [m]
  double tolerance = 1e-5;
  // an interpreter with libigl; empty: the venv that impedraw was built with
  std::filesystem::path python{};
};

// Throws InputError naming the setting, its value and the allowed range.
void validate(const WrapSettings& settings);

struct WrappedStrokes {
  // In the drawing plane. A stroke that leaves the patch is split into several with the same
  // number; `start` is the place along the flat stroke.
  std::vector<PlacedStroke> strokes;
  std::vector<StrokePart> lost;  // the parts off the patch, measured along the flat strokes [m]
};

class Wrap {
 public:
  // `strokes` are flat. Queries the surface at about 1.5 points per node of the patch. Throws
  // InputError if a setting is out of range, there is nothing to wrap, there is no surface above
  // the centre, or over 5 % of the patch folds over when it is flattened. Less is left out.
  Wrap(const SurfaceHeight& surface, const Eigen::Vector2d& centre,
       const std::vector<PlacedStroke>& strokes, const WrapSettings& settings = {});

  // The same cells laid on another surface, `with` its heights. Where it has none, the height
  // stays. Throws InputError if over 5 % of them fold over there.
  Wrap laid_on(const SurfaceHeight& with) const;

  // Both return nullopt off the patch.
  std::optional<Eigen::Vector2d> to_plane(const Eigen::Vector2d& flat) const {
    return chart_->to_plane(flat);
  }
  std::optional<Eigen::Vector2d> to_flat(const Eigen::Vector2d& plane) const {
    return chart_->to_flat(plane);
  }
  const FlatChart& chart() const { return *chart_; }

  WrappedStrokes wrap(const std::vector<PlacedStroke>& strokes) const;

 private:
  WrapSettings settings_;
  Eigen::Vector2d centre_;
  std::shared_ptr<const FlatChart> chart_;
};

}  // namespace impedraw
