// Fills areas with pen strokes: parallel ones, or rings (hatch.h).
//
// The parallel lines lie at (k + 1/2) · spacing from the page's origin for integer k, so those of
// neighbouring areas meet. Each line is clipped by the area's outlines and fill rule (Clipper).
// Neighbouring lines are drawn in opposite directions. Cross-hatching adds a perpendicular set.
//
// An even tone of t has its lines 1/t times as far apart. One that varies has the lines of a full
// tone, each where the tone is above its threshold (hatch_rows.h).
//
// An area does not hide what was painted before it: overlapping areas each keep their lines. An
// area narrower than the spacing may get none.
//
// The spacing is the page's, which a wrapped page has on the surface, too. On a page that is
// projected it is measured on the surface (hatch.h): lines bend, and keep their distance.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/common/range.h"
#include "impedraw/drawing/hatch_rows.h"
#include "impedraw/drawing/regions.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

// Coordinates of one set of hatch lines: x_H along them, y_H across.
//
// Straight, y_H is the distance on the page. Bent, it is a field whose level lines lie evenly on
// the surface, so that lines of constant y_H do: sampled, linear between its samples, and made to
// rise across the lines, so that every point of the page has one place in H, and back.

// At a point of the page [mm], the distance from a line across the drawing, measured on the
// surface, in millimetres of the page. Of the direction on the page in which it is to rise.
using SurfaceDistance = std::function<double(const Eigen::Vector2d& page_mm)>;
using SurfaceDistances = std::function<SurfaceDistance(const Eigen::Vector2d& across)>;

class HatchFrame {
 public:
  // angle: of the lines [rad], counter-clockwise as seen. Bent over a box of the page by samples
  // `step` apart [mm], or straight without distances.
  HatchFrame(double angle, const SurfaceDistances& distances, const Eigen::AlignedBox2d& box,
             double step);

  Eigen::Vector2d to_H(const Eigen::Vector2d& page_mm) const;
  Eigen::Vector2d to_page(const Eigen::Vector2d& p_H) const;
  // In pieces that follow the bends. Straight ones keep their points.
  std::vector<Eigen::Vector2d> outline_to_H(std::vector<Eigen::Vector2d> page_mm) const;
  std::vector<Eigen::Vector2d> line_to_page(const std::vector<Eigen::Vector2d>& line_H) const;

 private:
  double sample(double x, std::size_t row) const;  // of the table, at x_H

  Eigen::Vector2d along_, across_;
  double step_ = 0.0;                              // [mm]; 0: straight
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero();  // of the table, along and across [mm]
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<double> table_;  // y_H [mm], column by column
};

// Hatch lines that run round: circles about the middle of an area's box (concentric), or insets of
// its outline, as slicers lay them (contour-parallel). Their distances from the middle or the
// outline are (k + 1/2) · spacing for rows k = 0, 1, 2, …
enum class HatchStyle { boustrophedon, concentric, contour_parallel };

// The lines over a region of the page that is free of overlaps [mm]; they may leave it.
using HatchRings = std::function<std::vector<HatchLine>(const Outlines& region, HatchStyle style,
                                                        double spacing_mm)>;

// Distances are those of the page.
std::vector<HatchLine> page_rings(const Outlines& region, HatchStyle style, double spacing_mm);

// The number of rows within `farthest`. InputError: more than 100,000.
double require_few_rows(double farthest, double spacing_mm);

struct HatchSettings {
  double spacing_mm = 0;  // between neighbouring lines of a full tone on the canvas; 0: no hatching
  HatchStyle style = HatchStyle::boustrophedon;
  double angle_deg = 45;  // from the page's X to the lines, counter-clockwise as seen
  bool cross = false;     // a second set, at right angles
  // draw the outlines of filled areas too (stroked outlines are always drawn)
  bool outline = true;

  struct Limits {
    static constexpr Limit spacing = {"spacing", "mm", {0.0, 1000.0}};
    static constexpr Limit angle = {"angle", "deg", {-360.0, 360.0}};
  };
};

// The spacing of lines on a surface; empty: as on the page.
struct HatchSurface {
  SurfaceDistances distances = {};
  HatchRings rings = {};
};

// Returns the area's lines at settings.spacing_mm / scale on the page, where `scale` is the
// placement's; none for a spacing of 0. InputError: spacing, scale or angle out of range, a second
// set of rings, or more than 100,000 lines across an area.
std::vector<Stroke> hatch_lines(const Area& area, const HatchSettings& settings, double scale,
                                const HatchSurface& surface = {});

// The same lines, joined where they can be drawn in one go (boustrophedon). A join stays within the
// area; the lines end half a pen before the outline.
std::vector<Stroke> hatch_strokes(const Area& area, const HatchSettings& settings, double scale);

// apply_hatch() puts each area's joined lines behind the other strokes of its layer, and drops the
// edges if settings.outline is false. drop_edges() only drops the edges. Both keep the areas.
void apply_hatch(Artwork& artwork, const HatchSettings& settings, double scale,
                 const HatchSurface& surface = {});
void drop_edges(Artwork& artwork);

}  // namespace impedraw
