// Dashes against lengths in closed form.
#include "impedraw/drawing/dashes.h"

#include <numbers>
#include <random>

#include <fmt/core.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/order.h"
#include "impedraw/drawing/svg.h"
#include "lines.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

std::vector<Stroke> drawn(const std::string& body) {
  const Artwork artwork = parse_svg(
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="200mm" viewBox="0 0 200 200">
    <g fill="none" stroke="black">)" +
          body + "</g></svg>",
      "dashes");
  EXPECT_TRUE(artwork.warnings.empty());
  return dashed(artwork.strokes, artwork.dashes);
}

void expect_spans(const std::vector<Stroke>& strokes,
                  const std::vector<std::pair<double, double>>& spans) {  // along X
  ASSERT_EQ(strokes.size(), spans.size());
  for (std::size_t i = 0; i < spans.size(); ++i) {
    EXPECT_NEAR(strokes[i].points.front().x(), spans[i].first, 1e-3) << i;
    EXPECT_NEAR(strokes[i].points.back().x(), spans[i].second, 1e-3) << i;
    EXPECT_EQ(strokes[i].dash, -1);
  }
}

TEST(Dashes, AlongALine) {
  const auto line = [](const std::string& style) {
    return drawn("<line x1='0' y1='5' x2='20' y2='5' " + style + "/>");
  };
  expect_spans(line("stroke-dasharray='6 3'"), {{0, 6}, {9, 15}, {18, 20}});
  expect_spans(line("stroke-dasharray='6 3' stroke-dashoffset='2'"), {{0, 4}, {7, 13}, {16, 20}});
  expect_spans(line("stroke-dasharray='6 3' stroke-dashoffset='7'"), {{2, 8}, {11, 17}});
  expect_spans(line("stroke-dasharray='6 3' stroke-dashoffset='-2'"), {{2, 8}, {11, 17}});
  expect_spans(line("stroke-dasharray='5'"), {{0, 5}, {10, 15}});
  expect_spans(line("stroke-dasharray='1 2 3'"),
               {{0, 1}, {3, 6}, {7, 9}, {12, 13}, {15, 18}, {19, 20}});  // doubled: 1 2 3 1 2 3
  expect_spans(line("stroke-dasharray='0 5' stroke-linecap='round'"),
               {{0, 0}, {5, 5}, {10, 10}, {15, 15}});
  expect_spans(line("stroke-dasharray='0 5'"), {});
  expect_spans(line("stroke-dasharray='4 0'"), {{0, 20}});
  expect_spans(line("stroke-dasharray='none'"), {{0, 20}});
  expect_spans(line("stroke-dasharray='40 5'"), {{0, 20}});
  expect_spans(line("stroke-dasharray='10%'"),
               {{0, 20}});  // of the viewport's diagonal over √2: 20 mm
}

TEST(Dashes, PathLengthStretchesThem) {
  const auto line = [](const std::string& style) {
    return drawn("<line x1='0' y1='5' x2='80' y2='5' " + style + "/>");
  };
  expect_spans(line("pathLength='8' stroke-dasharray='1'"),
               {{0, 10}, {20, 30}, {40, 50}, {60, 70}});
  expect_spans(line("pathLength='8' stroke-dasharray='2' stroke-dashoffset='1'"),
               {{0, 10}, {30, 50}, {70, 80}});
  expect_spans(line("pathLength='0' stroke-dasharray='10'"), {{0, 80}});
  for (const char* ignored : {"pathLength='-8'", "pathLength='none'", "pathLength=''"})
    expect_spans(line(std::string(ignored) + " stroke-dasharray='30'"), {{0, 30}, {60, 80}});
  // Uses of one line, and a style sheet's dashes.
  expect_spans(drawn("<style>.d{stroke-dasharray:4}</style><defs><path id='a' d='M0 5H80' "
                     "pathLength='8'/></defs><use class='d' href='#a'/>"),
               {{0, 40}});
  // All subpaths together have the length.
  expect_spans(drawn("<path d='M0 5H40 M0 9H40' pathLength='8' stroke-dasharray='1'/>"),
               {{0, 10}, {20, 30}, {0, 10}, {20, 30}});
  for (const char* outline :
       {"<circle cx='50' cy='50' r='20'", "<rect x='9' y='9' width='30' height='20' rx='4'",
        "<path d='M9 9 C 60 9 90 20 90 80 z' transform='translate(0 100) scale(.5 -.9)'"}) {
    const auto dashes = drawn(std::string(outline) + " pathLength='8' stroke-dasharray='1'/>");
    EXPECT_EQ(dashes.size(), 4u) << outline;
  }
  const auto arcs = drawn("<circle cx='50' cy='50' r='20' pathLength='8' stroke-dasharray='1'/>");
  for (const Stroke& arc : arcs) EXPECT_NEAR(lines::length(arc.points), 5 * std::numbers::pi, 0.01);
}

TEST(Dashes, GoOnRoundCornersAndAnewInEachSubpath) {
  const auto strokes = drawn("<path d='M0 0 H10 V10 M50 50 H60' stroke-dasharray='15 3'/>");
  ASSERT_EQ(strokes.size(), 3u);
  EXPECT_EQ(strokes[0].points.size(), 3u);  // the corner is in it
  EXPECT_NEAR(lines::length(strokes[0].points), 15, 1e-3);
  EXPECT_NEAR(lines::length(strokes[1].points), 2, 1e-3);
  EXPECT_NEAR(lines::length(strokes[2].points), 10, 1e-3);
}

TEST(Dashes, ClosedOutlines) {
  // 2π 50 mm in 10 periods of which 0.7 is drawn.
  const double period = 2 * std::numbers::pi * 50 / 10;
  const auto circle = drawn(fmt::format(
      "<circle cx='100' cy='100' r='50' stroke-dasharray='{} {}'/>", 0.7 * period, 0.3 * period));
  ASSERT_EQ(circle.size(), 10u);
  for (const Stroke& dash : circle) EXPECT_NEAR(lines::length(dash.points), 0.7 * period, 0.02);
  // The offset puts the start amid a dash: it goes on over it, and there are as many.
  const auto shifted = drawn(fmt::format(
      "<circle cx='100' cy='100' r='50' stroke-dasharray='{} {}' stroke-dashoffset='{}'/>",
      0.7 * period, 0.3 * period, 0.2 * period));
  ASSERT_EQ(shifted.size(), 10u);
  for (const Stroke& dash : shifted) EXPECT_NEAR(lines::length(dash.points), 0.7 * period, 0.02);
  const auto whole = drawn("<rect width='10' height='10' x='5' y='5' stroke-dasharray='100 1'/>");
  ASSERT_EQ(whole.size(), 1u);
  EXPECT_TRUE(whole[0].closed);
}

TEST(Dashes, AreStretchedWithThePath) {
  // 10 units in 6, 2, 2: ten times as long along X, three times along Y.
  const auto x = drawn("<g transform='scale(10 3)'><line x2='10' stroke-dasharray='6 2'/></g>");
  const auto y = drawn("<g transform='scale(10 3)'><line y2='10' stroke-dasharray='6 2'/></g>");
  ASSERT_EQ(x.size(), 2u);
  ASSERT_EQ(y.size(), 2u);
  EXPECT_NEAR(lines::length(x[0].points), 60, 1e-3);
  EXPECT_NEAR(lines::length(x[1].points), 20, 1e-3);
  EXPECT_NEAR(lines::length(y[0].points), 18, 1e-3);
  EXPECT_NEAR(lines::length(y[1].points), 6, 1e-3);
}

TEST(Dashes, DrawTheirShareAndLieOnTheLine) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0, 1);
    Stroke stroke;
    for (int i = 0; i < 40; ++i) stroke.points.push_back(100 * Vector2d(any(random), any(random)));
    stroke.closed = seed % 2;
    if (stroke.closed) stroke.points.push_back(stroke.points.front());
    stroke.dash = 0;
    Dash dash;
    for (int i = 0; i < 4; ++i) dash.lengths.push_back(5 * any(random));
    dash.offset = 50 * (any(random) - 0.5);
    const double length = lines::length(stroke.points),
                 period = std::accumulate(dash.lengths.begin(), dash.lengths.end(), 0.0);
    const std::vector<Stroke> parts = dashed({stroke}, {dash});
    double expected = 0;                    // by steps of the pattern itself
    const auto on_before = [&](double s) {  // drawn length of the pattern from 0 to s ≥ 0
      double sum = std::floor(s / period) * (dash.lengths[0] + dash.lengths[2]),
             rest = s - std::floor(s / period) * period;
      for (int i = 0; i < 4; ++i) {
        if (i % 2 == 0) sum += std::min(rest, dash.lengths[i]);
        rest -= std::min(rest, dash.lengths[i]);
      }
      return sum;
    };
    const double from = dash.offset + 1000 * period;
    expected = on_before(from + length) - on_before(from);
    EXPECT_NEAR(pen_down_length(parts), expected, 1e-6);
    for (const Stroke& part : parts) {
      for (const Vector2d& p : part.points) EXPECT_LT(lines::distance(p, stroke.points), 1e-9);
    }
  }
}

TEST(Dashes, PatternsThatAreNone) {
  const Stroke line{{{0, 0}, {1000, 0}}, false, 0, 0};
  for (const Dash& dash : {Dash{{1, 2, 3}}, Dash{{}}, Dash{{0, 0}}, Dash{{-1, 3}},
                           Dash{{1, std::nan("")}}, Dash{{1e-5, 1e-5}}})
    EXPECT_THROW(dashed({line}, {dash}), InputError);
}

}  // namespace
}  // namespace impedraw
