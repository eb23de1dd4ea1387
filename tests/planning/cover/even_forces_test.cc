// Forces and lines that remove evenly, against closed forms of the dose.
#include "impedraw/planning/cover/even_forces.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "impedraw/planning/cover/cover_lines.h"
#include "impedraw/planning/cover/even_lines.h"

namespace impedraw {
namespace {

constexpr double kPad = 0.015, kSide = 0.08;  // [m]
constexpr Footprint kFoot{kPad, 3.5e-3, 0.01};

SurfaceGrid plane() {
  return sample_surface(
      [](double x, double y) -> SurfaceHeight::Sample {
        if (std::max(std::abs(x), std::abs(y)) > kSide) return std::nullopt;
        return SurfaceSample{{x, y, 0.0}};
      },
      {Eigen::Vector2d::Constant(-0.09), Eigen::Vector2d::Constant(0.09)}, 1.5e-3, 70.0);
}

PressedFeet feet(const SurfaceGrid& g) { return PressedFeet(g, kFoot); }

Centres anywhere(const SurfaceGrid& g) {
  Centres centres;
  centres.feet = feet(g);
  centres.clearance.assign(g.size(), 1.0);
  return centres;
}

double cv(const SurfaceGrid& g, const std::vector<double>& dose, const std::vector<char>& places) {
  double n = 0.0, sum = 0.0, sum2 = 0.0;
  for (std::size_t v = 0; v < g.size(); ++v)
    if (places[v]) n += 1.0, sum += dose[v], sum2 += dose[v] * dose[v];
  return std::sqrt(sum2 / n - sum * sum / n / n) / (sum / n);
}

PlaneLines rows(double spacing) {
  PlaneLines lines;
  for (double y = -0.06; y < 0.0601; y += spacing) {
    auto& line = lines.emplace_back();
    for (double x = -0.06; x < 0.0601; x += 2e-3) line.emplace_back(x, y);
  }
  return lines;
}

TEST(DoseOf, IsTheChordOfTheDisc) {
  const SurfaceGrid g = plane();
  const std::vector<double> dose = dose_of(g, {rows(1.0)[0]}, feet(g));
  for (std::size_t v = 0; v < g.size(); ++v) {
    const Eigen::Vector2d p = g.plane(v);
    const double off = std::abs(p.y() + 0.06);
    if (std::abs(p.x()) > 0.04) continue;
    ASSERT_NEAR(dose[v], off < kPad ? 2.0 * std::sqrt(kPad * kPad - off * off) : 0.0, 1e-9);
  }
}

// The first harmonic of rows at the distance s vanishes where J_1(2 π r/s) does: at r/s = 1.62.
// A stroke of 1 µm on a dome, off its middle.
TEST(DoseOf, IsThePressureOfTheFootWhereItStands) {
  const SurfaceGrid g = sample_surface(
      [](double x, double y) -> SurfaceHeight::Sample {
        return SurfaceSample{{x, y, -2.0 * (x * x + y * y)}};
      },
      {Eigen::Vector2d::Constant(-0.06), Eigen::Vector2d::Constant(0.06)}, 1.5e-3, 70.0);
  const Eigen::Vector2d p(0.02, 0.01), end = p + Eigen::Vector2d(1e-6, 0.0);
  const std::vector<double> dose = dose_of(g, {{p, end}}, feet(g));
  const PressedFoot foot = feet(g).at(g, p);
  const double way = (g.lifted(end) - g.lifted(p)).norm();
  for (std::size_t v = 0; v < g.size(); ++v)
    if ((g.plane(v) - p).norm() < 0.8 * kPad) {
      ASSERT_NEAR(dose[v], way * foot.pressure(g.point(v)), 1e-3 * way);
    }
}

// The places that rows treat as much as endless ones.
std::vector<char> middle_of(const SurfaceGrid& g) {
  std::vector<char> middle(g.size());
  for (std::size_t v = 0; v < g.size(); ++v)
    middle[v] = g.plane(v).cwiseAbs().maxCoeff() < 0.06 - 2.0 * kPad;
  return middle;
}

TEST(DoseOf, IsEvenInTheMiddleOfRowsAtTheZeroOfABesselFunction) {
  const SurfaceGrid g = plane();
  const std::vector<char> middle = middle_of(g);
  EXPECT_LT(cv(g, dose_of(g, rows(kPad / 1.62), feet(g)), middle), 0.04);
  EXPECT_GT(cv(g, dose_of(g, rows(kPad / 0.8), feet(g)), middle), 0.1);
}

TEST(EvenForces, MakeTheDoseMoreEvenWithinTheirLimits) {
  const SurfaceGrid g = plane();
  CoverWish wish;
  wish.footprint = {kPad, 3.5e-3, 0.01};
  wish.spacing = 0.0093;
  const Centres centres = footprint_centres(g, wish);
  const CoverLines lines = cover_lines(g, centres, wish);
  const std::vector<char> places = inside_by(g, swept(g, lines.passes, kPad - 5e-4), kPad);
  const auto forces = even_forces(g, lines.passes, feet(g), {places}, {0.9, 1.1});
  const double even = cv(g, dose_of(g, lines.passes, feet(g)), places);
  EXPECT_LT(cv(g, dose_of(g, lines.passes, feet(g), forces), places), 0.95 * even);
  double n = 0.0, sum = 0.0;
  ASSERT_EQ(forces.size(), lines.passes.size());
  for (std::size_t l = 0; l < forces.size(); ++l) {
    ASSERT_EQ(forces[l].size(), lines.passes[l].size());
    for (std::size_t i = 0; i < forces[l].size(); ++i) {
      ASSERT_NEAR(forces[l][i], 1.0, 0.1 + 1e-9);
      if (i > 0) {
        ASSERT_NEAR(forces[l][i], forces[l][i - 1], 0.1);
      }
      sum += forces[l][i], n += 1.0;
    }
  }
  EXPECT_NEAR(sum / n, 1.0, 0.03);
}

// A dose that grows by 1.5 % of the least for each millimetre along x, to 2.2 times as much.
TEST(EvenForces, GiveEachPlaceItsShare) {
  const SurfaceGrid g = plane();
  const PlaneLines once = rows(kPad / 1.62);
  WantedDose wanted{std::vector<char>(g.size()), std::vector<double>(g.size(), 1.0)};
  for (std::size_t v = 0; v < g.size(); ++v) {
    wanted.places[v] = g.plane(v).cwiseAbs().maxCoeff() < 0.06 - 1.5 * kPad;
    wanted.share[v] = 1.0 + 15.0 * g.plane(v).x();
  }
  wanted.whole = mean_of(g, dose_of(g, once, feet(g)), wanted.places);
  const auto off = [&](const PlaneLines& lines, const ForceRange& range) {
    const auto forces = even_forces(g, lines, feet(g), wanted, range);
    for (const auto& line : forces)
      for (const double f : line) {
        EXPECT_GE(f, range.least - 1e-9);
        EXPECT_LE(f, range.most + 1e-9);
      }
    std::vector<double> dose = dose_of(g, lines, feet(g), forces);
    for (std::size_t v = 0; v < g.size(); ++v) dose[v] /= wanted.share[v] * wanted.whole;
    EXPECT_NEAR(mean_of(g, dose, wanted.places), 1.0, 0.03);
    return cv(g, dose, wanted.places);
  };
  EXPECT_LT(off(once, {0.4, 2.0}), 0.05);
  // Up to the force of one pass: a second pass lies where more is wanted, and ends beyond it.
  const ForceRange one{0.4, 1.0};
  const PlaneLines twice = in_passes(g, once, feet(g), wanted, one, 2);
  ASSERT_GT(twice.size(), once.size());
  for (std::size_t l = 0; l < once.size(); ++l) EXPECT_EQ(twice[l], once[l]);
  for (std::size_t l = once.size(); l < twice.size(); ++l)
    for (const Eigen::Vector2d& p : twice[l]) EXPECT_GT(p.x(), -0.7 * kPad);
  EXPECT_LT(off(twice, one), 0.09);
  EXPECT_EQ(in_passes(g, once, feet(g), wanted, one, 1).size(), once.size());
}

// Of the lines that cover a plane, at a spacing.
struct Covered {
  SurfaceGrid g = plane();
  Centres centres;
  CoverLines lines;
  std::vector<char> promised, inner;

  explicit Covered(double spacing, Layout layout = Layout::rows) {
    CoverWish wish;
    wish.footprint = {kPad, 3.5e-3, 0.01};
    wish.spacing = spacing;
    centres = footprint_centres(g, wish);
    lines = cover_lines(g, centres, wish, layout);
    promised = swept(g, lines.passes, kPad - 5e-4);
    inner = inside_by(g, promised, kPad);
  }
};

TEST(EvenLines, MakeTheDoseEvenToTheBorder) {
  for (const auto& [spacing, limit] : {std::pair{0.0057, 0.058}, {0.0093, 0.069}}) {
    Covered c(spacing);
    const PlaneLines before = c.lines.passes;
    even_lines(c.g, c.centres, c.inner, c.lines.edges, &c.lines.passes);
    const double even = cv(c.g, dose_of(c.g, c.lines.passes, feet(c.g)), c.inner);
    EXPECT_LT(even, limit) << spacing;
    EXPECT_LT(even, 0.9 * cv(c.g, dose_of(c.g, before, feet(c.g)), c.inner)) << spacing;
    ASSERT_GE(c.lines.edges, 1U);
    for (std::size_t l = 0; l < c.lines.edges; ++l) EXPECT_EQ(c.lines.passes[l], before[l]);
    for (const auto& pass : c.lines.passes)
      for (const Eigen::Vector2d& p : pass) ASSERT_GT(c.g.sample(c.centres.clearance, p), -1.5e-3);
    const std::vector<char> after = swept(c.g, c.lines.passes, kPad - 5e-4);
    EXPECT_GT(area_of(c.g, after), 0.999 * area_of(c.g, c.promised)) << spacing;
  }
}

// On a square of 160 mm rings follow what the border wants of the density of way. With lines that
// are further apart rows are as even.
TEST(EvenLines, RingsBesideTheBorderLeaveLessUneven) {
  Covered rows(0.0054), rings(0.0054, Layout::rings);
  const auto evened = [](Covered* c) {
    const double left = even_lines(c->g, c->centres, c->inner, c->lines.edges, &c->lines.passes);
    EXPECT_NEAR(left, cv(c->g, dose_of(c->g, c->lines.passes, feet(c->g)), c->inner), 1e-3);
    return left;
  };
  EXPECT_GT(rings.lines.passes.size(), rows.lines.passes.size());
  EXPECT_LT(evened(&rings), 0.95 * evened(&rows));
}

// One row that lies beside its place goes back to it.
TEST(EvenLines, MoveRowsToTheirPlaces) {
  const SurfaceGrid g = plane();
  const std::vector<char> middle = middle_of(g);
  const double spacing = kPad / 1.62;
  PlaneLines lines = rows(spacing);
  const std::size_t k = lines.size() / 2;
  const double own = lines[k].front().y();
  for (Eigen::Vector2d& p : lines[k]) p.y() += 0.25 * spacing;
  even_lines(g, anywhere(g), middle, 0, &lines);
  EXPECT_NEAR(lines[k][lines[k].size() / 2].y(), own, 0.12 * spacing);
}

// The places within 0.3 radii of y.
std::vector<char> strip_beside(const SurfaceGrid& g, double y) {
  std::vector<char> strip(g.size());
  for (std::size_t v = 0; v < g.size(); ++v)
    strip[v] = std::abs(g.plane(v).x()) < 0.05 && std::abs(g.plane(v).y() - y) < 0.3 * kPad;
  return strip;
}

// A strip that two passes treat, of which one ends half way: its other half is passed once more.
TEST(EvenParts, MakeUpForALineThatIsCut) {
  const SurfaceGrid g = plane();
  const std::vector<char> strip = strip_beside(g, 0.0);
  PlaneLines lines(2);
  for (double x = -0.07; x < 0.0701; x += 1e-3) {
    lines[0].emplace_back(x, 0.0);
    if (x < 0.0) lines[1].emplace_back(x, 0.0);
  }
  const double before = cv(g, dose_of(g, lines, feet(g)), strip);
  const std::vector<char> pressed = surely_pressed(g, lines, feet(g));
  even_parts(g, feet(g), strip, &lines);
  EXPECT_GT(before, 0.25);
  EXPECT_LT(cv(g, dose_of(g, lines, feet(g)), strip), 0.5 * before);
  EXPECT_EQ(surely_pressed(g, lines, feet(g)), pressed);
  const PlaneLines once = lines;
  even_parts(g, feet(g), strip, &lines);
  EXPECT_EQ(lines, once);

  const std::vector<char> middle = middle_of(g);
  PlaneLines even = rows(kPad / 1.62);
  even_parts(g, feet(g), middle, &even);
  EXPECT_EQ(even, rows(kPad / 1.62));
  even_parts(g, feet(g), std::vector<char>(g.size()), &lines);
  EXPECT_EQ(lines, once);
}

// Three passes over a strip, and a fourth over a quarter of it, which none needs.
TEST(EvenParts, LeaveOutWhatIsTooMuch) {
  const SurfaceGrid g = plane();
  const std::vector<char> strip = strip_beside(g, 0.0);
  PlaneLines lines(4);
  for (double x = -0.07; x < 0.0701; x += 1e-3)
    for (int l = 0; l < 4; ++l)
      if (l < 3 || std::abs(x) < 0.0175) lines[l].emplace_back(x, 0.0);
  const double before = cv(g, dose_of(g, lines, feet(g)), strip);
  const std::vector<char> pressed = surely_pressed(g, lines, feet(g));
  even_parts(g, feet(g), strip, &lines);
  double way = 0.0;
  for (const auto& line : lines) way += (line.back() - line.front()).norm();
  EXPECT_NEAR(way, 3 * 0.14, 0.02);
  EXPECT_LT(cv(g, dose_of(g, lines, feet(g)), strip), 0.45 * before);
  EXPECT_EQ(surely_pressed(g, lines, feet(g)), pressed);
}

// One pass cannot be left out, however much its places get.
TEST(EvenParts, StayWhereNothingElseTreats) {
  const SurfaceGrid g = plane();
  std::vector<char> strips = strip_beside(g, 0.03);
  const std::vector<char> other = strip_beside(g, -0.03);
  for (std::size_t v = 0; v < g.size(); ++v) strips[v] = strips[v] || other[v];
  PlaneLines lines(2);
  for (double x = -0.07; x < 0.0701; x += 1e-3)
    for (int l = 0; l < 2; ++l) lines[l].emplace_back(x, l == 0 ? 0.03 : -0.03);
  // Back and forth along one of them: all of it but one pass may go.
  for (int k = 0; k < 2; ++k)
    for (double x = -0.07; x < 0.0701; x += 1e-3) lines[0].emplace_back(k == 0 ? -x : x, 0.03);
  const std::vector<char> pressed = surely_pressed(g, lines, feet(g));
  even_parts(g, feet(g), strips, &lines);
  EXPECT_EQ(surely_pressed(g, lines, feet(g)), pressed);
  EXPECT_LT(cv(g, dose_of(g, lines, feet(g)), strips), 0.15);
}

TEST(EvenLines, AreLeftWhereNothingIsToBeEven) {
  const SurfaceGrid g = plane();
  PlaneLines lines = rows(kPad);
  const PlaneLines before = lines;
  even_lines(g, anywhere(g), std::vector<char>(g.size()), 0, &lines);
  EXPECT_EQ(lines, before);
  PlaneLines none;
  even_lines(g, anywhere(g), std::vector<char>(g.size()), 0, &none);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace impedraw
