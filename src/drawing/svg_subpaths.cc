#include "impedraw/drawing/svg_subpaths.h"

#include <algorithm>
#include <numbers>

#include <fmt/core.h>

#include "impedraw/common/cross.h"
#include "impedraw/common/errors.h"
#include "impedraw/drawing/letters.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

using Eigen::Vector2d;
constexpr std::size_t kMostNamed = 8;  // letters in one warning

std::vector<std::vector<Vector2d>> SvgLetters::strokes_of(const SvgSubpath& place) {
  if (!font_) font_ = read_hershey_font(name_);
  const char32_t letter = place.path->letter[0], mark = place.path->letter[1];
  const auto glyph = glyph_of(*font_, letter, std::u32string(mark > 0 ? 1 : 0, mark));
  if (!glyph) {
    if (lacking_.find(letter) == std::u32string::npos) lacking_ += letter;
    return {};
  }
  const Vector2d origin = place.start, along = place.segments[0].end() - origin,
                 up = place.segments[1].end() - origin;
  std::vector<std::vector<Vector2d>> strokes = glyph->strokes;
  for (std::vector<Vector2d>& stroke : strokes) {
    for (Vector2d& p : stroke)
      p = origin + (p.x() - glyph->left) / (glyph->right - glyph->left) * along +
          (kBaseline - p.y()) / kCapHeight * up;
  }
  return strokes;
}

std::string SvgLetters::lacking() const {
  if (lacking_.empty()) return {};
  std::string named;
  for (const char32_t c : lacking_.substr(0, kMostNamed)) named += " '" + encoded_utf8(c) + "'";
  if (lacking_.size() > kMostNamed)
    named += fmt::format(" and {} more", lacking_.size() - kMostNamed);
  return fmt::format("the font {} has no{}: left out; drawing.text.as=outline draws them", name_,
                     named);
}

namespace {

// 2^24 pieces; only cusps reach it, with pieces far below any tolerance
constexpr int kDeepest = 24;
constexpr double kMostTurn = 1.57;  // of one piece [rad]

// True if the turns from a to b and from b to c make an angle of at most this tangent, below a
// quarter turn.
bool turns_little(const Vector2d& a, const Vector2d& b, const Vector2d& c, double tangent) {
  double x1 = a.dot(b), x2 = b.dot(c);
  const double y1 = std::abs(cross(a, b)), y2 = std::abs(cross(b, c));
  if (x1 == 0 && y1 == 0) x1 = 1;
  if (x2 == 0 && y2 == 0) x2 = 1;
  // Angles add as those of complex numbers do.
  return x1 >= 0 && x2 >= 0 && x1 * y2 + x2 * y1 <= tangent * (x1 * x2 - y1 * y2);
}

bool is_flat(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d,
             double tolerance, double tangent) {
  const double second = 6.0 * std::max((a - 2 * b + c).norm(), (b - 2 * c + d).norm());
  if (second > 8.0 * tolerance) return false;
  const double size = std::max({(b - a).norm(), (c - a).norm(), (d - a).norm()});
  if (size < 0.1 * tolerance) return true;
  // The turn of the control polygon bounds that of the curve.
  return turns_little(b - a, c - b, d - c, tangent);
}

void cut_cubic(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d,
               double tolerance, double tangent, int depth, std::vector<Vector2d>& line) {
  if (depth == kDeepest || is_flat(a, b, c, d, tolerance, tangent)) {
    line.push_back(d);
    return;
  }
  const Vector2d ab = (a + b) / 2, bc = (b + c) / 2, cd = (c + d) / 2;
  const Vector2d abc = (ab + bc) / 2, bcd = (bc + cd) / 2, middle = (abc + bcd) / 2;
  cut_cubic(a, ab, abc, middle, tolerance, tangent, depth + 1, line);
  cut_cubic(middle, bcd, cd, d, tolerance, tangent, depth + 1, line);
}

}  // namespace

void flatten_quadratic(const Vector2d& a, const Vector2d& b, const Vector2d& c,
                       const FlattenSettings& settings, std::vector<Vector2d>& line) {
  flatten_cubic(a, (a + 2 * b) / 3, (2 * b + c) / 3, c, settings, line);
}

void flatten_cubic(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d,
                   const FlattenSettings& settings, std::vector<Vector2d>& line) {
  cut_cubic(a, b, c, d, settings.tolerance, std::tan(std::min(settings.turn, kMostTurn)), 0, line);
}

void flatten_arc(const EllipseArc& arc, const FlattenSettings& settings,
                 std::vector<Vector2d>& line) {
  // |P''| is at most the ellipse's major half axis, the larger singular value of [u v].
  const double sum = arc.u.squaredNorm() + arc.v.squaredNorm();
  const double area = cross(arc.u, arc.v);
  const double major = std::sqrt((sum + std::sqrt(std::max(0.0, sum * sum - 4 * area * area))) / 2);
  if (!(major > 0)) return;
  const double minor = std::abs(area) / major;
  // The tangent turns by at most major/minor per radian of φ. Very flat ellipses are cut by
  // distance alone.
  const double by_turn = settings.turn * std::max(minor / major, 0.02);
  const double step = std::min(std::sqrt(8 * settings.tolerance / major), by_turn);
  const int pieces = std::max(1, static_cast<int>(std::ceil(arc.angle / step - 1e-9)));
  for (int i = 1; i <= pieces; ++i) line.push_back(arc.at(arc.angle * i / pieces));
}

EllipseArc arc_of_cubic(const Vector2d& a, const Vector2d& b, const Vector2d& c,
                        const Vector2d& d) {
  // With a = centre + u: b = a + k v, c = d − k v_end, k = 4/3 tan(φ/4). Then d − a = λ (b − a + d
  // − c), λ = tan(φ/2) / k = 1.5 / (1 − tan²(φ/4)).
  EllipseArc arc;
  const Vector2d start = b - a, end = d - c, chord = d - a, sum = start + end;
  const double size = chord.norm();
  if (!(sum.norm() > 0) || !(size > 0)) return arc;
  const double lambda = chord.dot(sum) / sum.squaredNorm();
  if ((chord - lambda * sum).norm() > 2e-6 * size) return arc;
  if (!(lambda > 1.5)) return arc;
  const double tangent = std::sqrt(1 - 1.5 / lambda);  // tan(φ/4)
  const double phi = 4 * std::atan(tangent);
  if (phi < 0.05 || phi > std::numbers::pi / 2 + 1e-3)
    return arc;  // below, the cubic is exact to 1e-12
  const double k = 4.0 / 3.0 * tangent;
  arc.v = start / k;
  arc.u = (std::cos(phi) * start - end) / (k * std::sin(phi));
  arc.centre = a - arc.u;
  arc.angle = phi;
  return arc;
}

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
