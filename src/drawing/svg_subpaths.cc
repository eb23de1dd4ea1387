#include "impedraw/drawing/svg_subpaths.h"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

using Eigen::Vector2d;

namespace {

// tolerance for two pieces of one arc to share an ellipse, relative to its size
constexpr double kSameArc = 1e-5;

// True if `next` continues along the ellipse of `arc`.
bool continues(const EllipseArc& arc, const EllipseArc& next) {
  if (next.angle == 0) return false;
  const double size = std::max(arc.u.norm(), arc.v.norm());
  const Vector2d u = std::cos(arc.angle) * arc.u + std::sin(arc.angle) * arc.v;
  const Vector2d v = -std::sin(arc.angle) * arc.u + std::cos(arc.angle) * arc.v;
  return (arc.centre - next.centre).norm() + (u - next.u).norm() + (v - next.v).norm() <
             30 * kSameArc * size &&
         std::abs(arc.angle - next.angle) < 100 * kSameArc;
}

}  // namespace

std::vector<SvgSubpath> svg_subpaths(const ImpedrawSvg& svg, const std::string& name) {
  std::vector<SvgSubpath> all;
  const std::uint8_t* verb = svg.verbs;
  const double* xy = svg.points;
  const auto point = [&]() {
    const Vector2d p(xy[0], xy[1]);
    if (!(p.cwiseAbs().maxCoeff() <= kFarthest)) {
      throw InputError(fmt::format("{}: a point at ({:.3g}, {:.3g}) mm lies beyond ± {:.0e} mm",
                                   name, p.x(), p.y(), kFarthest));
    }
    xy += 2;
    return p;
  };
  for (std::size_t i = 0; i < svg.path_count; ++i) {
    bool open = false;
    for (const std::uint8_t* end = verb + svg.paths[i].verbs; verb != end; ++verb) {
      const auto v = static_cast<ImpedrawSvgVerb>(*verb);
      if (v == IMPEDRAW_SVG_MOVE || !open) {
        // After a close, drawing continues from the start of that subpath.
        const Vector2d start = v == IMPEDRAW_SVG_MOVE ? point() : all.back().start;
        all.push_back({start, {}, false, &svg.paths[i]});
        open = true;
        if (v == IMPEDRAW_SVG_MOVE) continue;
      }
      if (v == IMPEDRAW_SVG_CLOSE) {
        all.back().closed = true;
        open = false;
        continue;
      }
      SvgSegment segment{v, {}};
      for (int k = 0; k < v; ++k) segment.p[k] = point();  // line 1, quadratic 2, cubic 3 points
      all.back().segments.push_back(segment);
    }
  }
  return all;
}

Eigen::AlignedBox2d painted_box(const std::vector<SvgSubpath>& subpaths) {
  Eigen::AlignedBox2d box;
  for (const SvgSubpath& s : subpaths) {
    if (s.path->shapes > 0) continue;
    box.extend(s.start);
    for (const SvgSegment& segment : s.segments) box.extend(segment.end());
  }
  return box;
}

void require_few_points(std::size_t points, const FlattenSettings& settings,
                        const std::string& name) {
  if (points <= kMostPoints) return;
  throw InputError(
      fmt::format("{}: its curves take more than {} points at a tolerance of {:.2g} mm", name,
                  kMostPoints, settings.tolerance));
}

std::vector<Vector2d> flatten(const SvgSubpath& subpath, const FlattenSettings& settings,
                              const std::string& name) {
  std::vector<Vector2d> line{subpath.start};
  const auto& segments = subpath.segments;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    require_few_points(line.size(), settings, name);
    const SvgSegment& s = segments[i];
    const Vector2d from = i == 0 ? subpath.start : segments[i - 1].end();
    if (s.verb == IMPEDRAW_SVG_LINE) line.push_back(s.p[0]);
    if (s.verb == IMPEDRAW_SVG_QUAD) flatten_quadratic(from, s.p[0], s.p[1], settings, line);
    if (s.verb != IMPEDRAW_SVG_CUBIC) continue;
    const auto arc_at = [&](std::size_t k) {
      const Vector2d a = k == 0 ? subpath.start : segments[k - 1].end();
      return segments[k].verb == IMPEDRAW_SVG_CUBIC
                 ? arc_of_cubic(a, segments[k].p[0], segments[k].p[1], segments[k].p[2])
                 : EllipseArc{};
    };
    std::size_t last = i;
    for (EllipseArc arc = arc_at(i); arc.angle > 0 && last + 1 < segments.size(); ++last) {
      const EllipseArc next = arc_at(last + 1);
      if (!continues(arc, next)) break;
      arc = next;
    }
    if (last == i) {
      flatten_cubic(from, s.p[0], s.p[1], s.p[2], settings, line);
      continue;
    }
    for (; i <= last; ++i) {
      flatten_arc(arc_at(i), settings, line);
      line.back() = segments[i].end();
    }
    --i;
  }
  return line;
}

}  // namespace impedraw
