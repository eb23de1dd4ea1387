// What a pad has treated: the map's dose against closed forms on a plane.
#include "impedraw/run/treatment.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "impedraw/experiment/scenario.h"
#include "impedraw/planning/cover/cover_lines.h"
#include "impedraw/planning/cover/even_forces.h"

namespace impedraw {
namespace {

constexpr double kSpeed = 0.1, kDt = 1e-3, kForce = 5.0;

// The plane z = `height`, and a pad that goes along x over z = 0, face down.
TreatmentMap after_a_line(double height, double tilt_deg = 0.0, double sinks = 0.0) {
  SurfaceGrid g;
  g.low = {-0.05, -0.03};
  g.step = 1e-3;
  g.nx = 101;
  g.ny = 61;
  g.z.assign(static_cast<std::size_t>(g.nx * g.ny), height);
  g.known.assign(g.z.size(), 1);
  g.area.assign(g.z.size(), g.step * g.step);
  PadSettings pad;
  pad.rest = kForce / (pad.stiffness * pad.area());
  TreatmentMap map(g, pad, kForce, kSpeed);
  const Eigen::AngleAxisd down(std::numbers::pi + tilt_deg * std::numbers::pi / 180.0,
                               Eigen::Vector3d::UnitX());
  for (double t = 0.0; t < 1.0; t += kDt)
    map.press({{-0.05 + kSpeed * t, 0.0, 0.0}, down.toRotationMatrix()}, kForce,
              {kSpeed, 0.0, sinks}, t, kDt);
  return map;
}

// A flank of 45° that bends, under a pad that goes along it: the plane under its face lies 0.7 mm
// below the line, and its axis passes the line 0.5 mm across.
struct Flank {
  static constexpr double kAtEnds = 0.02;  // [m]
  SurfaceGrid g;
  PadSettings pad;
  PressedFeet feet;
  PlaneLines line{{{-0.03, 0.0}, {0.03, 0.0}}};

  Flank() {
    const SurfaceHeight height = [](double x, double y) -> SurfaceHeight::Sample {
      const double rise = 1.0 - 50.0 * y;
      return SurfaceSample{{x, y, y - 25.0 * y * y}, Eigen::Vector3d(0, -rise, 1).normalized()};
    };
    g = sample_surface(height, {Eigen::Vector2d(-0.06, -0.03), Eigen::Vector2d(0.06, 0.03)}, 5e-4,
                       80.0);
    pad.rest = kForce / (pad.stiffness * pad.area());
    feet = PressedFeet(g, {pad.radius, pad.rest, pad.thickness});
  }
  // The places that the pad has treated, of a grid that lies `off` its own along the normal.
  TreatmentMap treat(double off, double doubt) const {
    SurfaceGrid there = g;
    for (std::size_t v = 0; v < g.size(); ++v) there.z[v] += off * g.area[v] / (g.step * g.step);
    TreatmentMap map(there, pad, kForce, kSpeed, doubt);
    for (double x = line[0][0].x(), t = 0.0; x < line[0][1].x(); x += kSpeed * kDt, t += kDt) {
      const PressedFoot foot = feet.at(g, {x, 0.0});
      const Eigen::Vector3d n = foot.normal(), p = g.lifted({x, 0.0});
      const double o = foot.depth(p) - pad.rest;  // of the line over the plane, along the normal
      const Eigen::Matrix3d R =
          Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), -n).toRotationMatrix();
      map.press({p - Eigen::Vector3d(0, 0, o / n.z()), R}, kForce, {kSpeed, 0, 0}, t, kDt);
    }
    return map;
  }
};

TEST(TreatmentMap, HasTreatedWhatWasPromisedOnAFlank) {
  const Flank flank;
  const std::vector<char> promised = surely_pressed(flank.g, flank.line, flank.feet);
  const TreatmentMap map = flank.treat(0.0, 0.0);
  double area = 0.0;
  for (std::size_t v = 0; v < flank.g.size(); ++v)
    if (promised[v] && std::abs(flank.g.plane(v).x()) < Flank::kAtEnds) {
      area += flank.g.area[v];
      EXPECT_TRUE(map.treated(v)) << flank.g.plane(v).transpose();
    }
  EXPECT_GT(area, 0.9 * 2.0 * Flank::kAtEnds * 2.0 * flank.pad.radius);
}

// An arm that doubts its force doubts its heights, too, by as much as the grid says.
TEST(TreatmentMap, KnowsAsTreatedOnlyWhatIsSoWhereverItLies) {
  Flank flank;
  flank.g.unsure.assign(flank.g.size(), 5e-4);
  const TreatmentMap known = flank.treat(0.0, 0.03);
  double area = 0.0;
  for (const double off : {-4e-4, 4e-4}) {
    const TreatmentMap map = flank.treat(off, 0.0);
    for (std::size_t v = 0; v < flank.g.size(); ++v)
      if (known.treated(v)) {
        area += flank.g.area[v];
        EXPECT_TRUE(map.treated(v)) << flank.g.plane(v).transpose();
      }
  }
  EXPECT_GT(area, 0.0);
}

// The side of a step beside the pad's middle: one row of the grid, 1 mm deep, with all of its area.
TEST(TreatmentMap, AWallBearsNoMoreThanItsPartOfTheDisc) {
  const TreatmentMap level = after_a_line(0.0);
  SurfaceGrid g = level.grid();
  constexpr int kWall = 40;
  constexpr double kDeep = 1e-3;  // [m]
  for (std::size_t v = 0; v < g.size(); ++v) {
    if (g.j_of(v) < kWall) continue;
    g.z[v] = g.j_of(v) == kWall ? -kDeep : -8e-3;
    if (g.j_of(v) == kWall) g.area[v] *= 30.0;
  }
  PadSettings pad;
  pad.rest = kForce / (pad.stiffness * pad.area());
  TreatmentMap map(g, pad, kForce, kSpeed);
  const Eigen::AngleAxisd down(std::numbers::pi, Eigen::Vector3d::UnitX());
  for (double t = 0.0; t < 1.0; t += kDt)
    map.press({{-0.05 + kSpeed * t, 0.0, 0.0}, down.toRotationMatrix()}, kForce, {kSpeed, 0.0, 0.0},
              t, kDt);
  const double r = pad.radius, wall = g.plane(g.index(0, kWall)).y(),
               row = 2.0 * std::sqrt(r * r - wall * wall) * g.step, half = std::acos(wall / r),
               beyond = r * r * (half - std::sin(half) * std::cos(half)) - 0.5 * row,
               depth = (pad.rest * pad.area() + kDeep * row) / (pad.area() - beyond);
  const std::size_t middle = g.index(50, 30);
  EXPECT_NEAR(map.dose(middle) / level.dose(middle), depth / pad.rest, 0.02);
}

TEST(TreatmentMap, HasTheDoseOfADisc) {
  const TreatmentMap map = after_a_line(0.0);
  const SurfaceGrid& g = map.grid();
  const double r = PadSettings().radius;
  for (std::size_t v = 0; v < g.size(); ++v) {
    const Eigen::Vector2d p = g.plane(v);
    if (std::abs(p.x()) > 0.02 || std::abs(p.y()) > 0.9 * r) continue;
    const double chord = 2.0 * std::sqrt(r * r - p.y() * p.y());
    ASSERT_NEAR(map.dose(v), kForce / PadSettings().area() * chord,
                0.04 * kForce / PadSettings().area() * 2.0 * r);
    ASSERT_TRUE(map.treated(v));
  }
}

// A second pass presses 1.2 times as hard; what is asked for lies up to 10 mm beside the pad.
TEST(TreatmentMap, SumsUpWhatItCoversAndMisses) {
  TreatmentMap map = after_a_line(0.0);
  const SurfaceGrid& g = map.grid();
  const double r = PadSettings().radius, p = kForce / PadSettings().area(), half = r + 0.01;
  std::vector<char> places(g.size());
  for (std::size_t v = 0; v < g.size(); ++v)
    places[v] = std::abs(g.plane(v).x()) < 0.02 && std::abs(g.plane(v).y()) < half;
  const TreatmentShares once = shares_of(map, places);
  EXPECT_NEAR(once.treated, once.area * r / half, 0.05 * once.area);
  EXPECT_EQ(once.twice, 0.0);
  const double mean = p * std::numbers::pi * r * r / (2.0 * half),
               square = p * p * 16.0 / 3.0 * r * r * r / (2.0 * half);  // of the chords
  EXPECT_NEAR(once.dose_mean, mean, 0.03 * mean);
  EXPECT_NEAR(once.dose_cv, std::sqrt(square / (mean * mean) - 1.0), 0.05);
  const std::vector<MissedPatch> patches = missed(map, places);
  ASSERT_EQ(patches.size(), 2u);
  EXPECT_NEAR(patches[0].area + patches[1].area, once.area - once.treated, 1e-12);
  EXPECT_NEAR(patches[0].middle_P.y(), -0.5 * (r + half), 1e-3);
  EXPECT_NEAR(patches[1].middle_P.y(), 0.5 * (r + half), 1e-3);
  const Eigen::AngleAxisd down(std::numbers::pi, Eigen::Vector3d::UnitX());
  for (double t = 0.0; t < 1.0; t += kDt)
    map.press({{-0.05 + kSpeed * t, 0.0, 0.0}, down.toRotationMatrix()}, 1.2 * kForce,
              {kSpeed, 0.0, 0.0}, 2.0 + t, kDt);
  EXPECT_NEAR(shares_of(map, places).twice, once.treated, 0.1 * once.area);
  EXPECT_NEAR(map.pressure_mean(), 1.1 * p, 1e-3 * p);
  EXPECT_NEAR(map.pressure_sd(), 0.1 * p, 1e-3 * p);
}

// What is asked for half as hard is treated by half of the force, and even where its dose is half.
TEST(TreatmentMap, KnowsWhatShareAPlaceIsToGet) {
  TreatmentMap map = after_a_line(0.0);
  const std::vector<char> places = [&] {
    std::vector<char> middle(map.grid().size());
    for (std::size_t v = 0; v < middle.size(); ++v)
      middle[v] = map.grid().plane(v).cwiseAbs().maxCoeff() < 0.01;
    return middle;
  }();
  const TreatmentShares all = shares_of(map, places),
                        half = shares_of(map, places, std::vector<double>(places.size(), 0.5));
  EXPECT_NEAR(half.dose_mean, 2.0 * all.dose_mean, 1e-9);
  EXPECT_NEAR(half.dose_cv, all.dose_cv, 1e-9);
  for (const double share : {0.5, 1.0}) {
    PadSettings pad;
    pad.rest = kForce / (pad.stiffness * pad.area());
    TreatmentMap light(map.grid(), pad, kForce, kSpeed);
    const Eigen::AngleAxisd down(std::numbers::pi, Eigen::Vector3d::UnitX());
    for (double t = 0.0; t < 1.0; t += kDt)
      light.press({{-0.05 + kSpeed * t, 0.0, 0.0}, down.toRotationMatrix()}, 0.55 * kForce,
                  {kSpeed, 0.0, 0.0}, t, kDt, true, share);
    EXPECT_NEAR(shares_of(light, places).treated, share == 0.5 ? all.area : 0.0, 1e-9) << share;
  }
}

// A pad that is held with a lean: its joints level it, but for the friction's moment.
TEST(TreatmentMap, LiesAsTheJointsLetIt) {
  const TreatmentMap level = after_a_line(0.0);
  const SurfaceGrid& g = level.grid();
  const auto dose = [&](int joints, double pivot, double lean_deg, std::size_t v) {
    PadSettings pad;
    pad.rest = kForce / (pad.stiffness * pad.area());
    pad.joints = joints;
    pad.pivot = pivot;
    TreatmentMap map(g, pad, kForce, kSpeed);
    const Eigen::AngleAxisd down(std::numbers::pi + lean_deg * std::numbers::pi / 180.0,
                                 Eigen::Vector3d::UnitX());
    for (double t = 0.0; t < 1.0; t += kDt)
      map.press({{-0.05 + kSpeed * t, 0.0, 0.0}, down.toRotationMatrix()}, kForce,
                {kSpeed, 0.0, 0.0}, t, kDt);
    return map.dose(v);
  };
  const std::size_t beside = g.index(50, 38);
  const double even = level.dose(beside),
               on_surface = PadSettings().thickness - 5.0 / 2e6 / PadSettings().area();
  EXPECT_GT(std::abs(dose(0, 0.0, 4.0, beside) / even - 1.0), 0.1);
  EXPECT_NEAR(dose(1, -on_surface, 4.0, beside) / even, 1.0, 0.02);
  EXPECT_NEAR(dose(2, 0.0, 4.0, beside) / even, 1.0,
              0.02);  // leaning ahead evens out along the way
}

// A map that believes the surface to lie elsewhere: the force tells how deep the pad is pressed.
TEST(TreatmentMap, DoesNotDependOnTheHeightOfItsGrid) {
  const TreatmentMap right = after_a_line(0.0);
  for (const double height : {-8e-3, -2e-3, 3e-3}) {
    const TreatmentMap off = after_a_line(height);
    for (std::size_t v = 0; v < off.grid().size(); ++v)
      ASSERT_NEAR(off.dose(v), right.dose(v), 0.01 * right.dose(3080)) << height;
  }
}

// A jet coats a place for the time in which it is on it: the chord over the speed. It does so on a
// ridge as on a plane.
TEST(TreatmentMap, HasTheCoatOfAJet) {
  TreatmentMap flat = after_a_line(0.0);
  SurfaceGrid g = flat.grid();
  for (std::size_t v = 0; v < g.size(); ++v) g.z[v] = -0.2 * std::abs(g.plane(v).y());
  ToolSettings tool;
  tool.kind = ToolKind::nozzle;
  tool.radius = 0.01;
  const PadSettings jet = *jet_of(tool, kForce);
  for (const SurfaceGrid& grid : {flat.grid(), g}) {
    TreatmentMap map(grid, jet, kForce, kSpeed);
    const Eigen::AngleAxisd down(std::numbers::pi, Eigen::Vector3d::UnitX());
    for (double t = 0.0; t < 1.0; t += kDt)
      map.press({{-0.05 + kSpeed * t, 0.0, 0.0}, down.toRotationMatrix()}, kForce,
                Eigen::Vector3d::UnitX(), t, kDt);
    for (std::size_t v = 0; v < grid.size(); ++v) {
      const Eigen::Vector2d p = grid.plane(v);
      if (std::abs(p.x()) > 0.02 || std::abs(p.y()) > 0.9 * 0.01) continue;
      const double time = 2.0 * std::sqrt(1e-4 - p.y() * p.y()) / kSpeed;
      ASSERT_NEAR(map.dose(v) / (kForce / jet.area()), time, 0.01 * time + 2.0 * kDt);
      ASSERT_TRUE(map.treated(v));
    }
  }
}

// Preston's speed is that of sliding.
TEST(TreatmentMap, RemovesNothingWhileItIsSetDown) {
  const TreatmentMap level = after_a_line(0.0), sinking = after_a_line(0.0, 0.0, -2.0 * kSpeed);
  for (std::size_t v = 0; v < level.grid().size(); ++v)
    ASSERT_NEAR(sinking.dose(v), level.dose(v), 1e-9 * level.dose(3080));
}

// Tilted by θ, the pressure falls from one side to the other by 2 k r θ, about the same mean.
TEST(TreatmentMap, PressesHarderOnTheLowerSide) {
  const TreatmentMap level = after_a_line(0.0), tilted = after_a_line(0.0, 2.0);
  const SurfaceGrid& g = level.grid();
  const PadSettings pad;
  const double slope = pad.stiffness * std::tan(2.0 * std::numbers::pi / 180.0);
  for (const int j : {22, 30, 38}) {
    const std::size_t v = g.index(50, j);
    const double y = g.plane(v).y(), chord = 2.0 * std::sqrt(pad.radius * pad.radius - y * y);
    EXPECT_NEAR(std::abs(tilted.dose(v) - level.dose(v)), std::abs(slope * y) * chord,
                0.05 * level.dose(v));
  }
}

}  // namespace
}  // namespace impedraw
