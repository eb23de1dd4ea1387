// The drawing is put on an object that stays: it keeps off holes, goes near what it is asked to,
// and shrinks where the whole does not fit.
#include "impedraw/experiment/place_surface.h"

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/prepare.h"
#include "impedraw/planning/preflight/place_search.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

// A line of 60 mm along y, about its middle.
std::vector<Vector2d> line() {
  std::vector<Vector2d> points;
  for (int i = -15; i <= 15; ++i) points.emplace_back(0.0, 0.002 * i);
  return points;
}

// A level sheet of 0.2 m × 0.2 m about the origin, but for round holes.
struct Hole {
  Vector2d at;
  double radius;
};
PlaceSearch on_sheet(const std::vector<Hole>& holes, PlaceSearchSettings settings = {}) {
  settings.box = {Vector2d(-0.1, -0.1), Vector2d(0.1, 0.1)};
  return {[holes](double x, double y) -> std::optional<SurfaceSample> {
            if (std::max(std::abs(x), std::abs(y)) > 0.1) return std::nullopt;
            for (const Hole& hole : holes)
              if ((Vector2d(x, y) - hole.at).norm() < hole.radius) return std::nullopt;
            return SurfaceSample{{x, y, 0.0}};
          },
          settings};
}

// Distance of the placed line from a hole's rim, in closed form [m].
double clear_of(const Hole& hole, const PlaceFound& place) {
  double least = 1.0;
  for (const Vector2d& p : line()) least = std::min(least, (place(p) - hole.at).norm());
  return least - hole.radius;
}

TEST(PlaceSearch, KeepsOffHolesWhereverTheyAre) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    const auto in = [&random](double low, double high) {
      return low + (high - low) * random() / std::mt19937::max();
    };
    std::vector<Hole> holes;
    for (int i = 0; i < 3; ++i)
      holes.push_back({{in(-0.08, 0.08), in(-0.08, 0.08)}, in(0.01, 0.03)});
    const PlaceFound place = on_sheet(holes).best(line(), 1.0, {});
    EXPECT_EQ(place.share, 1.0) << "seed " << seed;
    for (const Hole& hole : holes) EXPECT_GT(clear_of(hole, place), 0.0) << "seed " << seed;
    for (const Vector2d& p : line())
      EXPECT_LT(place(p).cwiseAbs().maxCoeff(), 0.1) << "seed " << seed;
  }
}

TEST(PlaceSearch, GoesNearWhatIsAskedFor) {
  const Vector3d wanted(0.06, -0.04, 0.0);
  PlaceSearchSettings settings;
  settings.near = [&](const Vector3d& p) { return 10.0 * (p - wanted).norm(); };
  const PlaceFound place = on_sheet({{{0.0, 0.05}, 0.03}}, settings).best(line(), 1.0, {});
  EXPECT_LT((place.middle - wanted.head<2>()).norm(), 0.015);
}

TEST(PlaceSearch, KeepsOffSteepBrokenAndUnreachableGround) {
  PlaceSearchSettings settings;
  settings.box = {Vector2d(-0.1, -0.1), Vector2d(0.1, 0.1)};
  settings.unreachable = [](const SurfaceSample& s) { return s.p_P.y() > 0.0 ? 1.0 : 0.0; };
  // Steep for x < -0.02, a step of 10 mm at x = 0.03.
  const auto ground = [](double x, double y) -> std::optional<SurfaceSample> {
    if (x < -0.02) return SurfaceSample{{x, y, -5.0 * (x + 0.02)}, Vector3d(5, 0, 1).normalized()};
    return SurfaceSample{{x, y, x > 0.03 ? 0.01 : 0.0}};
  };
  PlaceSearch search(ground, settings);
  const PlaceFound place = search.best(line(), 1.0, {});
  EXPECT_EQ(place.share, 1.0);
  EXPECT_EQ(search.share(line(), place), 1.0);
  for (const Vector2d& p : line()) EXPECT_LT(place(p).y(), 0.024) << "out of reach";
  // What nobody reaches is behind all others, and yet there.
  std::vector<Vector2d> reached;
  for (double x = -0.1; x <= 0.1; x += 0.003)
    for (double y = -0.1; y <= 0.0; y += 0.003) reached.emplace_back(x, y);
  search.avoid(reached);
  const PlaceFound there = search.best(line(), 1.0, {place});
  EXPECT_GT(there.middle.y(), 0.0);
  EXPECT_EQ(search.share(line(), there), there.share) << "out of reach is no trouble of the ground";
  EXPECT_GT(there.cost, place.cost + 2.0);
}

class PlaceSurface : public ScratchFolder {
 protected:
  // A plate of 0.3 m × 0.3 m at the height 0.1 m in front of the arm, with a square hole where an
  // unmoved drawing would be.
  Scenario plate(const std::vector<std::string>& more = {}) const {
    std::ofstream file(folder_ / "plate.obj");
    constexpr int kSide = 30;
    for (int i = 0; i <= kSide; ++i)
      for (int j = 0; j <= kSide; ++j)
        file << "v " << 0.45 + 0.01 * i << ' ' << -0.15 + 0.01 * j << " 0.1\n";
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j) {
        if (i >= 12 && i < 18 && j >= 12 && j < 18) continue;
        const int a = 1 + i * (kSide + 1) + j, b = a + kSide + 1;
        file << "f " << a << ' ' << b << ' ' << b + 1 << ' ' << a + 1 << '\n';
      }
    file.close();
    DrawOptions options;
    options.text = "Hello";
    options.assignments = {"canvas.kind=mesh", "drawing.placement.width=100",
                           "canvas.mesh.file=" + (folder_ / "plate.obj").string()};
    options.assignments.insert(options.assignments.end(), more.begin(), more.end());
    return resolve(options);
  }
};

TEST_F(PlaceSurface, PutsTheWholeBesideTheHole) {
  const Scenario given = plate();
  EXPECT_FALSE(prepare_plan(given, {}, Unreachable::tell).plan.preflight.findings.empty());
  const SurfacePlace found = place_on_surface(given, {}, {});
  EXPECT_GT(found.share, 0.999);
  EXPECT_NEAR(found.p_W.z(), 0.1, 1e-3);
  EXPECT_NEAR(found.size_mm.x(), 100.0, 0.1);
  EXPECT_EQ(found.scenario.canvas.move, given.canvas.move);
  EXPECT_TRUE(prepare_plan(found.scenario).plan.preflight.findings.empty());
  // The printed settings repeat it.
  const Scenario again = plate(found.assignments);
  EXPECT_EQ(again.drawing.placement.centre_m, found.scenario.drawing.placement.centre_m);
  EXPECT_EQ(again.drawing.placement.rotate_deg, found.scenario.drawing.placement.rotate_deg);
}

TEST_F(PlaceSurface, FindsOnlyPlacesOfUse) {
  const SurfaceWish whole = {.near = "", .shrink = false, .least = kNearlyAll};
  const SurfacePlace found = place_on_surface(plate(), {}, whole);
  EXPECT_GE(found.share, kNearlyAll);
  EXPECT_EQ(found.assignments, place_on_surface(plate(), {}, {}).assignments);
  EXPECT_THROW(place_on_surface(plate({"drawing.placement.width=400"}), {}, whole), InputError);
}

TEST_F(PlaceSurface, GoesToTheSideOrPointThatIsAskedFor) {
  const auto at = [&](const std::string& near) {
    const SurfacePlace found = place_on_surface(plate(), {}, {.near = near, .shrink = false});
    EXPECT_GT(found.share, 0.999) << near;
    return found.p_W;
  };
  EXPECT_GT(at("front").x(), 0.66);
  EXPECT_LT(at("back").x(), 0.54);
  EXPECT_GT(at("left").y(), 0.06);
  EXPECT_LT(at("right").y(), -0.06);
  EXPECT_LT((at("0.5,0.08,0.1") - Vector3d(0.5, 0.08, 0.1)).norm(), 0.03);
}

TEST_F(PlaceSurface, ShrinksWhereTheWholeDoesNotFit) {
  const Scenario large = plate({"drawing.placement.width=400"});
  const SurfacePlace whole = place_on_surface(large, {}, {});
  EXPECT_LT(whole.share, 0.9);
  const SurfaceWish smaller = {.near = "", .shrink = true};
  const SurfacePlace found = place_on_surface(large, {}, smaller);
  EXPECT_GT(found.share, 0.98);
  const auto size = whole_size_mm({}, whole, [](double) {});
  ASSERT_TRUE(size);
  EXPECT_NEAR(size->x(), found.size_mm.x(), 0.1);
  EXPECT_FALSE(whole_size_mm(smaller, whole, [](double) {}));
  EXPECT_FALSE(whole_size_mm({}, found, [](double) {}));
  EXPECT_GT(found.size_mm.x(), 150.0);
  EXPECT_LT(found.size_mm.x(), 300.0 * std::numbers::sqrt2);
  std::vector<std::string> again = {"drawing.placement.width=400"};
  again.insert(again.end(), found.assignments.begin(), found.assignments.end());
  const Scenario scenario = plate(again);
  EXPECT_EQ(scenario.drawing.placement.scale, found.scenario.drawing.placement.scale);
  EXPECT_FALSE(scenario.drawing.placement.width_mm);
}

// An upright board, 24 mm thick: its edge is too narrow for letters of 31 mm, its sides are not.
TEST_F(PlaceSurface, LeansToWhereOnlyASideBearsTheDrawing) {
  std::ofstream file(folder_ / "board.obj");
  for (const double z : {0.02, 0.22})
    for (const double y : {-0.012, 0.012})
      for (const double x : {0.5, 0.7}) file << "v " << x << ' ' << y << ' ' << z << '\n';
  file << "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
  file.close();
  const std::string board = "canvas.mesh.file=" + (folder_ / "board.obj").string();
  const SurfacePlace found = place_on_surface(plate({board}), {}, {});
  EXPECT_GT(found.share, 0.98);
  EXPECT_GT(std::abs(found.scenario.drawing.tilt_deg.x()), 30.0);
  EXPECT_NEAR(std::abs(found.p_W.y()), 0.012, 1e-3);
  std::vector<std::string> again = {board};
  again.insert(again.end(), found.assignments.begin(), found.assignments.end());
  EXPECT_EQ(plate(again).drawing.tilt_deg, found.scenario.drawing.tilt_deg);
  // A plane that was tilted stays.
  const SurfacePlace given = place_on_surface(plate({board, "drawing.tilt=[10, 0, 0]"}), {}, {});
  EXPECT_EQ(given.scenario.drawing.tilt_deg, Vector3d(10.0, 0.0, 0.0));
  EXPECT_LT(given.share, found.share);
}

// On an upright can the search alone leaves a stroke's begin beyond a joint's limit on the way.
TEST_F(PlaceSurface, MovesALittleWhereWaysMeetALimit) {
  constexpr int kCorners = 64;
  std::ofstream file(folder_ / "can.obj");
  for (const double z : {0.0, 0.19})
    for (int k = 0; k < kCorners; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kCorners;
      file << "v " << 0.6 + 0.05 * std::cos(angle) << ' ' << 0.05 * std::sin(angle) << ' ' << z
           << '\n';
    }
  file << "v 0.6 0 0.19\n";
  for (int k = 0; k < kCorners; ++k) {
    const int a = k + 1, b = (k + 1) % kCorners + 1, c = a + kCorners, d = b + kCorners;
    file << "f " << a << ' ' << b << ' ' << d << "\nf " << a << ' ' << d << ' ' << c << "\nf " << c
         << ' ' << d << ' ' << 2 * kCorners + 1 << '\n';
  }
  file.close();
  const Scenario can =
      plate({"canvas.mesh.file=" + (folder_ / "can.obj").string(), "drawing.placement.width=110"});
  EXPECT_GT(place_on_surface(can, {}, {}).share, 0.99);
}

// Letters of 31 mm go far round a lying tube of 50 mm: across it the wrist does not turn as far.
TEST_F(PlaceSurface, LeansThePenWhereJointsMeetTheirLimits) {
  constexpr int kCorners = 48;
  constexpr double kRadius = 0.025;
  std::ofstream file(folder_ / "tube.obj");
  for (const double y : {-0.07, 0.07})
    for (int k = 0; k < kCorners; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kCorners;
      file << "v " << 0.6 + kRadius * std::cos(angle) << ' ' << y << ' '
           << 0.045 + kRadius * std::sin(angle) << '\n';
    }
  for (int k = 0; k < kCorners; ++k) {
    const int a = k + 1, b = (k + 1) % kCorners + 1, c = a + kCorners, d = b + kCorners;
    file << "f " << a << ' ' << b << ' ' << d << "\nf " << a << ' ' << d << ' ' << c << '\n';
  }
  file.close();
  const std::string tube = "canvas.mesh.file=" + (folder_ / "tube.obj").string();
  const SurfacePlace found = place_on_surface(plate({tube}), {}, {});
  EXPECT_GT(found.share, 0.99);
  EXPECT_EQ(found.scenario.path.lean_deg, 20.0);
  // The printed settings repeat it.
  std::vector<std::string> again = {tube};
  again.insert(again.end(), found.assignments.begin(), found.assignments.end());
  EXPECT_EQ(plate(again).path.lean_deg, 20.0);
  // A pen that the scenario has leant leans as it says.
  const SurfacePlace given = place_on_surface(plate({tube, "path.lean=15"}), {}, {});
  EXPECT_EQ(given.scenario.path.lean_deg, 15.0);
}

class PlaceOnBoard : public PlaceSurface {
 protected:
  const Vector3d z_ = Vector3d(-0.92, -0.3, -0.25).normalized();
  const Vector3d middle_{0.62, -0.1, 0.22};  // where the arm reaches

  // "Hello" before a board that faces the arm's base, seen as a cloud.
  DrawOptions facing(double width, double height) const {
    const Vector3d x = z_.cross(Vector3d::UnitZ()).normalized(), y = z_.cross(x);
    std::ofstream cloud(folder_ / "board.xyz");
    for (double i = -width / 2; i <= width / 2 + 1e-9; i += 2e-3)
      for (double j = -height / 2; j <= height / 2 + 1e-9; j += 2e-3)
        cloud << (middle_ + i * x + j * y).transpose() << '\n';
    std::ofstream mesh(folder_ / "board.obj");
    for (const double i : {-width / 2, width / 2})
      for (const double j : {-height / 2, height / 2})
        mesh << "v " << (middle_ + i * x + j * y).transpose() << '\n';
    mesh << "f 1 3 4 2\n";
    const Vector3d eye = middle_ + 0.5 * z_;
    DrawOptions options;
    options.text = "Hello";
    options.assignments = {
        "canvas.kind=mesh",
        "drawing.placement.width=100",
        "perception.source=cloud",
        "canvas.mesh.file=" + (folder_ / "board.obj").string(),
        "perception.cloud=" + (folder_ / "board.xyz").string(),
        fmt::format("perception.viewpoint=[{}, {}, {}]", eye.x(), eye.y(), eye.z())};
    return options;
  }
};

// From the usual start the way there leads past the end of a joint's range.
TEST_F(PlaceOnBoard, StartsTheArmBeforeASideThatFacesIt) {
  DrawOptions options = facing(0.16, 0.1);
  const SurfacePlace found = place_on_surface(resolve(options), {}, {});
  EXPECT_GT(found.share, 0.98);
  EXPECT_LT(found.p_W.x(), 0.65);
  const Eigen::Vector3d start = found.scenario.arm.start_p_WE;
  EXPECT_GT(z_.dot(start - found.p_W), 0.02);
  EXPECT_LT((start - found.p_W).norm(), 0.15);
  // The printed settings repeat it.
  options.assignments.insert(options.assignments.end(), found.assignments.begin(),
                             found.assignments.end());
  EXPECT_EQ(resolve(options).arm.start_p_WE, start);
  EXPECT_TRUE(prepare_plan(resolve(options)).plan.preflight.findings.empty());
}

// A board hardly larger than the drawing, which planes of 65° see too narrow.
TEST_F(PlaceOnBoard, LeansThePlaneUntilTheWholeFits) {
  const SurfacePlace found = place_on_surface(resolve(facing(0.11, 0.042)), {}, {});
  EXPECT_GE(found.share, kNearlyAll);
  EXPECT_GT((drawing_frame(found.scenario.drawing).R.col(2)).dot(z_),
            std::cos(20.0 * std::numbers::pi / 180.0));
}

TEST_F(PlaceSurface, RefusesAWishThatMeansNothing) {
  for (const char* near : {"nose", "1,2", "1,2,x", "1,2,3,4", "nan,0,0", ","}) {
    try {
      place_on_surface(plate(), {}, {.near = near, .shrink = false});
      FAIL() << near;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("valid are front, back, left, right, top, or x,y,z"));
    }
  }
}

}  // namespace
}  // namespace impedraw
