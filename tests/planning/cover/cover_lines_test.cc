// Lines that cover a surface against closed forms: distances on a slope and on a sphere, and what a
// footprint sweeps.
#include "impedraw/planning/cover/cover_lines.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "impedraw/planning/cover/even_lines.h"
#include "impedraw/planning/path/tip_planner.h"

namespace impedraw {
namespace {

constexpr double kStep = 1.5e-3, kHalf = 0.1, kRadius = 0.3;  // [m]

SurfaceHeight slope(double angle_deg) {
  const double t = std::tan(angle_deg * std::numbers::pi / 180.0);
  return [t](double x, double y) -> SurfaceHeight::Sample {
    if (std::abs(x) > kHalf || std::abs(y) > kHalf) return std::nullopt;
    return SurfaceSample{{x, y, t * y}, Eigen::Vector3d(0.0, -t, 1.0).normalized()};
  };
}

Eigen::Vector3d on_sphere(const Eigen::Vector2d& p) {
  return {p.x(), p.y(), std::sqrt(kRadius * kRadius - p.squaredNorm())};
}

SurfaceHeight dome() {
  return [](double x, double y) -> SurfaceHeight::Sample {
    if (std::hypot(x, y) > kHalf) return std::nullopt;
    const Eigen::Vector3d p = on_sphere({x, y});
    return SurfaceSample{p, p / kRadius};
  };
}

SurfaceGrid grid_of(const SurfaceHeight& height) {
  const Eigen::Vector2d corner = Eigen::Vector2d::Constant(kHalf + 0.01);
  return sample_surface(height, {-corner, corner}, kStep, 70.0);
}

CoverWish wish() {
  CoverWish w;
  w.footprint = {0.015, 1.4e-3, 0.01};
  w.spacing = 0.0093;
  w.direction_deg = 0.0;
  return w;
}

// The foam touches 1.4 mm below the footprint's plane and no deeper: on a ridge that falls off with
// the fourth power, the strips beside are swept and not pressed.
TEST(SurelyPressed, LeavesOutWhatTheFoamDoesNotTouch) {
  const auto ridge = [](double steep) {
    return grid_of([steep](double x, double y) -> SurfaceHeight::Sample {
      if (std::abs(x) > kHalf || std::abs(y) > kHalf) return std::nullopt;
      const double a = std::abs(y) / 0.015;
      return SurfaceSample{
          {x, y, -steep * std::pow(a, 4)},
          Eigen::Vector3d(0.0, 4.0 * steep * std::pow(a, 3) / 0.015 * (y > 0 ? 1 : -1), 1.0)
              .normalized()};
    });
  };
  const std::vector<std::vector<Eigen::Vector2d>> lines = {{{-0.05, 0.0}, {0.05, 0.0}}};
  const Footprint foot = wish().footprint;
  for (const double steep : {0.0, 4e-3}) {
    const SurfaceGrid g = ridge(steep);
    const std::vector<char> pressed = surely_pressed(g, lines, PressedFeet(g, foot)),
                            covered = swept(g, lines, foot.radius - kAstray);
    double widest = 0.0;
    for (std::size_t v = 0; v < g.size(); ++v) {
      EXPECT_LE(pressed[v], covered[v]);
      if (pressed[v]) widest = std::max(widest, std::abs(g.plane(v).y()));
    }
    if (steep == 0.0)
      EXPECT_EQ(pressed, covered);
    else
      EXPECT_NEAR(widest, 0.0115, 1.5e-3);
  }
}

// A height that is continued into what was not seen is no place to promise.
TEST(SurelyPressed, LeavesOutWhatIsNotKnown) {
  SurfaceGrid g = grid_of(slope(0.0));
  const std::size_t unseen = g.index(g.nx / 2, g.ny / 2);
  g.known[unseen] = 0;
  const std::vector<char> pressed =
      surely_pressed(g, {{{-0.05, 0.0}, {0.05, 0.0}}}, PressedFeet(g, wish().footprint));
  EXPECT_FALSE(pressed[unseen]);
  EXPECT_TRUE(pressed[unseen + 1]);
}

TEST(SurfaceDistance, OnASlopeOf45Degrees) {
  const SurfaceGrid g = grid_of(slope(45.0));
  const std::vector<double> T = distance_across(g, {0.0, 0.0}, {1.0, 0.0});
  for (std::size_t v = 0; v < g.size(); ++v)
    if (g.known[v] && g.plane(v).cwiseAbs().maxCoeff() < 0.08) {
      ASSERT_NEAR(T[v], std::sqrt(2.0) * g.plane(v).y(), 1e-3 * kHalf);
    }
}

TEST(SurfaceDistance, OnASphere) {
  const SurfaceGrid g = grid_of(dome());
  const std::vector<double> T = distance_across(g, {0.0, 0.0}, {1.0, 0.0});
  for (std::size_t v = 0; v < g.size(); ++v)
    if (g.known[v] && g.plane(v).norm() < 0.09) {
      ASSERT_NEAR(T[v], kRadius * std::asin(g.plane(v).y() / kRadius), 0.3e-3);
    }
}

// Of the rows' level sets from each other, on the surface.
TEST(SurfaceGrid, HasTheSamePlacesOnAnotherSurface) {
  for (int i = 0; i < 50; ++i) {
    const double step = 1e-3 + 1e-5 * i;
    const SurfaceGrid g = sample_surface(
        slope(0.0), {Eigen::Vector2d(-0.021, -0.013), Eigen::Vector2d(0.0123, 0.034)}, step, 70.0);
    const SurfaceGrid same = same_places(g, slope(30.0), 70.0);
    ASSERT_EQ(same.nx, g.nx);
    ASSERT_EQ(same.ny, g.ny);
    ASSERT_EQ(same.z.size(), g.z.size());
    for (std::size_t v = 0; v < g.size(); v += 7)
      ASSERT_NEAR(same.z[v], std::tan(std::numbers::pi / 6.0) * g.plane(v).y(), 1e-12);
  }
}

// Of a cap: 2πR h. Beside a step, its side is no area to cover.
TEST(SurfaceGrid, AreasAreThoseOfTheSurface) {
  const SurfaceGrid cap = grid_of(dome());
  double sum = 0.0;
  for (std::size_t v = 0; v < cap.size(); ++v)
    if (cap.plane(v).norm() < 0.09) sum += cap.area[v];
  const double h = kRadius - std::sqrt(kRadius * kRadius - 0.09 * 0.09);
  EXPECT_NEAR(sum, 2.0 * std::numbers::pi * kRadius * h, 0.01 * sum);

  const SurfaceGrid step = grid_of([](double x, double y) -> SurfaceHeight::Sample {
    return SurfaceSample{{x, y, x > 0.0 ? 0.05 : 0.0}};
  });
  for (std::size_t v = 0; v < step.size(); ++v) ASSERT_DOUBLE_EQ(step.area[v], kStep * kStep);
}

TEST(CoverLines, AreEquallySpacedOnTheSphere) {
  const SurfaceGrid g = grid_of(dome());
  const std::vector<double> T = distance_across(g, {0.0, 0.0}, {1.0, 0.0});
  const double spacing = 0.0093;
  for (int k = -7; k < 7; ++k)
    for (const auto& line : level_lines(g, T, k * spacing))
      for (const Eigen::Vector2d& p : line) {
        if (p.norm() > 0.085) continue;
        const auto at = [](const Eigen::Vector2d& q) {
          return kRadius * std::asin(q.y() / kRadius);
        };
        for (const auto& next : level_lines(g, T, (k + 1) * spacing)) {
          double nearest = 1.0;
          for (const Eigen::Vector2d& q : next)
            nearest = std::min(nearest, std::abs(q.x() - p.x()));
          for (const Eigen::Vector2d& q : next)
            if (std::abs(q.x() - p.x()) <= nearest) {
              ASSERT_NEAR(at(q) - at(p), spacing, 0.05 * spacing);
            }
        }
      }
}

TEST(CoverLines, LeaveNothingOfWhatTheFootprintReaches) {
  for (const SurfaceHeight& height : {slope(45.0), dome()}) {
    const SurfaceGrid g = grid_of(height);
    const CoverWish w = wish();
    const Centres c = footprint_centres(g, w);
    const CoverLines lines = cover_lines(g, c, w);
    ASSERT_GT(lines.rows, 10U);
    EXPECT_LE(lines.passes.size(), 3U);
    const double reached = area_of(g, swept(g, c, w.footprint.radius));
    EXPECT_GT(area_of(g, swept(g, lines.passes, w.footprint.radius)), 0.99 * reached);
    for (const auto& pass : lines.passes)
      for (const Eigen::Vector2d& p : pass) ASSERT_GT(g.sample(c.clearance, p), -kStep);
  }
}

// Control points on a circle: the spline's knots lie at (2 + cos θ) / 3 of its radius, and it bends
// nowhere by more than that.
TEST(CoverLines, RoundedBendsEvenly) {
  constexpr double kRound = 0.01;
  std::vector<Eigen::Vector2d> circle;
  for (int k = 0; k <= 12; ++k)
    circle.push_back(kRound * Eigen::Vector2d(std::cos(k * std::numbers::pi / 6.0),
                                              std::sin(k * std::numbers::pi / 6.0)));
  circle.back() = circle.front();
  const std::vector<Eigen::Vector2d> line = rounded(circle, 0.5e-3);
  ASSERT_TRUE(is_closed(line));
  const double radius = kRound * (2.0 + std::cos(std::numbers::pi / 6.0)) / 3.0;
  for (std::size_t i = 1; i + 1 < line.size(); ++i) {
    EXPECT_NEAR(line[i].norm(), radius, 1e-5);
    EXPECT_LE((line[i] - line[i - 1]).norm(), 0.5e-3);
    const Eigen::Vector2d a = line[i] - line[i - 1], b = line[i + 1] - line[i];
    const double turn = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    EXPECT_NEAR(0.5 * (a.norm() + b.norm()) / turn, radius, 0.03 * radius);
  }
  circle.pop_back();
  const std::vector<Eigen::Vector2d> open = rounded(circle, 0.5e-3);
  EXPECT_LT((open.front() - circle.front()).norm(), 1e-12);
  EXPECT_LT((open.back() - circle.back()).norm(), 1e-12);
}

// A disc of radius r that presses foam by δ on a sphere of radius R: p/p̄ = 1 + (r²/2 − d²)/(2 R δ).
TEST(PressedFoot, PressesMostInTheMiddleOfADome) {
  const SurfaceGrid g = grid_of(dome());
  const Footprint foot{0.015, 3.5e-3, 0.01};
  const Eigen::Vector3d top = g.lifted({0.0, 0.0});
  const PressedFoot pressed(g, top, foot);
  for (const double d : {0.0, 0.005, 0.010, 0.014})
    EXPECT_NEAR(pressed.pressure(g.lifted({d, 0.0})),
                1.0 + (0.5 * 0.015 * 0.015 - d * d) / (2.0 * kRadius * 3.5e-3), 5e-3)
        << d;
}

// z = c (x/r)³ is level in the middle; the plane under a disc of radius r rises there by c/2r.
TEST(PressedFoot, GivesTheSurfaceTheNormalUnderAFace) {
  constexpr double r = 0.015, c = 2e-3;
  const SurfaceHeight cubic = [](double x, double y) -> SurfaceHeight::Sample {
    if (std::abs(x) > kHalf || std::abs(y) > kHalf) return std::nullopt;
    return SurfaceSample{{x, y, c * std::pow(x / r, 3)},
                         Eigen::Vector3d(-3.0 * c * x * x / (r * r * r), 0.0, 1.0).normalized()};
  };
  const SurfaceGrid g = sample_surface(
      cubic, {Eigen::Vector2d(-0.03, -0.03), Eigen::Vector2d(0.03, 0.03)}, 1e-3, 80.0);
  const SurfaceHeight level = with_normals_of(PressedFeet(g, {r, 3.5e-3, 0.01}), g, cubic);
  const auto sample = level(0.0, 0.0);
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->p_P, cubic(0.0, 0.0)->p_P);
  EXPECT_NEAR(sample->n_P.x() / sample->n_P.z(), -0.5 * c / r, 3e-3);
  EXPECT_FALSE(level(2.0 * kHalf, 0.0));
}

// Between the vertices feet agree with those that are fitted there.
TEST(PressedFoot, IsBilinearBetweenVertices) {
  const SurfaceGrid g = grid_of(dome());
  const Footprint foot{0.015, 3.5e-3, 0.01};
  const PressedFeet feet(g, foot);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-0.05, 0.05), off(-0.01, 0.01);
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector2d p(place(random), place(random));
    const PressedFoot fitted(g, g.lifted(p), foot), sampled = feet.at(g, p);
    const Eigen::Vector3d q = g.lifted(p + Eigen::Vector2d(off(random), off(random)));
    EXPECT_NEAR(sampled.depth(q), fitted.depth(q), 2e-5) << p.transpose();
    EXPECT_NEAR(sampled.pressure(q), fitted.pressure(q), 0.01) << p.transpose();
  }
}

// What evening leaves of a line has a bend at each of its points, where the path would slow down.
TEST(CoverLines, LetThePathKeepItsSpeed) {
  const SurfaceHeight height = dome();
  const SurfaceGrid g = grid_of(height);
  CoverWish w = wish();
  w.spacing = 0.0054;
  const Centres c = footprint_centres(g, w);
  CoverLines lines = cover_lines(g, c, w);
  const double radius = w.footprint.radius;
  even_lines(g, c, inside_by(g, swept(g, lines.passes, radius), radius), lines.edges,
             &lines.passes);
  const auto mean_speed = [&](bool round) {
    PathSettings settings;
    settings.draw_speed = 0.1;
    settings.draw_acceleration = 2.0;
    if (round) settings.tolerance = settings.rounding = 1e-4;
    std::vector<PlacedStroke> strokes;
    for (const auto& pass : lines.passes) {
      const std::vector<Eigen::Vector2d> line = round ? rounded(pass, 1e-3) : pass;
      strokes.push_back({line, line, static_cast<int>(strokes.size())});
    }
    return plan_tip_path(strokes, height, settings).mean_speed();
  };
  EXPECT_LT(mean_speed(false), 0.075);
  EXPECT_GT(mean_speed(true), 0.078);
}

TEST(CoverLines, KeepOffAHole) {
  const SurfaceGrid g = grid_of([](double x, double y) -> SurfaceHeight::Sample {
    if (std::max(std::abs(x), std::abs(y)) > kHalf || std::hypot(x - 0.01, y) < 0.012)
      return std::nullopt;
    return SurfaceSample{{x, y, 0.0}};
  });
  const CoverLines lines = cover_lines(g, footprint_centres(g, wish()), wish());
  for (const auto& pass : lines.passes)
    for (const Eigen::Vector2d& p : pass)
      ASSERT_GT((p - Eigen::Vector2d(0.01, 0.0)).norm(), 0.012 + 0.015);
}

// Where the arm comes and leaves again, if it is known where it does not come.
TEST(CoverLines, AroundTheBorderStartFarFromWhereTheArmDoesNotCome) {
  const SurfaceGrid g = grid_of(slope(20.0));
  Centres c = footprint_centres(g, wish());
  std::vector<char> reached(g.size());
  for (std::size_t v = 0; v < g.size(); ++v) reached[v] = g.plane(v).x() < 0.05;
  c.within_reach = distance_to_edge(g, reached);
  for (std::size_t v = 0; v < g.size(); ++v)
    c.clearance[v] = std::min(c.clearance[v], c.within_reach[v] - 1e-3);
  const CoverLines lines = cover_lines(g, c, wish());
  ASSERT_EQ(lines.edges, 1U);
  EXPECT_LT(lines.passes[0].front().x(), -0.07);
  EXPECT_EQ(lines.passes[0].front(), lines.passes[0].back());
  for (const auto& pass : lines.passes)
    for (const Eigen::Vector2d& p : pass) ASSERT_LT(p.x(), 0.05);
}

TEST(CoverLines, WantAWholeFace) {
  // A ridge as sharp as the pad's radius bears a part of its face only.
  const SurfaceGrid g = grid_of([](double x, double y) -> SurfaceHeight::Sample {
    if (std::max(std::abs(x), std::abs(y)) > kHalf) return std::nullopt;
    return SurfaceSample{{x, y, -0.5 * std::abs(y)}};
  });
  const Centres c = footprint_centres(g, wish());
  EXPECT_FALSE(c.allowed[g.index(g.nx / 2, g.ny / 2)]);
  EXPECT_GT(c.uneven, 0U);
}

}  // namespace
}  // namespace impedraw
