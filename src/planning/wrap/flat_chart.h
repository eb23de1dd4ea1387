// The smooth map between the drawing plane and the page laid flat on the surface.
//
// The map is known at the nodes of a patch. Bicubics with central-difference slopes (Catmull-Rom)
// interpolate it. The interpolant is C¹, and its error is of third order in the spacing. The
// inverse applies Newton's method to the interpolant, starting in the flat triangle that contains
// the point. Both directions therefore agree to rounding.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "impedraw/planning/wrap/surface_patch.h"

namespace impedraw {

class FlatChart {
 public:
  // `flat`: flat positions of the patch's vertices [m]. They are rotated and shifted so that
  // `centre` (a node of the patch) stays fixed and the map's differential is symmetric there: a
  // tilt of the plane without rotation.
  FlatChart(SurfacePatch patch, std::vector<Eigen::Vector2d> flat, const Eigen::Vector2d& centre);

  // Returns nullopt outside the patch's cells. `beyond` extends the map up to two spacings past the
  // patch's edge, by the nearest cell's bicubic.
  std::optional<Eigen::Vector2d> to_flat(const Eigen::Vector2d& plane, bool beyond = false) const;
  // Returns nullopt outside the flat patch. Where the flat patch overlaps itself, the first
  // triangle is used.
  std::optional<Eigen::Vector2d> to_plane(const Eigen::Vector2d& flat) const;
  // d flat / d plane, 2×2. Beyond the patch's edge it keeps its value at the edge.
  Eigen::Matrix2d differential(const Eigen::Vector2d& plane) const;

  const SurfacePatch& patch() const { return patch_; }

 private:
  struct Place {
    int cell = -1;
    Eigen::Vector2d share;  // position within the cell, 0 … 1 unless beyond it
  };
  struct Value {
    Eigen::Vector2d flat;
    Eigen::Matrix2d differential;
  };

  void fill_nodes(const std::vector<Eigen::Vector2d>& flat);
  void fill_buckets();
  Place place(const Eigen::Vector2d& plane, int beyond) const;
  Value value(const Place& place) const;
  int bucket(const Eigen::Vector2d& flat) const;

  SurfacePatch patch_;
  std::vector<Eigen::Vector2d> flat_;  // of the vertices
  // (columns + 2)(rows + 2): the patch's grid with a ring around it; NaN far from the patch
  std::vector<Eigen::Vector2d> node_;
  Eigen::Vector2d low_;  // lower corner of the flat vertices' bounding box
  int bucket_columns_ = 0, bucket_rows_ = 0;
  std::vector<std::vector<int>> buckets_;  // triangles whose bounding box meets the bucket
};

}  // namespace impedraw
