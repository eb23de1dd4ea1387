#include "impedraw/drawing/placement.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/svg.h"
#include "impedraw/drawing/text.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

Artwork
letter_f() {  // stem downwards, then the upper arm to the right, then the shorter one below it
  return parse_svg(
      R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">
      <g fill="none" stroke="black">
    <path d="M30 10 V90"/><path d="M30 10 H80"/><path d="M30 45 H60"/></g></svg>)",
      "F");
}

// Seen from above with world +x up and −y to the right.
double right(const Vector2d& p) { return -p.y(); }
double up(const Vector2d& p) { return p.x(); }

TEST(Placement, LetterFIsNotMirroredSeenFromAbove) {
  const Artwork f = letter_f();
  const auto strokes = placed_strokes(f, place(f, {}));
  ASSERT_EQ(strokes.size(), 3u);
  const auto& stem = strokes[0].p_P;
  EXPECT_GT(up(stem.front()), up(stem.back()) + 0.1);  // upright, drawn downwards
  for (int arm : {1, 2}) EXPECT_GT(right(strokes[arm].p_P.back()), right(stem.front()) + 0.05);
  EXPECT_GT(up(strokes[1].p_P.front()),
            up(strokes[2].p_P.front()) + 0.05);  // the long arm on top
  EXPECT_GT(right(strokes[1].p_P.back()), right(strokes[2].p_P.back()) + 0.02);
}

TEST(Placement, MirrorSwapsLeftAndRightOnly) {
  const Artwork f = letter_f();
  PlacementSettings settings;
  settings.mirror = true;
  const auto strokes = placed_strokes(f, place(f, settings));
  EXPECT_LT(right(strokes[1].p_P.back()), right(strokes[0].p_P.front()) - 0.05);
  EXPECT_GT(up(strokes[0].p_P.front()), up(strokes[0].p_P.back()) + 0.1);
}

// The turn from the stem's way down to the top arm's way right, as seen from above:
// counter-clockwise (> 0) on an F that can be read.
double turn_of(const Vector2d& stem_down, const Vector2d& arm_out) {
  const Vector2d a(right(stem_down), up(stem_down)), b(right(arm_out), up(arm_out));
  return a.x() * b.y() - a.y() * b.x();
}

TEST(Placement, LetterFFromSvgAndFromTextReadsFromAbove) {
  TextSettings text;
  text.text = "F";
  for (const Artwork& f : {letter_f(), make_text(text)}) {
    for (const double rotate : {0.0, 90.0, -137.0}) {
      for (const bool mirror : {false, true}) {
        SCOPED_TRACE(f.name + (mirror ? ", mirrored, " : ", ") + std::to_string(rotate));
        PlacementSettings settings;
        settings.rotate_deg = rotate;
        settings.mirror = mirror;
        const Placement placement = place(f, settings);
        // Page (Y down) to seen from above (up): a turn keeps the sense of rotation, page → world
        // xy has determinant < 0.
        EXPECT_EQ(placement.A.determinant() < 0, !mirror);
        const auto strokes = placed_strokes(f, placement);
        ASSERT_EQ(strokes.size(), 3u);
        // By position alone: the stem is the longest, of the arms the top one begins where the
        // stem does.
        const Vector2d top = strokes[0].p_P.front(), bottom = strokes[0].p_P.back();
        const auto& arm_1 = strokes[1].p_P;
        const auto& arm_2 = strokes[2].p_P;
        EXPECT_LT((arm_1.front() - top).norm(), 1e-9);
        EXPECT_GT((arm_2.front() - top).norm(), 0.02);
        EXPECT_GT((bottom - top).norm(), (arm_1.back() - arm_1.front()).norm());
        EXPECT_GT((arm_1.back() - arm_1.front()).norm(), (arm_2.back() - arm_2.front()).norm());
        EXPECT_EQ(turn_of(bottom - top, arm_1.back() - arm_1.front()) > 0, !mirror);
        if (rotate != 0) continue;
        EXPECT_GT(up(top), up(bottom) + 0.1);
        EXPECT_NEAR(right(top), right(bottom), 1e-9);
        EXPECT_EQ(right(arm_1.back()) > right(top), !mirror);
        EXPECT_EQ(right(arm_2.back()) > right(top), !mirror);
        EXPECT_GT(up(arm_1.front()), up(arm_2.front()) + 0.02);
      }
    }
  }
}

TEST(Placement, RotationTurnsCounterClockwiseSeenFromAbove) {
  const Artwork f = letter_f();
  PlacementSettings settings;
  settings.rotate_deg = 90;
  const auto strokes = placed_strokes(f, place(f, settings));
  // What pointed right (the arms) points up, what pointed down (the stem) points right.
  EXPECT_GT(up(strokes[1].p_P.back()), up(strokes[1].p_P.front()) + 0.05);
  EXPECT_GT(right(strokes[0].p_P.back()), right(strokes[0].p_P.front()) + 0.1);
}

TEST(Placement, FitPutsTheFarthestPointOnTheCircle) {
  const Artwork f = letter_f();
  PlacementSettings settings;
  settings.centre_m = {0.5, 0.1};
  settings.fit_radius_m = 0.12;
  double farthest = 0;
  Eigen::AlignedBox2d box;
  for (const auto& stroke : placed_strokes(f, place(f, settings))) {
    for (const Vector2d& p : stroke.p_P)
      farthest = std::max(farthest, (p - settings.centre_m).norm()), box.extend(p);
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
    for (const Vector2d& p : stroke.p_P) box.extend(p);
  }
  EXPECT_NEAR(box.sizes().y(), 0.070, 1e-9);  // the page's X lies along world −y
  EXPECT_NEAR(box.sizes().x(), 0.070 * 80 / 50, 1e-6);
  settings.width_mm.reset();
  settings.height_mm = 40;
  EXPECT_NEAR(place(f, settings).scale(), 40 / (80 * 25.4 / 96), 1e-6);
}

Eigen::AlignedBox2d world_box(const Artwork& artwork, const PlacementSettings& settings) {
  Eigen::AlignedBox2d box;
  for (const auto& stroke : placed_strokes(artwork, place(artwork, settings))) {
    for (const Vector2d& p : stroke.p_P) box.extend(p);
  }
  return box;
}

TEST(Placement, FitsIntoARectangleLessTheMargin) {
  const Artwork f = letter_f();  // 50 wide, 80 high; on a page of 100 × 100
  PlacementSettings settings;
  settings.centre_m = {0.55, -0.03};
  settings.margin_mm = 10;
  settings.fit_width_m = 0.12;
  Eigen::AlignedBox2d box = world_box(f, settings);
  EXPECT_NEAR(box.sizes().y(), 0.10, 1e-9);
  EXPECT_LT((box.center() - settings.centre_m).norm(), 1e-9);
  settings.fit_height_m = 0.12;  // now the height bounds it
  box = world_box(f, settings);
  EXPECT_NEAR(box.sizes().x(), 0.10, 1e-9);
  EXPECT_NEAR(box.sizes().y(), 0.10 * 50 / 80, 1e-6);
  settings.rotate_deg = 90;  // lying, the F may be as long as the rectangle is wide
  settings.fit_width_m = 0.30, settings.fit_height_m = 0.27;
  box = world_box(f, settings);
  EXPECT_NEAR(box.sizes().y(), 0.28, 1e-9);
  EXPECT_NEAR(box.sizes().x(), 0.28 * 50 / 80, 1e-6);
  // The whole page, its middle at the centre: the F's stem at 30 of 100 lies 20 to the left of it.
  settings.rotate_deg = 0;
  settings.fit_page = true;
  settings.fit_width_m = 0.22, settings.fit_height_m.reset();
  box = world_box(f, settings);
  EXPECT_NEAR(box.max().y(), settings.centre_m.y() + 0.2 * 0.20, 1e-6);
  EXPECT_NEAR(box.max().x(), settings.centre_m.x() + 0.4 * 0.20, 1e-6);
  for (unsigned seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0, 1);
    PlacementSettings turned;
    turned.rotate_deg = 360 * any(random);
    turned.mirror = seed % 2;
    turned.fit_width_m = 0.1 + any(random), turned.fit_height_m = 0.1 + any(random);
    turned.margin_mm = 40 * any(random);
    const Vector2d reach = (world_box(f, turned).max() - turned.centre_m)
                               .cwiseMax(turned.centre_m - world_box(f, turned).min());
    const double y = 0.5 * *turned.fit_width_m - 1e-3 * turned.margin_mm - reach.y();
    const double x = 0.5 * *turned.fit_height_m - 1e-3 * turned.margin_mm - reach.x();
    EXPECT_GE(std::min(x, y), -1e-9);
    EXPECT_LT(std::min(x, y), 1e-9);  // as large as it can be
  }
}

TEST(Placement, AreasCountAsStrokesDo) {
  const Artwork filled = parse_svg(
      "<svg xmlns='http://www.w3.org/2000/svg'><rect x='3' width='40' height='20' "
      "fill='red'/></svg>",
      "a");
  Artwork without = filled;
  without.strokes.clear();
  EXPECT_EQ(place(filled, {}).A, place(without, {}).A);
  EXPECT_EQ(place(filled, {}).origin_mm, place(without, {}).origin_mm);
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
    EXPECT_LT((placement.to_page(placement.to_plane(p)) - p).norm(), 1e-9);
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
  EXPECT_EQ(message(negative), "placement.scale is -1, allowed is more than 0");
  EXPECT_EQ(message(two),
            "placement: of scale, width, height and the rectangle fit_width × fit_height only one "
            "can be given");
  PlacementSettings both = two, wide_margin, lone_margin, lone_page;
  both.scale.reset(), both.fit_width_m = 0.1;
  wide_margin.fit_width_m = 0.1, wide_margin.margin_mm = 50;
  lone_margin.margin_mm = 5;
  lone_page.fit_page = true;
  EXPECT_EQ(message(both), message(two));
  EXPECT_EQ(message(wide_margin),
            "placement.margin is 50 mm, allowed is less than 50 mm, half of fit_width");
  EXPECT_EQ(message(lone_margin),
            "placement: margin needs a rectangle: give fit_width or fit_height, too");
  EXPECT_EQ(message(lone_page),
            "placement: fit_page needs a rectangle: give fit_width or fit_height, too");
  EXPECT_EQ(message(nan), "placement.fit_radius is nan m, allowed is more than 0 and at most 2 m");
  // Beyond sense: no arm reaches that far, and pictures and plans of it take for ever.
  for (const double scale : {1e4, 1e300}) {
    PlacementSettings large;
    large.scale = scale;
    EXPECT_NE(message(large).find("from its centre, allowed is at most 10 m"), std::string::npos);
  }
  PlacementSettings wide;
  wide.width_mm = 1e8;
  EXPECT_NE(message(wide).find("from its centre, allowed is at most 10 m"), std::string::npos);
}

}  // namespace
}  // namespace impedraw
