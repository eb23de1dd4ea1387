// The subpaths of an SVG document, and their curves as lines.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/drawing/flatten.h"
#include "impedraw/drawing/usvg/impedraw_usvg.h"

namespace impedraw {

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

}  // namespace impedraw
