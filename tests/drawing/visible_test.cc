// What an SVG's clips, masks and paint order leave, against areas and lengths in closed form.
#include "impedraw/drawing/visible.h"

#include <numbers>
#include <random>

#include <fmt/core.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/dashes.h"
#include "impedraw/drawing/order.h"
#include "impedraw/drawing/svg.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

Artwork painted(const std::string& body, Visible visible = Visible::as_painted) {
  return parse_svg(
      "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='100mm' viewBox='0 0 100 "
      "100'>" +
          body + "</svg>",
      "test", {.may_be_empty = true, .visible = visible});
}
double inked(const std::string& body) { return pen_down_length(painted(body).strokes); }

const std::string kLine = "<path d='M0 50H100' stroke='black'/>";

TEST(Visible, FillsHideWhatLiesBeneath) {
  const std::string square = "<rect x='30' y='30' width='40' height='40' ";
  EXPECT_NEAR(inked(kLine + square + "fill='white'/>"), 60, 1e-3);
  EXPECT_NEAR(painted(kLine + square + "fill='white'/>").hidden_mm, 40, 1e-3);
  EXPECT_NEAR(inked(kLine + square + "fill='red'/>"), 60 + 160, 1e-3);
  EXPECT_NEAR(inked(square + "fill='white'/>" + kLine), 100, 1e-3);
  EXPECT_NEAR(inked(kLine + square + "fill='white' opacity='.4'/>"), 100, 1e-3);
  EXPECT_NEAR(inked("<g opacity='.4'>" + kLine + square + "fill='white'/></g>"), 60, 1e-3);
  EXPECT_NEAR(inked(kLine + "<g opacity='.4'>" + square + "fill='white'/></g>"), 100, 1e-3);
  EXPECT_NEAR(inked(kLine + "<path d='M50 0V100' stroke='#fff' stroke-width='4'/>"), 96, 1e-3);
  EXPECT_EQ(painted(kLine + square + "fill='white'/>", Visible::all).strokes.size(), 2u);
  // A line on the border shows, on whichever side its rounding lies.
  EXPECT_NEAR(inked("<path d='M30 20V80M20 70H80' stroke='black' fill='none'/>" + square +
                    "fill='white' transform='rotate(360 3 7)'/>"),
              120, 1e-3);
}

TEST(Visible, ClipsAndMasks) {
  const std::string circle = "<circle cx='50' cy='50' r='30'/>";
  const auto clipped = [&](const std::string& clip) {
    return inked(clip + "<g clip-path='url(#c)'>" + kLine + "</g>");
  };
  EXPECT_NEAR(clipped("<clipPath id='c'>" + circle + "</clipPath>"), 60, 1e-3);
  EXPECT_NEAR(
      clipped("<clipPath id='d'><rect x='60' width='99' height='99'/></clipPath><clipPath id='c' "
              "clip-path='url(#d)'>" +
              circle + "</clipPath>"),
      20, 1e-3);
  // A tangent is outside.
  EXPECT_NEAR(inked("<clipPath id='c'>" + circle +
                    "</clipPath><path clip-path='url(#c)' d='M0 20H100' stroke='red'/>"),
              0, 1e-9);
  const auto masked = [&](const std::string& mask) {
    return inked("<mask id='m' maskUnits='userSpaceOnUse' x='0' y='0' width='100' height='100'" +
                 mask + "</mask><g mask='url(#m)'>" + kLine + "</g>");
  };
  const std::string box = "><rect width='100' height='100' fill='";
  EXPECT_NEAR(masked(box + "white'/>" + circle), 40, 1e-3);
  EXPECT_NEAR(masked(box + "#444'/>" + circle), 0, 1e-3);
  EXPECT_NEAR(masked(box + "white'/><g opacity='.4'>" + circle + "</g>"), 100, 1e-3);
  EXPECT_NEAR(masked(" style='mask-type:alpha'>" + circle), 60, 1e-3);
}

TEST(Visible, AnAreaShrinksAndItsNewEdgeIsDrawn) {
  const double pi = std::numbers::pi;
  Artwork a = painted(
      "<rect x='20' y='20' width='60' height='60'/><circle cx='50' cy='50' r='20' fill='#fff'/>");
  EXPECT_NEAR(pen_down_length(a.strokes), 240 + 40 * pi, 0.02);
  ASSERT_EQ(a.areas.size(), 1u);
  EXPECT_NEAR(enclosed_area(a.areas[0].outlines), 3600 - 400 * pi, 0.5);
  a = painted(
      "<clipPath id='c'><circle cx='50' cy='50' r='20'/></clipPath>"
      "<rect x='50' y='10' width='60' height='80' clip-path='url(#c)'/>");
  EXPECT_NEAR(pen_down_length(a.strokes), 40 + 20 * pi, 0.02);
  // Colours side by side draw the border once.
  EXPECT_NEAR(inked("<rect x='10' y='10' width='40' height='40' fill='red'/>"
                    "<rect x='50' y='10' width='40' height='40' fill='blue'/>"),
              280, 1e-3);
}

TEST(Visible, WhatShowsThroughAFillIsDrawn) {
  const std::string square = "<rect x='30' y='30' width='40' height='40' fill='red' ";
  EXPECT_NEAR(inked(kLine + square + "opacity='.7'/>"), 100 + 160, 1e-3);
  EXPECT_NEAR(inked(kLine + square + "opacity='.9'/>"), 60 + 160, 1e-3);
}

TEST(Visible, AWhiteVeilHasAnEdgeOnWhatIsColoured) {
  const auto ground = [](const char* colour) {
    return fmt::format("<rect x='10' y='10' width='40' height='80' fill='{}'/>", colour);
  };
  const std::string veil = "<rect x='30' y='30' width='40' height='20' fill='white' opacity='.5'/>",
                    cover = "<rect x='25' y='20' width='25' height='20' fill='#400'/>";
  EXPECT_NEAR(inked(ground("#024") + veil), 240 + 60, 1e-3);
  EXPECT_NEAR(inked(ground("#eef") + veil), 220, 1e-3)
      << "too pale, as is the ground's edge beneath";
  EXPECT_NEAR(inked(veil + ground("#024")), 240, 1e-3) << "beneath";
  EXPECT_NEAR(inked(ground("#024") + veil + cover), 240 + 70 + 30, 1e-3);
  EXPECT_NEAR(inked(ground("#024") + "<path d='M30 40H40' stroke='#fff' stroke-width='4' "
                                     "stroke-opacity='.5'/>"),
              240 + 28, 1e-3);
}

TEST(Visible, ColoursThatLookAlikeHaveNoEdgeBetweenThem) {
  const std::string one = "<rect x='10' y='10' width='40' height='40' fill='#ca353c'/>";
  EXPECT_NEAR(inked(one + "<rect x='50' y='10' width='40' height='40' fill='#c9353d'/>"), 240,
              1e-3);
  EXPECT_NEAR(inked(one + "<rect x='50' y='10' width='40' height='40' fill='#ca4d3c'/>"), 280,
              1e-3);
}

// Against the stops: the gradient has the ground's colour at x = 50, and within 4.7 mm of it
// differs by less than 12 of 255.
TEST(Visible, AnEdgeEndsWhereAGradientHasTheColourBeneath) {
  const double there = inked(
      "<linearGradient id='g' gradientUnits='userSpaceOnUse' x1='0' x2='100' y1='0' y2='0'>"
      "<stop stop-color='black'/><stop offset='1' stop-color='white'/></linearGradient>"
      "<path fill='#808080' d='M-9 0H109V100H-9z'/><path fill='url(#g)' d='M20 40H80V60H20z'/>");
  EXPECT_NEAR(there - inked("<path fill='#808080' d='M-9 0H109V100H-9z'/>"), 160 - 4 * 12 / 2.55,
              0.5);
}

// A screen shows a hairline where areas of one colour lie side by side, but not along its pixels.
TEST(Visible, BordersWithinOneColourAreDrawnIfTheyAreSlanted) {
  const std::string west = "<path fill='#262' d='M10 10H50L60 90H10z'/>",
                    east = "<path fill='#262' d='M50 10H90V90H60z'/>";
  EXPECT_NEAR(inked(west + east), 320 + std::hypot(10, 80), 0.3);
}

TEST(Visible, WhatIsBlurredHasAnEdgeWhereAClipCutsIt) {
  const std::string blur =
                        "<filter id='f' x='-2' y='-2' width='5' height='5'><feGaussianBlur "
                        "stdDeviation='9'/></filter>",
                    soft = "<circle cx='50' cy='50' r='30' filter='url(#f)'/>";
  const std::string line = "<path d='M0 99H9' stroke='red'/>";
  EXPECT_NEAR(inked(blur + line + soft), 9, 1e-3);
  EXPECT_NEAR(inked(blur + line +
                    "<clipPath id='c'><path d='M45 45h9v9h-9z'/></clipPath><g "
                    "clip-path='url(#c)'>" +
                    soft + "</g>"),
              9 + 36, 0.1);
}

// As icons have them: the shadow of a box is one of its middle and two of its ends.
TEST(Visible, ShadowsSideBySideHaveNoEdgeBetweenThem) {
  const std::string shadow =
      "<linearGradient id='s' gradientUnits='userSpaceOnUse' x1='0' x2='0' y1='10' y2='60'>"
      "<stop stop-opacity='.5'/><stop offset='1' stop-opacity='0'/></linearGradient>"
      "<rect x='10' y='10' width='40' height='50' fill='url(#s)'/><rect y='10' height='50' ";
  const auto at_seam = [](const Artwork& artwork) {
    double sum = 0;
    for (const Stroke& stroke : artwork.strokes) {
      for (std::size_t i = 1; i < stroke.points.size(); ++i) {
        const Vector2d &a = stroke.points[i - 1], &b = stroke.points[i];
        if (std::abs(a.x() - 50) < 1 && std::abs(b.x() - 50) < 1) sum += (b - a).norm();
      }
    }
    return sum;
  };
  EXPECT_NEAR(at_seam(painted(shadow + "x='50' width='40' fill='url(#s)'/>")), 0, 1e-3);
  EXPECT_GT(at_seam(painted(shadow + "x='60' width='40' fill='url(#s)'/>")), 40);
  EXPECT_GT(at_seam(painted(shadow + "x='40' width='40' fill='url(#s)'/>")), 40);
}

TEST(Visible, AStrokeIsDrawnWhereItsGradientIsNotClear) {
  EXPECT_NEAR(inked("<linearGradient id='g' gradientUnits='userSpaceOnUse' x1='0' x2='60'>"
                    "<stop/><stop offset='1' stop-opacity='0'/></linearGradient>"
                    "<path d='M0 50H100' fill='none' stroke='url(#g)'/>"),
              60, 4);
}

// A canton: white stripes on blue reach the canton's border, which is the ground's border there.
TEST(Visible, WhiteOverTheRimOfAnAreaEdgesWhatLiesBeneathBoth) {
  const std::string ground = "<rect x='10' y='10' width='80' height='80' fill='red'/>",
                    canton = "<rect x='10' y='10' width='40' height='40' fill='blue'/>";
  const auto stripe = [](const char* colour, int y) {
    return fmt::format("<path d='M10 {}h40v10h-40z' fill='{}'/>", y, colour);
  };
  // On the page's side the stripe's end is no line; towards the ground it is the ground's edge.
  EXPECT_NEAR(inked(ground + canton + stripe("white", 20)), 320 - 10 + 80 + 2 * 40, 1e-3);
  EXPECT_NEAR(inked(ground + canton + stripe("white", 20) + stripe("green", 20)), 320 + 80 + 80,
              1e-3);
}

TEST(Visible, AnEdgeWithinAWideStrokeOfItsColourIsNotSeen) {
  const auto stroke = [](double width) {
    return fmt::format("<path d='M10 50H90' stroke='#262' stroke-width='{}'/>", width);
  };
  const auto area = [](const char* colour) {
    return fmt::format("<path d='M20 10h20v80h-20z' fill='{}'/>", colour);
  };
  constexpr double kLength = 80 - 20, kEdge = 200;  // the area hides a quarter of the line
  EXPECT_NEAR(inked(stroke(12) + area("#262")), kLength + kEdge - 24, 0.05);
  EXPECT_NEAR(inked(stroke(12) + area("#26a")), kLength + kEdge, 0.05);
  EXPECT_NEAR(inked(stroke(0.3) + area("#262")), kLength + kEdge, 0.05) << "crosses";
  const std::string white = "<path d='M15 10h35v80h-35z' fill='white'/>";
  EXPECT_NEAR(inked(stroke(12) + white + area("#262")), 80 - 35 + kEdge, 0.05) << "between them";
}

TEST(Visible, DashesRunOnBehindWhatHidesThem) {
  const Artwork a = painted(
      "<path d='M0 50H100' stroke='black' stroke-dasharray='7 3'/>"
      "<rect x='30.5' y='40' width='31' height='20' fill='#fff'/>");
  double length = 0;
  for (const Stroke& dash : dashed(a.strokes, a.dashes)) {
    length += dash.points.back().x() - dash.points.front().x();
    for (const Vector2d& p : dash.points) {
      const double phase = std::fmod(p.x() + 1e-4, 10);
      EXPECT_TRUE(phase < 7.001) << p.x();
    }
  }
  EXPECT_NEAR(length, 21 + 0.5 + 5.5 + 21, 1e-3);
}

// Random discs, half of them white: every sampled point of every line is inked if and only if no
// later disc covers it.
TEST(Visible, RandomDiscsLeaveWhatNoLaterOneCovers) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0, 100);
    struct Disc {
      Vector2d c;
      double r;
    };
    std::vector<Disc> discs;
    std::string body;
    std::vector<double> rows;
    for (int i = 0; i < 30; ++i) {
      rows.push_back(3 * i + any(random) / 50);
      discs.push_back({{any(random), any(random)}, 2 + any(random) / 5});
      body += fmt::format(
          "<path d='M0 {}H100' stroke='red'/><circle cx='{}' cy='{}' r='{}' fill='#fff'/>",
          rows.back(), discs.back().c.x(), discs.back().c.y(), discs.back().r);
    }
    const Artwork a = painted(body);
    for (int i = 0; i < 30; ++i) {
      for (double x = 0.05; x < 100; x += 0.7) {
        double depth = 1e9;
        for (int k = i; k < 30; ++k)
          depth = std::min(depth, (Vector2d(x, rows[i]) - discs[k].c).norm() - discs[k].r);
        if (std::abs(depth) < 0.01) continue;
        bool drawn = false;
        for (const Stroke& s : a.strokes)
          drawn = drawn || (std::abs(s.points[0].y() - rows[i]) < 1e-4 &&
                            (s.points.front().x() - x) * (s.points.back().x() - x) <= 0);
        EXPECT_EQ(drawn, depth > 0) << i << " " << x;
      }
    }
  }
}

// The trials' inputs: lengths and strokes of their table.
TEST(Visible, WhatWasAskedFor) {
  EXPECT_NEAR(inked("<clipPath id='c'><circle cx='50' cy='50' r='30'/></clipPath><g "
                    "clip-path='url(#c)' fill='none' stroke='black'><path d='M0 20H100M0 50H100M0 "
                    "80H100'/></g>"),
              60, 1e-3);
  const Artwork twice = painted(
      "<g fill='none' stroke='black'><rect x='10' y='10' width='40' height='40'/><rect x='50' "
      "y='10' width='40' height='40'/><path d='M10 10H50'/></g>");
  EXPECT_NEAR(pen_down_length(twice.strokes), 280, 1e-3);
  EXPECT_EQ(twice.strokes.size(), 2u);
  EXPECT_NEAR(twice.doubled_mm, 80, 1e-3);
}

TEST(Visible, LinesAreDoubledWithinTheirOwnWidth) {
  const auto pair = [](double width) {
    const std::string style = fmt::format("' stroke='red' stroke-width='{}'/>", width);
    return inked("<path d='M0 50H100" + style + "<path d='M0 50.06H100" + style);
  };
  EXPECT_NEAR(pair(0.5), 100, 1e-3);
  EXPECT_NEAR(pair(0.1), 200, 1e-3);
}

// Roads of a map: a wide stroke beneath a narrower white one leaves its two rims.
TEST(Visible, TheRimsOfACasingAreDrawn) {
  const auto road = [](const std::string& d, double wide, double narrow) {
    return painted(
        fmt::format("<g fill='none'><path d='{0}' stroke='black' stroke-width='{1}'/><path d='{0}' "
                    "stroke='white' stroke-width='{2}'/></g>",
                    d, wide, narrow));
  };
  Artwork a = road("M0 50H100", 8, 6);
  ASSERT_EQ(a.strokes.size(), 2u);
  EXPECT_NEAR(pen_down_length(a.strokes), 200, 1e-3);
  for (const Stroke& rim : a.strokes) {
    for (const Vector2d& p : rim.points) EXPECT_NEAR(std::abs(p.y() - 50), 3.5, 1e-3);
  }
  a = road("M20 20H80V80H20Z", 4, 3);
  EXPECT_EQ(a.strokes.size(), 2u);
  EXPECT_NEAR(pen_down_length(a.strokes), 4 * (60 + 3.5) + 4 * (60 - 3.5), 1e-2);
  EXPECT_TRUE(road("M0 50H100", 6, 6).strokes.empty());
  EXPECT_TRUE(road("M0 50H100", 6, 8).strokes.empty());
  // A crossing leaves a gap, and no rim.
  EXPECT_NEAR(inked("<path d='M0 50H100' stroke='black' stroke-width='2'/><path d='M50 0V100' "
                    "stroke='white' stroke-width='6'/>"),
              94, 1e-3);
}

// A gradient in a mask shows where it is lighter than one half.
TEST(Visible, GradientsInMasks) {
  const auto masked = [](const std::string& gradient, const std::string& more = "") {
    return inked("<defs>" + gradient +
                 "</defs><mask id='m' maskUnits='userSpaceOnUse' x='0' y='0' width='100' "
                 "height='100'>" +
                 more + "<rect width='100' height='100' fill='url(#g)'/></mask><g mask='url(#m)'>" +
                 kLine + "</g>");
  };
  const std::string white = "<stop stop-color='#fff'/>",
                    stops = "<stop stop-color='#000'/><stop offset='1' stop-color='#fff'/>";
  const auto linear = [&](const std::string& attributes, const std::string& inner) {
    return "<linearGradient id='g' " + attributes + ">" + inner + "</linearGradient>";
  };
  EXPECT_NEAR(masked(linear("", stops)), 50, 0.01);
  EXPECT_NEAR(masked(linear("x1='.2' x2='.6'", stops)), 60, 0.01);
  EXPECT_NEAR(masked(linear("gradientTransform='rotate(90 .5 .5)' x2='.8'", stops)), 100, 0.01);
  EXPECT_NEAR(masked(linear("spreadMethod='reflect' x2='.25'", stops)), 50, 0.01);
  EXPECT_NEAR(masked(linear("spreadMethod='repeat' x2='.4'", stops)), 40, 0.01);
  EXPECT_NEAR(masked(linear("", white + "<stop offset='1' stop-color='#fff' stop-opacity='0'/>")),
              50, 0.01);
  EXPECT_NEAR(masked(linear("", "<stop stop-opacity='0'/><stop offset='.5' stop-opacity='1'/>"),
                     "<rect width='100' height='100' fill='#fff'/>"),
              25, 0.01);
  const std::string radial =
                        "<radialGradient id='g' gradientUnits='userSpaceOnUse' cx='50' "
                        "cy='50' r='40'",
                    bright =
                        "<stop stop-color='#fff'/><stop offset='1' "
                        "stop-color='#000'/></radialGradient>";
  EXPECT_NEAR(masked(radial + ">" + bright), 40, 0.02);
  EXPECT_NEAR(masked(radial + " fx='60' fy='50'>" + bright), 40, 0.02);
  EXPECT_NEAR(masked(radial + " gradientTransform='translate(0 25) scale(.5)'>" + bright), 20,
              0.02);
}

TEST(Visible, HostileInputEndsInOneLine) {
  std::string zigzag = "<clipPath id='c'><path d='M0 0";
  for (int i = 0; i < 10000; ++i) zigzag += fmt::format("L{} {}", i * .01, i % 2 * 100);
  zigzag += "z'/></clipPath><g clip-path='url(#c)'>" + kLine + "</g>";
  EXPECT_LE(inked(zigzag), 100);
  EXPECT_LE(inked("<mask id='m' mask='url(#m)'><rect width='50' height='99' fill='#fff'/></mask>"
                  "<g mask='url(#m)'>" +
                  kLine + "</g>"),
            100);
  std::string same = kLine;
  for (int i = 0; i < 100000; ++i) same += "<path d='M30 30h40v40h-40z' fill='#fff'/>";
  EXPECT_NEAR(inked(same), 60, 1e-3);
}

}  // namespace
}  // namespace impedraw
