#include "impedraw/drawing/shapes.h"

#include <numbers>

#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/placement.h"
#include "lines.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

std::vector<Vector2d> in_world(const Artwork& artwork) {
  return placed_strokes(artwork, place(artwork, shape_placement())).at(0).p_P;
}

double largest_step(const std::vector<Vector2d>& line) {
  double largest = 0;
  for (std::size_t i = 1; i < line.size(); ++i)
    largest = std::max(largest, (line[i] - line[i - 1]).norm());
  return largest;
}

TEST(Shapes, SineFollowsItsFormulaInTheWorld) {
  const Shape shape = make_shape("sine");
  for (const Artwork& artwork : {shape.drawn, shape.target()}) {
    const std::vector<Vector2d> line = in_world(artwork);
    EXPECT_NEAR(line.front().y(), -0.15, 1e-12);
    EXPECT_NEAR(line.back().y(), 0.15, 1e-12);
    for (const Vector2d& p : line)
      EXPECT_NEAR(p.x(), 0.60 + 0.05 * std::sin(2 * std::numbers::pi * (p.y() + 0.15) / 0.15),
                  1e-12);
    EXPECT_LE(largest_step(line), 1e-4);
  }
}

TEST(Shapes, MHasItsFiveCorners) {
  const Shape shape = make_shape("M");
  const std::vector<Vector2d> corners = in_world(shape.drawn);
  const std::vector<Vector2d> expected{
      {0.52, 0.08}, {0.68, 0.08}, {0.60, 0}, {0.68, -0.08}, {0.52, -0.08}};
  ASSERT_EQ(corners.size(), expected.size());
  for (std::size_t i = 0; i < corners.size(); ++i)
    EXPECT_LT((corners[i] - expected[i]).norm(), 1e-12);
  const std::vector<Vector2d> target = in_world(shape.target());
  EXPECT_LE(largest_step(target), 1e-4 + 1e-12);
  EXPECT_NEAR(lines::length(target), 0.32 + 2 * std::hypot(0.08, 0.08), 1e-12);
}

TEST(Shapes, TenSetPointsAreJoinedAndTheTargetStaysSmooth) {
  const Shape shape = make_shape("sine10");
  const std::vector<Vector2d> points = in_world(shape.drawn);
  ASSERT_EQ(points.size(), 10u);
  for (int i = 0; i < 10; ++i) {
    const double y = -0.15 + i / 30.0;
    EXPECT_LT(
        (points[i] - Vector2d(0.60 + 0.05 * std::sin(2 * std::numbers::pi * (y + 0.15) / 0.15), y))
            .norm(),
        1e-12);
  }
  EXPECT_EQ(shape.target().strokes.at(0).points, make_shape("sine").target().strokes.at(0).points);
}

TEST(Shapes, CircleIsClosedAndOnItsRadius) {
  const Shape shape = make_shape("circle");
  for (const Artwork& artwork : {shape.drawn, shape.target()}) {
    EXPECT_TRUE(artwork.strokes.at(0).closed);
    const std::vector<Vector2d> line = in_world(artwork);
    EXPECT_EQ(line.front(), line.back());
    EXPECT_LT((line.front() - Vector2d(0.60, -0.06)).norm(), 1e-12);
    EXPECT_LT(line[1].x(), 0.60);
    for (const Vector2d& p : line) EXPECT_NEAR((p - Vector2d(0.60, 0.0)).norm(), 0.06, 1e-12);
    EXPECT_LE(largest_step(line), 1e-4);
    EXPECT_NEAR(lines::length(line), 2 * std::numbers::pi * 0.06, 1e-6) << "once around";
  }
}

TEST(Shapes, UnknownNameListsTheKnownOnes) {
  try {
    make_shape("W");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "shape \"W\": not known; there are M, sine, sine10, circle");
  }
}

}  // namespace
}  // namespace impedraw
