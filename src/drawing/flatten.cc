#include "impedraw/drawing/flatten.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "impedraw/common/cross.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
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

}  // namespace impedraw
