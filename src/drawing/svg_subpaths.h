// The subpaths of an SVG document, and their curves as lines.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/drawing/hershey.h"
#include "impedraw/drawing/usvg/impedraw_usvg.h"

namespace impedraw {

// Flattens curves to polylines whose chords stay within a given distance of the curve.
//
// The distance of a curve P(s), 0 ≤ s ≤ 1, to its chord is at most max|P''| / 8. For a Bézier curve
// P'' is itself a Bézier curve, bounded by its largest control point. The adaptive subdivision thus
// guarantees the tolerance. A curve is also cut where a piece would turn by more than `turn`, so
// that small curves stay smooth and are not mistaken for polygons.
struct FlattenSettings {
  double tolerance = 0.01;  // largest distance between chord and curve [unit of the points]
  double turn = 0.15;       // largest turn within one piece [rad]
};

// Each appends the curve's points to `line`, without the first; the last point is exact.
void flatten_quadratic(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                       const FlattenSettings& settings, std::vector<Eigen::Vector2d>& line);
void flatten_cubic(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                   const Eigen::Vector2d& d, const FlattenSettings& settings,
                   std::vector<Eigen::Vector2d>& line);

// Part of an ellipse: centre + u cos φ + v sin φ for φ from 0 to `angle` > 0; u and v are conjugate
// half diameters.
struct EllipseArc {
  Eigen::Vector2d centre, u, v;
  double angle = 0;

  Eigen::Vector2d at(double phi) const { return centre + std::cos(phi) * u + std::sin(phi) * v; }
};
void flatten_arc(const EllipseArc& arc, const FlattenSettings& settings,
                 std::vector<Eigen::Vector2d>& line);

// The arc of at most a quarter turn that the cubic approximates in the customary way (handles of
// 4/3 tan(φ/4)). The angle is 0 if the cubic approximates no arc.
EllipseArc arc_of_cubic(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                        const Eigen::Vector2d& c, const Eigen::Vector2d& d);

struct SvgSegment {
  ImpedrawSvgVerb verb;
  Eigen::Vector2d p[3];
  const Eigen::Vector2d& end() const {
    return p[verb == IMPEDRAW_SVG_CUBIC ? 2 : verb == IMPEDRAW_SVG_QUAD ? 1 : 0];
  }
};

struct SvgSubpath {
  Eigen::Vector2d start;
  std::vector<SvgSegment> segments;
  bool closed = false;
  const ImpedrawSvgPath* path = nullptr;
};

// Throws InputError for a point that is too far away.
std::vector<SvgSubpath> svg_subpaths(const ImpedrawSvg& svg, const std::string& name);

// Box of what is painted.
Eigen::AlignedBox2d painted_box(const std::vector<SvgSubpath>& subpaths);

// Throws InputError if curves take more points than are drawn.
void require_few_points(std::size_t points, const FlattenSettings& settings,
                        const std::string& name);

// usvg converts circles, ellipses, rounded corners and arcs to cubics, which are off by up to
// 2.7e-4 of the radius. Two or more consecutive cubics on one ellipse are replaced by the arc that
// they approximate. A single one stays as it is: it may be a cubic of the author's own.
std::vector<Eigen::Vector2d> flatten(const SvgSubpath& subpath, const FlattenSettings& settings,
                                     const std::string& name);

// The text of an SVG in single pen strokes.
//
// Each letter of a font (hershey.h, letters.h) is drawn where the SVG's own font has it: as wide as
// that one's advance, and its capitals as high.
class SvgLetters {
 public:
  explicit SvgLetters(std::string font) : name_(std::move(font)) {}

  // The strokes of the letter whose place the subpath is [mm on the page]. InputError: the font is
  // not known.
  std::vector<std::vector<Eigen::Vector2d>> strokes_of(const SvgSubpath& place);
  // Names the letters that the font lacks; empty: none.
  std::string lacking() const;

 private:
  std::string name_;
  std::optional<HersheyFont> font_;  // read for the first letter
  std::u32string lacking_;
};

}  // namespace impedraw
