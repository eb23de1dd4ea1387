#include "drawing/placement.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "common/errors.h"
#include "drawing/svg.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

Artwork letter_f() {  // stem downwards, then the upper arm to the right, then the shorter one below it
  return parse_svg(R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100"><g fill="none" stroke="black">
    <path d="M30 10 V90"/><path d="M30 10 H80"/><path d="M30 45 H60"/></g></svg>)", "F");
}

// Seen from above with world +x up and −y to the right.
double right(const Vector2d& p) { return -p.y(); }
double up(const Vector2d& p) { return p.x(); }

TEST(Placement, LetterFIsNotMirroredSeenFromAbove) {
  const Artwork f = letter_f();
  const auto strokes = placed_strokes(f, place(f, {}));
  ASSERT_EQ(strokes.size(), 3u);
  const auto& stem = strokes[0].world;
  EXPECT_GT(up(stem.front()), up(stem.back()) + 0.1);                    // upright, drawn downwards
  for (int arm : {1, 2}) EXPECT_GT(right(strokes[arm].world.back()), right(stem.front()) + 0.05);
  EXPECT_GT(up(strokes[1].world.front()), up(strokes[2].world.front()) + 0.05);    // the long arm on top
  EXPECT_GT(right(strokes[1].world.back()), right(strokes[2].world.back()) + 0.02);
}

TEST(Placement, MirrorSwapsLeftAndRightOnly) {
  const Artwork f = letter_f();
  PlacementSettings settings;
  settings.mirror = true;
  const auto strokes = placed_strokes(f, place(f, settings));
  EXPECT_LT(right(strokes[1].world.back()), right(strokes[0].world.front()) - 0.05);
  EXPECT_GT(up(strokes[0].world.front()), up(strokes[0].world.back()) + 0.1);
}

TEST(Placement, RotationTurnsCounterClockwiseSeenFromAbove) {
  const Artwork f = letter_f();
  PlacementSettings settings;
  settings.rotate_deg = 90;
  const auto strokes = placed_strokes(f, place(f, settings));
  // What pointed right (the arms) points up, what pointed down (the stem) points right.
  EXPECT_GT(up(strokes[1].world.back()), up(strokes[1].world.front()) + 0.05);
  EXPECT_GT(right(strokes[0].world.back()), right(strokes[0].world.front()) + 0.1);
}

TEST(Placement, FitPutsTheFarthestPointOnTheCircle) {
  const Artwork f = letter_f();
  PlacementSettings settings;
  settings.centre_m = {0.5, 0.1};
  settings.fit_radius_m = 0.12;
  double farthest = 0;
  Eigen::AlignedBox2d box;
  for (const auto& stroke : placed_strokes(f, place(f, settings))) {
    for (const Vector2d& p : stroke.world) farthest = std::max(farthest, (p - settings.centre_m).norm()), box.extend(p);
  }
  EXPECT_NEAR(farthest, 0.12, 1e-12);
  EXPECT_LT((box.center() - settings.centre_m).norm(), 1e-12);
}

TEST(Placement, WidthAndHeightAreThoseOfTheBox) {
  const Artwork f = letter_f();
  PlacementSettings settings;
  settings.width_mm = 70;
  Eigen::AlignedBox2d box;
  for (const auto& stroke : placed_strokes(f, place(f, settings))) {
    for (const Vector2d& p : stroke.world) box.extend(p);
  }
  EXPECT_NEAR(box.sizes().y(), 0.070, 1e-9);  // the page's X lies along world −y
  EXPECT_NEAR(box.sizes().x(), 0.070 * 80 / 50, 1e-6);
  settings.width_mm.reset();
  settings.height_mm = 40;
  EXPECT_NEAR(place(f, settings).scale(), 40 / (80 * 25.4 / 96), 1e-6);
}

TEST(Placement, ToPageUndoesToWorld) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1, 1);
    PlacementSettings settings;
    settings.centre_m = {any(random), any(random)};
    settings.rotate_deg = 180 * any(random);
    settings.mirror = seed % 2;
    settings.scale = 2 + any(random);
    const Placement placement = place(letter_f(), settings);
    const Vector2d p(100 * any(random), 100 * any(random));
    EXPECT_LT((placement.to_page(placement.to_world(p)) - p).norm(), 1e-9);
    EXPECT_NEAR(placement.scale(), *settings.scale, 1e-12);
  }
}

TEST(Placement, BadSettingsAreNamed) {
  const auto message = [](const PlacementSettings& settings) -> std::string {
    try {
      place(letter_f(), settings);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  PlacementSettings negative, two, nan;
  negative.scale = -1;
  two.scale = 1, two.width_mm = 100;
  nan.fit_radius_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message(negative), "placement scale: -1; must be a number > 0");
  EXPECT_EQ(message(two), "placement: of scale, width_mm and height_mm only one can be given");
  EXPECT_EQ(message(nan), "placement fit_radius_m: nan m; must be a number > 0");
}

}  // namespace
}  // namespace impedraw
