#include "impedraw/ink/ink_lines.h"

#include <gtest/gtest.h>

#include "impedraw/ink/pen.h"

namespace impedraw {
namespace {

std::vector<double> steps(std::size_t n, double h) {
  std::vector<double> t(n);
  for (std::size_t i = 0; i < n; ++i) t[i] = static_cast<double>(i) * h;
  return t;
}

TEST(InkLines, EndWhereForceOrStrokeDo) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  //                            0    1     2  3  4    5     6  7  8
  const std::vector<double> f{0.0, 0.11, 5, 5, 0.1, 0.2, none, 3, 4};
  const std::vector<int> stroke{-1, -1, 0, 0, 0, 0, 0, 1, -1};
  const std::vector<InkLine> lines = ink_lines(f, stroke);
  ASSERT_EQ(lines.size(), 5u);
  const InkLine expected[] = {{-1, 1, 2}, {0, 2, 4}, {0, 5, 6}, {1, 7, 8}, {-1, 8, 9}};
  for (int k = 0; k < 5; ++k) {
    EXPECT_EQ(lines[k].stroke, expected[k].stroke) << k;
    EXPECT_EQ(lines[k].begin, expected[k].begin) << k;
    EXPECT_EQ(lines[k].end, expected[k].end) << k;
  }
  EXPECT_TRUE(ink_lines({}, {}).empty());
}

TEST(Pen, DrawsWiderTheHarderItIsPressed) {
  PenSettings pen;
  pen.width_per_newton = 0.2;
  EXPECT_NEAR(pen.width_at(pen.nominal_force + 2.0), pen.width + 0.4, 1e-12);
  EXPECT_NEAR(pen.force_for(pen.width - 0.4), pen.nominal_force - 2.0, 1e-12);
}

TEST(StrokeSpans, FollowThePlanAlone) {
  const std::vector<double> f(10, 0.0);
  const std::vector<int> stroke{-1, 3, 3, -1, 4, 4, 5, -1, 3, 3};
  const std::vector<StrokeSpan> spans = stroke_spans(steps(10, 0.001), f, stroke);
  ASSERT_EQ(spans.size(), 4u);
  EXPECT_EQ(spans[0].begin, 1u);
  EXPECT_EQ(spans[0].end, 3u);
  EXPECT_EQ(spans[2].stroke, 5);
  EXPECT_EQ(spans[3].stroke, 3);
  EXPECT_EQ(spans[3].end, 10u);
  for (const StrokeSpan& span : spans) EXPECT_FALSE(span.first_touch);
}

// Steps of 0.5 s. Stroke 0 begins at row 10 (5 s), so touches count from row 6 (3 s) on.
TEST(StrokeSpans, FirstTouchIsAtMostTwoSecondsBeforeTheStroke) {
  std::vector<int> stroke(20, -1);
  std::fill(stroke.begin() + 10, stroke.begin() + 14, 0);
  const auto touch = [&](std::vector<std::size_t> rows_with_ink) {
    std::vector<double> f(20, 0.0);
    for (const std::size_t i : rows_with_ink) f[i] = 1.0;
    return stroke_spans(steps(20, 0.5), f, stroke).front().first_touch;
  };
  EXPECT_EQ(touch({2, 5, 8, 12}), 8u);
  EXPECT_EQ(touch({5, 6, 12}), 6u);
  EXPECT_EQ(touch({5, 12, 13}), 12u);
  EXPECT_EQ(touch({5, 14}), std::nullopt);  // before the two seconds, and after the stroke
}

// Stroke 0, stroke 1, stroke 0 again: each pass has a touch of its own, and the last one's is not
// the first's.
TEST(StrokeSpans, EachPassOverAStrokeHasItsOwnFirstTouch) {
  const std::vector<int> stroke{-1, 0, 0, -1, 1, 1, -1, -1, 0, 0, -1, 0, 0};
  const std::vector<double> f{1, 1, 0, 0, 0, 1, 0, 1, 1, 1, 0, 0, 0};
  const std::vector<StrokeSpan> spans = stroke_spans(steps(13, 0.1), f, stroke);
  ASSERT_EQ(spans.size(), 4u);
  EXPECT_EQ(spans[0].first_touch, 0u);
  EXPECT_EQ(spans[1].first_touch, 5u);
  EXPECT_EQ(spans[2].stroke, 0);
  EXPECT_EQ(spans[2].first_touch, 7u);
  EXPECT_EQ(spans[3].stroke, 0);
  EXPECT_EQ(spans[3].first_touch, std::nullopt);
}

TEST(StrokeSpans, FirstTouchIsNotBeforeTheEndOfTheStrokeBefore) {
  const std::vector<int> stroke{0, 0, -1, -1, 1, 1};
  EXPECT_EQ(
      stroke_spans(steps(6, 0.1), std::vector<double>{1, 1, 0, 1, 1, 1}, stroke)[1].first_touch,
      3u);
  EXPECT_EQ(
      stroke_spans(steps(6, 0.1), std::vector<double>{1, 1, 1, 0, 0, 1}, stroke)[1].first_touch,
      2u);
  EXPECT_EQ(
      stroke_spans(steps(6, 0.1), std::vector<double>{1, 1, 0, 0, 0, 0}, stroke)[1].first_touch,
      std::nullopt);
}

}  // namespace
}  // namespace impedraw
