#include "impedraw/planning/path/path_spline.h"

#include <algorithm>
#include <cassert>

namespace impedraw {

using Eigen::Vector3d;

PathSpline::PathSpline(const std::vector<SurfaceSample>& knots, const std::vector<double>& along) {
  assert(knots.size() >= 2 && (along.empty() || along.size() == knots.size()));
  const std::size_t n = knots.size();
  knots_.resize(n);
  double u = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0) u += (knots[i].p_P - knots[i - 1].p_P).norm();
    knots_[i] = {u,
                 knots[i].p_P,
                 knots[i].n_P,
                 Vector3d::Zero(),
                 Vector3d::Zero(),
                 along.empty() ? u : along[i]};
  }
  if (n < 3) return;

  // Second derivatives M: h₀ M₀ + 2 (h₀ + h₁) M₁ + h₁ M₂ = 6 (slope₁ − slope₀) at each inner knot,
  // with M₀ = M₁ and Mₙ = Mₙ₋₁ at the ends.
  std::vector<double> diagonal(n), upper(n);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const Knot &a = knots_[i - 1], &c = knots_[i + 1];
    Knot& b = knots_[i];
    const double h0 = b.u - a.u, h1 = c.u - b.u;
    double d = 2 * (h0 + h1);
    Vector3d rp = 6 * ((c.p - b.p) / h1 - (b.p - a.p) / h0),
             rm = 6 * ((c.m - b.m) / h1 - (b.m - a.m) / h0);
    if (i == 1) {
      d += h0;
    } else {
      const double factor = h0 / diagonal[i - 1];
      d -= factor * upper[i - 1];
      rp -= factor * a.p2;
      rm -= factor * a.m2;
    }
    if (i + 2 == n) d += h1;
    diagonal[i] = d;
    upper[i] = h1;
    b.p2 = rp;
    b.m2 = rm;
  }
  for (std::size_t i = n - 2; i >= 1; --i) {
    Knot& b = knots_[i];
    if (i + 2 < n) {
      b.p2 -= upper[i] * knots_[i + 1].p2;
      b.m2 -= upper[i] * knots_[i + 1].m2;
    }
    b.p2 /= diagonal[i];
    b.m2 /= diagonal[i];
  }
  knots_[0].p2 = knots_[1].p2;
  knots_[0].m2 = knots_[1].m2;
  knots_[n - 1].p2 = knots_[n - 2].p2;
  knots_[n - 1].m2 = knots_[n - 2].m2;
}

Vector3d PathSpline::point(std::size_t span, double u) const noexcept {
  const Knot &k = knots_[span], &l = knots_[span + 1];
  const double h = l.u - k.u, b = (u - k.u) / h, a = 1 - b;
  return a * k.p + b * l.p + h * h / 6 * ((a * a * a - a) * k.p2 + (b * b * b - b) * l.p2);
}

SplinePoint PathSpline::raw(std::size_t span, double u) const noexcept {
  const Knot &k = knots_[span], &l = knots_[span + 1];
  const double h = l.u - k.u, b = (u - k.u) / h, a = 1 - b;
  const double pa = h * h / 6 * (a * a * a - a), pb = h * h / 6 * (b * b * b - b);
  const double da = h / 6 * (1 - 3 * a * a), db = h / 6 * (3 * b * b - 1);
  return {a * k.p + b * l.p + pa * k.p2 + pb * l.p2,
          (l.p - k.p) / h + da * k.p2 + db * l.p2,
          a * k.p2 + b * l.p2,
          a * k.m + b * l.m + pa * k.m2 + pb * l.m2,
          (l.m - k.m) / h + da * k.m2 + db * l.m2,
          a * k.m2 + b * l.m2,
          (l.along - k.along) / h,
          a * k.along + b * l.along};
}

SplinePoint PathSpline::at(double u) const noexcept {
  u = std::clamp(u, 0.0, length());
  const auto after = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, u,
                                      [](double value, const Knot& k) { return value < k.u; });
  SplinePoint s = raw(static_cast<std::size_t>(after - knots_.begin()) - 1, u);
  normalise(&s);
  return s;
}

// Derivatives of n = m/|m|: remove the component along n from each derivative of m.
void PathSpline::normalise(SplinePoint* s) noexcept {
  const double size = s->n.norm();
  const Vector3d n = s->n / size, m1 = s->dn / size, m2 = s->ddn / size;
  const double along = n.dot(m1);
  s->n = n;
  s->dn = m1 - along * n;
  s->ddn = m2 - n.dot(m2) * n - 2 * along * s->dn - s->dn.squaredNorm() * n;
}

double PathSpline::arc_length() const {
  double sum = 0;
  for (std::size_t i = 0; i < spans(); ++i) {
    const double middle = (start(i) + end(i)) / 2, half = (end(i) - start(i)) / 2,
                 x = half * 0.7745966692414834;  // Gauss, three points
    sum += half / 9 *
           (5 * raw(i, middle - x).dp.norm() + 8 * raw(i, middle).dp.norm() +
            5 * raw(i, middle + x).dp.norm());
  }
  return sum;
}

PathSpline::Bounds PathSpline::bounds(std::size_t span) const {
  Bounds b{0, std::max(knots_[span].p2.norm(), knots_[span + 1].p2.norm()), 0, 0, 0, 0};
  for (int i = 0; i <= 4; ++i) {
    SplinePoint s = raw(span, start(span) + (end(span) - start(span)) * i / 4);
    normalise(&s);
    b.slope = std::max(b.slope, s.dp.norm());
    b.stretch = std::max(b.stretch, std::abs(s.dp.dot(s.ddp)));
    b.rise = std::max(b.rise, std::abs(s.n.dot(s.ddp)));
    b.turn = std::max(b.turn, s.dn.norm());
    b.turn_bend = std::max(b.turn_bend, s.n.cross(s.ddn).norm());
  }
  return b;
}

}  // namespace impedraw
