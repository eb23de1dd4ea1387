// The wrap against surfaces whose flat maps are known: plane, cylinder and cone unroll exactly, the
// bowl by a one-dimensional minimum.
#include "impedraw/planning/wrap/wrap.h"

#include <functional>
#include <numbers>
#include <random>

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <Eigen/Dense>

#include "wrap_surfaces.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using surfaces::circle;
using surfaces::height_field;
using Flat = std::function<Vector2d(const Vector2d& flat)>;  // flat → drawing plane, exact

const Vector2d kCentre(0.60, 0.05);

// Of the polyline's image on the surface, sampled finely.
double surface_length(const SurfaceHeight& surface, const PlacedStroke& stroke) {
  double length = 0;
  for (std::size_t k = 1; k < stroke.p_P.size(); ++k) {
    Vector3d last = surface(stroke.p_P[k - 1].x(), stroke.p_P[k - 1].y())->p_P;
    for (int i = 1; i <= 50; ++i) {
      const Vector2d p = stroke.p_P[k - 1] + (stroke.p_P[k] - stroke.p_P[k - 1]) * i / 50.0;
      const Vector3d next = surface(p.x(), p.y())->p_P;
      length += (next - last).norm();
      last = next;
    }
  }
  return length;
}

// A developable surface: where points go, and how long straight strokes become.
void expect_unrolls(const SurfaceHeight& surface, const Flat& exact, double radius,
                    double place_limit) {
  constexpr unsigned seed = 7;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> part(-1, 1);
  const Wrap wrap(surface, kCentre, {circle(kCentre, radius)});
  double worst = 0;
  for (int k = 0; k < 500; ++k) {
    const Vector2d flat = kCentre + radius / std::sqrt(2) * Vector2d(part(random), part(random));
    const std::optional<Vector2d> plane = wrap.to_plane(flat);
    ASSERT_TRUE(plane) << flat.transpose();
    worst = std::max(worst, (*plane - exact(flat)).norm());
    EXPECT_LT((*wrap.to_flat(*plane) - flat).norm(), 1e-11);
  }
  fmt::print("place error {:.4f} µm\n", 1e6 * worst);
  EXPECT_LT(worst, place_limit);

  double stretch = 0;
  for (int k = 0; k < 30; ++k) {
    const Vector2d a = kCentre + radius / std::sqrt(2) * Vector2d(part(random), part(random));
    const Vector2d b = kCentre + radius / std::sqrt(2) * Vector2d(part(random), part(random));
    const WrappedStrokes wrapped = wrap.wrap({surfaces::line({a, b})});
    ASSERT_EQ(wrapped.strokes.size(), 1u);
    EXPECT_TRUE(wrapped.lost.empty());
    stretch = std::max(stretch,
                       std::abs(surface_length(surface, wrapped.strokes[0]) / (b - a).norm() - 1));
  }
  fmt::print("stretch {:.2e}\n", stretch);
  EXPECT_LT(stretch, 1e-3);
}

TEST(Wrap, IsAnIsometryOnATiltedPlane) {
  constexpr unsigned seed = 3;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (int k = 0; k < 3; ++k) {
    const double heading =
        std::uniform_real_distribution<double>(-std::numbers::pi, std::numbers::pi)(random);
    SCOPED_TRACE(heading);
    const Vector2d uphill(std::cos(heading), std::sin(heading));
    const double slope = std::tan(30 * std::numbers::pi / 180);
    const auto exact = [&](const Vector2d& flat) -> Vector2d {
      const Vector2d d = flat - kCentre;
      return kCentre + d - (1 - std::cos(30 * std::numbers::pi / 180)) * d.dot(uphill) * uphill;
    };
    expect_unrolls(height_field([&](double x, double y) {
                     return slope * uphill.dot(Vector2d(x, y) - kCentre);
                   }),
                   exact, 0.12, 1e-9);
  }
}

TEST(Wrap, UnrollsACylinder) {
  const double R = 0.20, phi0 = 0.25;  // the centre lies down the side
  const double axis = kCentre.x() - R * std::sin(phi0);
  const SurfaceHeight surface =
      height_field([&](double x, double) { return std::sqrt(R * R - (x - axis) * (x - axis)); });
  const auto exact = [&](const Vector2d& flat) -> Vector2d {
    return {axis + R * std::sin(phi0 + (flat.x() - kCentre.x()) / R), flat.y()};
  };
  expect_unrolls(surface, exact, 0.12, 5e-6);

  const Wrap wrap(surface, kCentre, {circle(kCentre, 0.10)});
  const PlacedStroke wrapped = wrap.wrap({circle(kCentre, 0.10)}).strokes.at(0);
  double geodesic_error = 0;
  for (std::size_t k = 0; k < wrapped.p_P.size(); ++k) {
    const Vector2d& p = wrapped.p_P[k];
    const double geodesic =
        std::hypot(R * (std::asin((p.x() - axis) / R) - phi0), p.y() - kCentre.y());
    geodesic_error =
        std::max(geodesic_error, std::abs(geodesic - (wrapped.page[k] - kCentre).norm()));
  }
  fmt::print("geodesic radius error {:.3f} µm\n", 1e6 * geodesic_error);
  EXPECT_LT(geodesic_error, 1e-3 * 0.10);
}

TEST(Wrap, UnrollsACone) {
  const double k = std::tan(35 * std::numbers::pi / 180), slant = std::sqrt(1 + k * k), r0 = 0.15;
  const Vector2d apex = kCentre - Vector2d(r0, 0);
  const SurfaceHeight surface =
      height_field([&](double x, double y) { return -k * (Vector2d(x, y) - apex).norm(); });
  const auto exact = [&](const Vector2d& flat) -> Vector2d {
    const Vector2d from_apex = flat - kCentre + Vector2d(slant * r0, 0);
    const double angle = slant * std::atan2(from_apex.y(), from_apex.x());
    return apex + from_apex.norm() / slant * Vector2d(std::cos(angle), std::sin(angle));
  };
  expect_unrolls(surface, exact, 0.10, 2e-5);
}

// Among maps of a spherical cap that only move points along meridians, to the distance g(ρ), the
// least sum of squared stretches less 1 is a quadratic problem in g: finite elements of degree one,
// solved directly.
std::vector<double> best_azimuthal(double R, double rho_max, int n) {
  const double h = rho_max / n;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);  // of g_1 … g_n; g_0 = 0
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (int e = 0; e < n; ++e) {
    const double s = R * std::sin((e + 0.5) * h / R);  // circle's radius at the middle
    const double rows[2][3] = {{-1 / h, 1 / h, 1}, {0.5 / s, 0.5 / s, 1}};
    for (const auto& row : rows) {
      for (int i = 0; i < 2; ++i) {
        if (e + i == 0) continue;
        b(e + i - 1) += h * s * row[i] * row[2];
        for (int j = 0; j < 2; ++j) {
          if (e + j > 0) A(e + i - 1, e + j - 1) += h * s * row[i] * row[j];
        }
      }
    }
  }
  const Eigen::VectorXd g = A.ldlt().solve(b);
  std::vector<double> result{0};
  result.insert(result.end(), g.begin(), g.end());
  return result;
}

TEST(Wrap, OnTheBowlIsTheBestAzimuthalMap) {
  const Vector2d centre(0.60, 0);
  const double R = surfaces::kBowlRadius, radius = 0.12;
  const WrapSettings settings;
  const Wrap wrap(surfaces::bowl, centre, {circle(centre, radius)}, settings);
  // The cap that is laid flat ends where its flat radius is radius + margin.
  double low = 0.05, high = 0.30;
  const int n = 400;
  for (int k = 0; k < 40; ++k) {
    const double middle = (low + high) / 2;
    (best_azimuthal(R, middle, n).back() < radius + settings.margin ? low : high) = middle;
  }
  const std::vector<double> g = best_azimuthal(R, low, n);
  const auto flat_radius = [&](double rho) {
    const double at = rho / low * n;
    const int e = std::min(static_cast<int>(at), n - 1);
    return g[e] + (at - e) * (g[e + 1] - g[e]);
  };
  double worst = 0, equidistant = 0;
  for (int k = 0; k < 360; ++k) {
    const double rho = low * (k + 1) / 400.0, heading = 2.4 * k;
    const Vector2d p =
        centre + R * std::sin(rho / R) * Vector2d(std::cos(heading), std::sin(heading));
    const std::optional<Vector2d> flat = wrap.to_flat(p);
    ASSERT_TRUE(flat);
    const Vector2d desired =
        centre + flat_radius(rho) * Vector2d(std::cos(heading), std::sin(heading));
    worst = std::max(worst, (*flat - desired).norm());
    equidistant = std::max(equidistant, std::abs(flat_radius(rho) - rho));
  }
  fmt::print("off the best azimuthal map {:.1f} µm, which is {:.1f} µm off the equidistant one\n",
             1e6 * worst, 1e6 * equidistant);
  EXPECT_LT(worst, 1e-4);
  EXPECT_GT(equidistant, 5e-4) << "the equidistant map would pass too";
}

// A map that is linear in each triangle turns by a spacing's worth of curvature at every edge, and
// not at all in between.
TEST(Wrap, BendsStraightLinesWithoutKinks) {
  const Vector2d centre(0.60, 0);
  const Wrap wrap(surfaces::waves, centre, {circle(centre, 0.10)});
  const double step = 1e-4;
  std::vector<Vector2d> line;
  for (int k = 0; k < 1200; ++k)
    line.push_back(*wrap.to_plane(centre + Vector2d(-0.06 + k * step, 0.013 + 0.3 * k * step)));
  const auto bend = [&](std::size_t k, std::size_t apart) -> double {
    return (line[k + apart] - 2 * line[k] + line[k - apart]).norm();
  };
  double close = 0, wide = 0;
  for (std::size_t k = 50; k + 50 < line.size(); ++k) {
    close = std::max(close, bend(k, 1));
    wide = std::max(wide, bend(k, 50) / 2500);  // as if it were spread evenly
  }
  fmt::print("largest bend {:.3g} µm, spread {:.3g} µm\n", 1e6 * close, 1e6 * wide);
  EXPECT_LT(close, 1.5 * wide);
}

TEST(Wrap, DifferentialIsThatOfTheMap) {
  const Vector2d centre(0.60, 0);
  const Wrap wrap(surfaces::waves, centre, {circle(centre, 0.10)});
  std::mt19937 random(11);
  std::uniform_real_distribution<double> part(-0.06, 0.06);
  const double d = 1e-6;
  for (int k = 0; k < 100; ++k) {
    const Vector2d p = centre + Vector2d(part(random), part(random));
    const Eigen::Matrix2d J = wrap.chart().differential(p);
    for (int axis = 0; axis < 2; ++axis) {
      const Vector2d step = d * Vector2d::Unit(axis);
      EXPECT_LT(
          (J.col(axis) - (*wrap.to_flat(p + step) - *wrap.to_flat(p - step)) / (2 * d)).norm(),
          1e-4);
    }
  }
  const Eigen::Matrix2d at_centre = wrap.chart().differential(centre);
  EXPECT_NEAR(at_centre(0, 1), at_centre(1, 0), 1e-9);
  EXPECT_LT((*wrap.to_plane(centre) - centre).norm(), 1e-11);
}

// A drawing on a hill of 68° whose upper half was left out was judged by a patch about the rest:
// up to 2.6 mm RMS off, for another patch has another map.
TEST(Wrap, LaidOnAnotherSurfaceKeepsItsCells) {
  const Vector2d top = kCentre + Vector2d(0, 0.05);
  const auto hill = [&](double height) {
    return height_field([=](double x, double y) {
      return height * std::exp(-(Vector2d(x, y) - top).squaredNorm() / (2 * 0.03 * 0.03));
    });
  };
  const PlacedStroke upper = surfaces::line(
                         {kCentre + Vector2d(-0.05, 0.02), kCentre + Vector2d(0.05, 0.02)}),
                     lower = surfaces::line(
                         {kCentre + Vector2d(-0.05, -0.02), kCentre + Vector2d(0.05, -0.02)});
  const SurfaceHeight surface = hill(0.122);
  const Wrap wrap(surface, kCentre, {upper, lower});
  const auto off = [&](const Wrap& other) {
    double squares = 0;
    for (int k = 0; k <= 100; ++k) {
      const Vector2d flat = lower.p_P[0] + k / 100.0 * (lower.p_P[1] - lower.p_P[0]);
      squares += (*other.to_plane(flat) - *wrap.to_plane(flat)).squaredNorm() / 101;
    }
    return std::sqrt(squares);
  };
  EXPECT_LT(off(wrap.laid_on(surface)), 1e-9);
  const double higher = off(wrap.laid_on(hill(0.1225))),
               anew = off(Wrap(surface, kCentre, {lower}));
  fmt::print("0.5 mm higher: {:.3f} mm off, with a patch of its own {:.3f} mm\n", 1e3 * higher,
             1e3 * anew);
  EXPECT_GT(higher, 1e-6);
  EXPECT_LT(higher, 3e-4);
  EXPECT_GT(anew, 5e-4) << "any patch would do";
}

TEST(Wrap, IsTheSameEveryTime) {
  const Vector2d centre(0.60, 0);
  const PlacedStroke stroke = circle(centre, 0.08);
  const WrappedStrokes a = Wrap(surfaces::waves, centre, {stroke}).wrap({stroke});
  const WrappedStrokes b = Wrap(surfaces::waves, centre, {stroke}).wrap({stroke});
  ASSERT_EQ(a.strokes.size(), 1u);
  ASSERT_EQ(a.strokes[0].p_P.size(), b.strokes[0].p_P.size());
  for (std::size_t k = 0; k < a.strokes[0].p_P.size(); ++k)
    EXPECT_EQ(a.strokes[0].p_P[k], b.strokes[0].p_P[k]);
}

// Lines 2 mm apart on the page: their distances on the surface, relative to that, beyond the rim.
std::vector<double> hatch_spacings(const SurfaceHeight& surface, double angle, bool wrapped) {
  constexpr double kSpacing = 2e-3, kHalf = 0.03;
  const Vector2d along(std::cos(angle), std::sin(angle)), across(-along.y(), along.x());
  std::vector<PlacedStroke> lines;
  for (double off = -kHalf; off <= kHalf + 1e-9; off += kSpacing)
    lines.push_back(surfaces::line(
        {kCentre + off * across - kHalf * along, kCentre + off * across + kHalf * along}));
  if (wrapped) lines = Wrap(surface, kCentre, lines).wrap(lines).strokes;
  std::vector<std::vector<Vector3d>> laid;
  for (const PlacedStroke& line : lines) {
    laid.emplace_back();
    for (std::size_t k = 1; k < line.p_P.size(); ++k) {
      const int steps =
          std::max(1, static_cast<int>((line.p_P[k] - line.p_P[k - 1]).norm() / 5e-5));
      for (int i = 0; i < steps; ++i) {
        const Vector2d p = line.p_P[k - 1] + (line.p_P[k] - line.p_P[k - 1]) * i / steps;
        laid.back().push_back(surface(p.x(), p.y())->p_P);
      }
    }
  }
  std::vector<double> spacings;
  for (std::size_t l = 1; l < laid.size(); ++l) {
    for (std::size_t i = laid[l].size() / 10; i < laid[l].size() * 9 / 10; i += 40) {
      double nearest = INFINITY;
      for (const Vector3d& q : laid[l - 1]) nearest = std::min(nearest, (q - laid[l][i]).norm());
      spacings.push_back(nearest / kSpacing);
    }
  }
  return spacings;
}

// The spacing of straight lines is that of the surface where the page is wrapped. Projected, it is
// up to 1 / cos(slope) wider: 41 % at 45°.
TEST(Wrap, HatchesKeepTheirSpacingOnSlopes) {
  const SurfaceHeight slope = height_field([](double x, double) { return x - 0.6; });
  // Slopes reach 45° at the hatch's corners.
  const SurfaceHeight dome = height_field([](double x, double y) {
    const double r2 = (Vector2d(x, y) - kCentre).squaredNorm();
    return std::sqrt(0.06 * 0.06 - std::min(r2, 0.0035));
  });
  for (const double angle : {0.0, std::numbers::pi / 4, std::numbers::pi / 2}) {
    SCOPED_TRACE(angle);
    const auto range = [&](const SurfaceHeight& surface, bool wrapped) {
      std::vector<double> all = hatch_spacings(surface, angle, wrapped);
      std::sort(all.begin(), all.end());
      fmt::print("spacing {:.3f} to {:.3f} (95 %: {:.3f}), wrapped {}\n", all.front(), all.back(),
                 all[all.size() * 95 / 100], wrapped);
      return std::pair(all.front(), all.back());
    };
    const auto [least, most] = range(slope, true);
    EXPECT_GT(least, 0.95);
    EXPECT_LT(most, 1.05);
    // No chart of a dome keeps every length (Gauss).
    const auto [closest, widest] = range(dome, true);
    EXPECT_GT(closest, 0.95);
    EXPECT_LT(widest, 1.055);
    const double steepest = 1 / std::sqrt(1 - std::pow(std::sin(angle), 2) / 2);
    EXPECT_NEAR(range(slope, false).second, steepest, 0.005);
  }
}

}  // namespace
}  // namespace impedraw
