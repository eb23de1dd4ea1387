// The page laid on the surface like a sheet, so that lengths are kept as nearly as the surface lets
// them; along −z a slope stretches them by up to 1 / cos(slope). On a developable surface (plane,
// cylinder, cone) nothing is stretched; on any other something must be (Gauss).
//
// Flat coordinates [m] have the drawing plane's axes and origin: a stroke placed as ever
// (drawing/placement.h) is flat. The wrap takes flat points to the drawing plane, from where the
// planner projects them on the surface. At the centre a point stays where it is and directions keep
// those of the plane but for the tangent plane's tilt.
//
// The patch of the surface beneath the drawing's convex hull (the centre included) and a margin
// about it is laid flat as one piece, by a least-squares conformal map and then as rigid as
// possible, so that the stretch is shared out over that patch.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "impedraw/common/range.h"
#include "impedraw/drawing/placement.h"
#include "impedraw/planning/stroke_part.h"
#include "impedraw/planning/surface_height.h"
#include "impedraw/planning/wrap/flat_chart.h"

namespace impedraw {

struct WrapSettings {
  double spacing = 3e-3;  // of the grid in the drawing plane [m]
  // of the patch about the drawing's hull, in flat lengths [m], at least two spacings
  double margin = 0.02;
  // between a page line's image and the polyline that stands for it, in the drawing plane [m]
  double tolerance = 1e-5;
  std::filesystem::path
      python{};  // an interpreter with libigl; empty: the venv that impedraw was built with

  struct Limits {
    static constexpr Range spacing = {5e-4, 0.02};
    static constexpr Range margin = {0.001, 0.5};
    static constexpr Range tolerance = {1e-7, 1e-2};
  };
};

// Throws InputError: the setting, its value and what is allowed.
void validate(const WrapSettings& settings);

struct WrappedStrokes {
  std::vector<PlacedStroke>
      // world: in the drawing plane; a stroke that leaves the patch comes as several with the same
      // number,
      strokes;
  // `start` counting what is lost by its flat length
  std::vector<StrokePart> lost;  // what lies off the patch, measured along the flat strokes [m]
};

class Wrap {
 public:
  // `strokes` are flat. Asks the surface in about 1.5 points per node of the patch. InputError:
  // settings out of bounds, nothing to wrap, no surface above the centre, or the patch cannot be
  // laid flat (planning/flatten_patch.h).
  Wrap(const SurfaceHeight& surface, const Eigen::Vector2d& centre,
       const std::vector<PlacedStroke>& strokes, const WrapSettings& settings = {});

  // Nothing off the patch.
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
  std::shared_ptr<const FlatChart> chart_;
};

}  // namespace impedraw
