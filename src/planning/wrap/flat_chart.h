// The smooth map between the drawing plane and the page laid flat on the surface.
//
// Known at the nodes of a patch, it is interpolated by bicubics whose slopes are central
// differences (Catmull-Rom): continuous with its first derivatives, error of third order in the
// spacing. The way back is Newton's method on that interpolant, from the flat triangle in which the
// point lies, so that both directions agree to rounding.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "impedraw/planning/wrap/surface_patch.h"

namespace impedraw {

class FlatChart {
 public:
  // `flat` of the patch's vertices [m]. It is turned and shifted: `centre` (a node of the patch)
  // stays where it is, and there the map's differential is symmetric, that is a tilt of the plane
  // without a turn.
  FlatChart(SurfacePatch patch, std::vector<Eigen::Vector2d> flat, const Eigen::Vector2d& centre);

  // Nothing where no cell of the patch lies. With `beyond`, also up to two spacings beyond the
  // patch's edge, by the nearest cell's bicubic.
  std::optional<Eigen::Vector2d> to_flat(const Eigen::Vector2d& plane, bool beyond = false) const;
  // Nothing where no triangle of the flat patch lies. Where the patch overlaps itself, the first
  // triangle's.
  std::optional<Eigen::Vector2d> to_plane(const Eigen::Vector2d& flat) const;
  // d flat / d plane, 2×2; held at the patch's edge beyond it.
  Eigen::Matrix2d differential(const Eigen::Vector2d& plane) const;

  const SurfacePatch& patch() const { return patch_; }

 private:
  struct Place {
    int cell = -1;
    Eigen::Vector2d share;  // within the cell, 0 … 1 unless beyond it
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
  std::vector<Eigen::Vector2d>
      node_;  // (columns + 2)(rows + 2): a ring about the patch's grid; NaN far from the patch
  Eigen::Vector2d low_;  // of the flat vertices' box
  int bucket_columns_ = 0, bucket_rows_ = 0;
  std::vector<std::vector<int>> buckets_;  // triangles whose box meets the bucket
};

}  // namespace impedraw
