#include "impedraw/drawing/svg.h"

#include <numbers>
#include <random>

#include <fmt/core.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/order.h"
#include "lines.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
constexpr double kPx = 25.4 / 96;

// A page whose unit is 1 mm: 200 mm wide and high.
Artwork on_mm_page(const std::string& body, const SvgSettings& settings = {}) {
  return parse_svg(
      R"(<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"
    xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"
    width="200mm" height="200mm" viewBox="0 0 200 200">)" +
          body + "</svg>",
      "test", settings);
}
Artwork stroked(const std::string& body) {
  return on_mm_page("<g fill='none' stroke='black'>" + body + "</g>");
}
std::vector<Vector2d> only(const Artwork& artwork) {
  EXPECT_EQ(artwork.strokes.size(), 1u);
  return artwork.strokes.at(0).points;
}

void expect_points(const std::vector<Vector2d>& points, const std::vector<Vector2d>& expected,
                   double tolerance = 1e-4) {
  ASSERT_EQ(points.size(), expected.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT((points[i] - expected[i]).norm(), tolerance) << i;
}

TEST(Svg, LinesPolylinesPolygonsAndRectangles) {
  expect_points(only(stroked("<line x1='10' y1='20' x2='30' y2='40'/>")), {{10, 20}, {30, 40}});
  expect_points(only(stroked("<polyline points='0,0 10,0 10,10'/>")), {{0, 0}, {10, 0}, {10, 10}});
  const Artwork polygon = stroked("<polygon points='0,0 10,0 10,10'/>");
  expect_points(only(polygon), {{0, 0}, {10, 0}, {10, 10}, {0, 0}});
  EXPECT_TRUE(polygon.strokes[0].closed);
  EXPECT_EQ(polygon.strokes[0].points.front(), polygon.strokes[0].points.back());
  expect_points(only(stroked("<rect x='5' y='6' width='20' height='10'/>")),
                {{5, 6}, {25, 6}, {25, 16}, {5, 16}, {5, 6}});
  expect_points(only(stroked("<path d='M10 10 h20 v20 H5 l-2 -3 z'/>")),
                {{10, 10}, {30, 10}, {30, 30}, {5, 30}, {3, 27}, {10, 10}});
}

TEST(Svg, CircleIsTheCircle) {
  // usvg's own cubics are off by 0.022 mm here; the smallest unit makes no difference.
  for (const std::string& body :
       {std::string("<circle cx='100' cy='90' r='80'/>"),
        std::string("<g transform='scale(100)'><circle cx='1' cy='.9' r='.8'/></g>"),
        std::string("<path d='M180 90 A80 80 0 0 1 20 90 A80 80 0 0 1 180 90'/>")}) {
    SCOPED_TRACE(body);
    const auto& line = only(stroked(body));
    for (const Vector2d& p : line) EXPECT_NEAR((p - Vector2d(100, 90)).norm(), 80, 1e-3);
    EXPECT_NEAR(lines::length(line), 2 * std::numbers::pi * 80, 0.02);
    const auto circle = [](double s) {
      return Vector2d(100 + 80 * std::cos(2 * std::numbers::pi * s),
                      90 + 80 * std::sin(2 * std::numbers::pi * s));
    };
    EXPECT_LT(lines::worst(circle, line), 4e-3);
  }
}

TEST(Svg, TransformedEllipse) {
  const auto& line =
      only(stroked("<ellipse rx='60' ry='20' transform='translate(100 80) rotate(30) skewX(20) "
                   "scale(1 -1.5)'/>"));
  const double c = std::cos(std::numbers::pi / 6), s = std::sin(std::numbers::pi / 6),
               t = std::tan(std::numbers::pi / 9);
  const auto curve = [&](double f) {
    const Vector2d e(60 * std::cos(2 * std::numbers::pi * f),
                     -30 * std::sin(2 * std::numbers::pi * f));
    const Vector2d skewed(e.x() + t * e.y(), e.y());
    return Vector2d(100 + c * skewed.x() - s * skewed.y(), 80 + s * skewed.x() + c * skewed.y());
  };
  EXPECT_LT(lines::worst(curve, line), 4e-3);
}

TEST(Svg, ArcsOfThePathCommand) {
  // A 120° arc of radius 50 (two cubics) and the rest of it (large-arc).
  const double h = 50 * std::sqrt(3.0);
  for (int large : {0, 1}) {
    SCOPED_TRACE(large);
    const auto& line = only(stroked(
        fmt::format("<path d='M{} 100 A50 50 0 {} 1 {} 100'/>", 100 - h / 2, large, 100 + h / 2)));
    const Vector2d centre(100, 100 + (large ? -25 : 25));
    for (const Vector2d& p : line) EXPECT_NEAR((p - centre).norm(), 50, 1e-3);
    EXPECT_NEAR(lines::length(line), 50 * 2 * std::numbers::pi * (large ? 2 : 1) / 3, 0.01);
  }
}

TEST(Svg, BezierCurvesKeepTheirShape) {
  const auto& cubic = only(stroked("<path d='M20 20 C 180 20 20 180 180 180'/>"));
  const Vector2d p[4] = {{20, 20}, {180, 20}, {20, 180}, {180, 180}};
  EXPECT_LT(lines::worst(
                [&](double s) {
                  const double r = 1 - s;
                  return Vector2d(r * r * r * p[0] + 3 * r * r * s * p[1] + 3 * r * s * s * p[2] +
                                  s * s * s * p[3]);
                },
                cubic),
            4e-3);
  const auto& quad = only(stroked("<path d='M0 0 Q 50 100 100 0'/>"));
  EXPECT_LT(lines::worst([](double s) { return Vector2d(100 * s, 200 * s * (1 - s)); }, quad),
            4e-3);
}

TEST(Svg, RoundedRectangle) {
  const auto& line = only(stroked("<rect x='20' y='30' width='100' height='60' rx='10'/>"));
  EXPECT_NEAR(lines::length(line), 2 * (80 + 40) + 2 * std::numbers::pi * 10, 0.02);
  for (const Vector2d& p : line) {
    const Vector2d d = ((p - Vector2d(70, 60)).cwiseAbs() - Vector2d(40, 20))
                           .cwiseMax(0);  // beyond the straight sides' span
    EXPECT_NEAR(d.norm(), 10, 0.004);
  }
}

TEST(Svg, NestedTransformsCompose) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1, 1);
    Eigen::Affine2d expected = Eigen::Affine2d::Identity();
    std::string open, close;
    for (int level = 0; level < 4; ++level) {
      const double a = 90 * any(random), tx = 20 * any(random), ty = 20 * any(random),
                   s = 1 + 0.3 * any(random);
      open += fmt::format("<g transform='translate({},{}) rotate({}) scale({})'>", tx, ty, a, s);
      close += "</g>";
      expected = expected * Eigen::Translation2d(tx, ty) *
                 Eigen::Rotation2Dd(a * std::numbers::pi / 180) * Eigen::Scaling(s);
    }
    const Artwork a = on_mm_page(
        "<g stroke='black'>" + open + "<line x1='3' y1='-4' x2='50' y2='7'/>" + close + "</g>",
        {.visible = Visible::all});  // some of it is off the page
    expect_points(only(a), {expected * Vector2d(3, -4), expected * Vector2d(50, 7)}, 2e-4);
  }
}

TEST(Svg, UnitsAndViewBox) {
  const std::string body = "<line x1='0' y1='0' x2='96' y2='48' stroke='black'/></svg>";
  const std::string xmlns = "<svg xmlns='http://www.w3.org/2000/svg' ";
  // No size: the viewBox's units are px.
  Artwork a = parse_svg(xmlns + "viewBox='0 0 192 96'>" + body, "a");
  expect_points(only(a), {{0, 0}, {25.4, 12.7}});
  EXPECT_LT((a.page.max() - Vector2d(50.8, 25.4)).norm(), 1e-4);
  // A size in inches over a viewBox with an origin of its own.
  a = parse_svg(xmlns + "width='2in' height='1in' viewBox='-96 0 192 96'>" + body, "b");
  expect_points(only(a), {{25.4, 0}, {50.8, 12.7}});
  // Of another shape than its viewBox: kept in proportion and centred.
  a = parse_svg(xmlns + "width='100mm' height='100mm' viewBox='0 0 96 48'>" + body, "c");
  expect_points(only(a), {{0, 25}, {100, 75}}, 1e-3);
  // Neither size nor viewBox.
  expect_points(only(parse_svg(xmlns + ">" + body, "d")), {{0, 0}, {96 * kPx, 48 * kPx}});
}

TEST(Svg, QuarterMillimetres) {
  const std::string body = "<line x1='0' y1='0' x2='20' y2='10' stroke='black'/></svg>";
  const std::string xmlns = "<svg xmlns='http://www.w3.org/2000/svg' ";
  // 40 Q are 1 cm: a page of 20 × 10 mm, one unit of which is 1 mm.
  const Artwork a =
      parse_svg(xmlns + "width='80Q' height=' 40q ' viewBox='0 0 20 10'>" + body, "a");
  EXPECT_LT((a.page.max() - Vector2d(20, 10)).norm(), 1e-4);
  expect_points(only(a), {{0, 0}, {20, 10}}, 1e-3);
  expect_points(only(stroked("<line x1='4Q' y1='.8Q' x2='1e1Q' y2='2'/>")),
                {{96 / 25.4, 0.2 * 96 / 25.4}, {2.5 * 96 / 25.4, 2}}, 1e-3);
  // A path's Q is a curve.
  EXPECT_NEAR(lines::length(only(stroked("<path d='M0 0 Q 5 0 10 0'/>"))), 10, 1e-3);
}

// A style's transform has units and functions that the attribute has not; CSS Transforms Level 1.
TEST(Svg, TransformsOfCss) {
  const auto drawn = [](const std::string& style) {
    return only(stroked("<line x1='10' y1='0' x2='10' y2='5' style='" + style + "'/>"));
  };
  expect_points(drawn("fill:none; transform: translate(20px, 1in) rotate(0.25turn)"),
                {{20, 106}, {15, 106}}, 1e-3);
  expect_points(drawn("transform:translateX(3px)scaleY(2);stroke:red"), {{13, 0}, {13, 10}}, 1e-3);
  expect_points(drawn("transform-origin:10px 5px;transform:rotate(100grad)"), {{15, 5}, {10, 5}},
                1e-3);
  for (const char* sheet : {"<style>.a{fill:none;transform:translate(7px)}</style>",
                            "<style><![CDATA[.b{x:y}.a{transform: translateX( 7px );}]]></style>"})
    expect_points(
        only(stroked(sheet + std::string("<line class='a' x1='1' y1='2' x2='3' y2='4'/>"))),
        {{8, 2}, {10, 4}}, 1e-3);
  // What no attribute can say is told.
  EXPECT_FALSE(stroked("<line x2='9' y2='9' style='transform:translate(50%)'/>").warnings.empty());
}

// As Fabric.js writes them. A browser passes over the declaration alone.
TEST(Svg, ADeclarationWithoutAValueCostsNoOther) {
  const Artwork a = on_mm_page(
      "<path d='M0 0 H10' style='stroke-dasharray: ; fill:;stroke: rgb(0,0,255); fill: none'/>");
  ASSERT_EQ(a.strokes.size(), 1u);
  EXPECT_FALSE(a.strokes[0].edge);
  EXPECT_EQ(a.strokes[0].colour, 0x0000ffu);
}

// The first stop is clear, and lies on the edge.
TEST(Svg, AGradientsEdgeIsNotSeenWhereItIsClear) {
  const Artwork a = on_mm_page(
      "<linearGradient id='l' gradientUnits='userSpaceOnUse' x1='0' y1='0' x2='0' y2='50'>"
      "<stop stop-color='red' stop-opacity='0'/><stop offset='1' stop-color='red'/>"
      "</linearGradient><rect width='100' height='50' fill='url(#l)'/>");
  for (const Stroke& stroke : a.strokes)
    for (const Vector2d& p : stroke.points) EXPECT_GT(p.y(), 0.5);
  EXPECT_GT(pen_down_length(a.strokes), 190);
}

TEST(Svg, ShapesWithoutAnAreaAreCounted) {
  std::string body = "<path d='M0 0 H10 V10 Z'/>";
  for (int i = 0; i < 6000; ++i) body += fmt::format("<path d='M{} 7 h3 z'/>", i % 100 + 1);
  const Artwork a = on_mm_page(body);
  EXPECT_EQ(a.strokes.size(), 1u);
  EXPECT_EQ(a.warnings, (std::vector<std::string>{
                            "6000 filled shapes left out, as they enclose no area (the first at 1, "
                            "7 mm)"}));
  EXPECT_EQ(on_mm_page("<path d='M0 0 H10 V10 Z M5 6 L 7 8 z'/>").warnings,
            (std::vector<std::string>{
                "1 filled shape left out, as it encloses no area (the first at 5, 6 mm)"}));
  const Artwork line = stroked("<path d='M5 6 L 7 8 z'/>");  // there and back: drawn once
  EXPECT_NEAR(lines::length(only(line)), 2 * std::sqrt(2.0), 1e-4);
  EXPECT_EQ(line.warnings.size(), 1u);
}

TEST(Svg, AWhitePageIsNotDrawn) {
  const std::string seen = "<line y1='9' x2='7' y2='9' stroke='black'/>";
  const std::vector<std::string> told{
      "1 white rectangle over the whole page: left out, because the page's background is not "
      "drawn"};
  for (const std::string ground :
       {"<rect width='100%' height='100%' fill='white'/>",
        "<rect x='-5' y='-5' width='210' height='210' style='fill:#ffffff;stroke:none'/>",
        "<path d='M0 0 H200 V200 H0 Z' fill='#fff'/>",
        "<polygon points='0,200 0,0 200,0 200,200 0,200' fill='white'/>"}) {
    SCOPED_TRACE(ground);
    const Artwork a = on_mm_page(ground + seen);
    EXPECT_NEAR(lines::length(only(a)), 7, 1e-4);
    EXPECT_EQ(a.warnings, told);
  }
  // One that is stroked and one of another colour are drawn.
  for (const std::string shape : {"<rect width='200' height='200' fill='white' stroke='black'/>",
                                  "<rect width='200' height='200' fill='#eee'/>"}) {
    SCOPED_TRACE(shape);
    EXPECT_EQ(on_mm_page(shape + seen).strokes.size(), 2u);
  }
}

TEST(Svg, FillAndStrokeDrawOneOutline) {
  const std::string d = "d='M10 10 H50 V50 Z'";
  for (const std::string style :
       {"fill='red'", "fill='none' stroke='black'", "fill='red' stroke='black'",
        "fill='red' stroke='black' paint-order='stroke'", "fill='white' stroke='red'"}) {
    SCOPED_TRACE(style);
    EXPECT_NEAR(lines::length(only(on_mm_page("<path " + d + " " + style + "/>"))),
                80 + 40 * std::sqrt(2.0), 1e-3);
  }
  // Filled, an open path looks closed, whether its stroke has the fill's colour or not.
  EXPECT_EQ(only(on_mm_page("<path d='M10 10 H50 V50'/>")).size(), 4u);
  EXPECT_EQ(only(on_mm_page("<path d='M10 10 H50 V50' stroke='black'/>")).size(), 4u);
  const Artwork two = on_mm_page("<path d='M10 10 H50 V50' fill='red' stroke='black'/>");
  ASSERT_EQ(two.strokes.size(), 2u);
  expect_points(two.strokes[1].points, {{50, 50}, {10, 10}}, 1.3);  // beneath the stroke it ends
  EXPECT_EQ(two.strokes[1].colour, 0xff0000u);
}

TEST(Svg, WhatIsNotPaintedIsNotDrawn) {
  const std::string seen = "<line x1='0' y1='0' x2='7' y2='0' stroke='black'/>";
  for (const std::string unseen :
       {"<path d='M0 0 H10 V10 Z' fill='none'/>", "<path d='M0 0 H10 V10 Z' opacity='0'/>",
        "<g opacity='0'><rect width='9' height='9'/></g>",
        "<linearGradient id='g'><stop stop-opacity='0'/><stop offset='1' "
        "stop-opacity='0'/></linearGradient>"
        "<rect width='9' height='9' fill='url(#g)'/>",
        "<g display='none'><rect width='9' height='9'/></g>",
        "<rect width='9' height='9' visibility='hidden'/>",
        "<rect width='9' height='9' fill-opacity='0'/>",
        "<line x1='0' y1='0' x2='9' y2='9' fill='black'/>",
        "<defs><rect width='9' height='9'/></defs>",
        "<clipPath id='c'><rect width='9' height='9'/></clipPath>",
        "<path d='M5 5 Z' stroke='black'/>", "<rect width='0' height='9'/>",
        "<path d='M0 0 H10' stroke='black' stroke-width='0'/>",
        "<style>.h{display:none}</style><rect class='h' width='9' height='9'/>"}) {
    SCOPED_TRACE(unseen);
    EXPECT_NEAR(lines::length(only(on_mm_page(unseen + seen))), 7, 1e-4);
  }
}

TEST(Svg, SubpathsUsesAndDots) {
  EXPECT_EQ(stroked("<path d='M0 0 H10 M0 5 H10 M0 9 H3 V3 z l 5 5'/>").strokes.size(), 4u);
  const Artwork used = stroked(
      "<defs><line id='a' x1='0' y1='0' x2='5' y2='0'/></defs>"
      "<use xlink:href='#a' x='10'/><use href='#a' y='20'/>");
  ASSERT_EQ(used.strokes.size(), 2u);
  EXPECT_LT((used.strokes[0].points[0] - Vector2d(10, 0)).norm(), 1e-4);
  EXPECT_LT((used.strokes[1].points[0] - Vector2d(0, 20)).norm(), 1e-4);
  const Artwork dot = stroked("<path d='M0 0 H10 M5 5 h0' stroke-linecap='round'/>");
  ASSERT_EQ(dot.strokes.size(), 2u);
  EXPECT_EQ(dot.strokes[1].points.size(), 1u);
}

TEST(Svg, LayersAreTheTopGroups) {
  const Artwork a = on_mm_page(
      "<g id='g1' inkscape:label='outline'><g id='inner'><line x2='5' y2='1' stroke='red'/></g></g>"
      "<line x2='6' y2='1' stroke='red'/><g id='dots'><line x2='7' y2='1' stroke='red'/></g>"
      "<g><line x2='8' y2='1' stroke='red'/><line x2='9' y2='1' stroke='red'/></g>");
  EXPECT_EQ(a.layers, (std::vector<std::string>{"outline", "page", "dots", "4"}));
  ASSERT_EQ(a.strokes.size(), 5u);
  const int expected[] = {0, 1, 2, 3, 3};
  for (int i = 0; i < 5; ++i) EXPECT_EQ(a.strokes[i].layer, expected[i]);
}

TEST(Svg, LayersWithoutStrokesAreNone) {
  const Artwork hidden = on_mm_page(
      "<g inkscape:label='a' display='none'><line x2='5' y2='1' stroke='red'/></g>"
      "<g inkscape:label='b'><line x2='5' y2='0' fill='red'/></g>"
      "<g inkscape:label='c' transform='scale(2)'><line x2='5' stroke='red'/></g>");
  EXPECT_EQ(hidden.layers, (std::vector<std::string>{"c"}));
  EXPECT_NEAR(lines::length(only(hidden)), 10, 1e-4);
  EXPECT_EQ(stroked("<line x2='5'/>").layers,
            (std::vector<std::string>{"1"}));  // a lone group without a name
  // Illustrator's layers stand within a switch.
  const Artwork illustrator = on_mm_page(
      "<switch><foreignObject requiredExtensions='x'/><g extraneous='self'><g id='L1'><g id='in'>"
      "<line x2='5' stroke='red'/></g></g><g id='L2'><line x2='5' stroke='red'/></g></g></switch>");
  EXPECT_EQ(illustrator.layers, (std::vector<std::string>{"L1", "L2"}));
}

TEST(Svg, NothingToDrawMayBeAllowed) {
  SvgSettings settings;
  settings.may_be_empty = true;
  const Artwork empty = parse_svg(
      "<svg xmlns='http://www.w3.org/2000/svg' opacity='0'><rect width='9' height='9'/></svg>", "a",
      settings);
  EXPECT_TRUE(empty.strokes.empty());
  EXPECT_EQ(empty.warnings,
            (std::vector<std::string>{"1 shapes are left out: hidden, or wholly transparent",
                                      "has nothing to draw: no visible path or shape"}));
}

TEST(Svg, WhatIsLeftOutIsTold) {
  const Artwork a = on_mm_page(
      "<marker id='m'><path d='M0 0 L9 9'/></marker><image href='/etc/passwd' width='9' "
      "height='9'/>"
      "<line x2='5' y2='5' stroke='red' stroke-dasharray='1 2'/>");
  ASSERT_EQ(a.warnings.size(), 1u);  // dashes are told apart, for dashes.h to apply
  ASSERT_EQ(a.dashes.size(), 1u);
  EXPECT_EQ(a.strokes.at(0).dash, 0);
  EXPECT_EQ(a.dashes[0].lengths, (std::vector<double>{1, 2}));
  EXPECT_EQ(a.warnings[0], "1 × <image>: pictures are left out: only paths and shapes are read");
  EXPECT_EQ(a.strokes.size(), 1u);
  EXPECT_TRUE(stroked("<line x2='5' y2='5'/>").warnings.empty());
  const Artwork cut = stroked("<path d='M0 0 L 10 0 X 5 5'/>");  // up to the fault, as SVG has it
  EXPECT_NEAR(lines::length(only(cut)), 10, 1e-4);
  ASSERT_EQ(cut.warnings.size(), 1u);
  EXPECT_NE(cut.warnings[0].find("path"), std::string::npos);
}

TEST(Svg, FiltersAndOpacityAreTold) {
  const std::string line = "<path d='M0 9H40V20' fill='none' stroke='black' ";
  const std::string filter = "<filter id='f'><feGaussianBlur stdDeviation='2'/></filter>";
  EXPECT_EQ(
      on_mm_page(filter + "<g opacity='.5'>" + line + "/></g>" + line + "stroke-opacity='.3'/>" +
                 line + "filter='url(#f)'/>" + "<g transform='scale(2)'>" + line + "/></g>")
          .warnings,
      (std::vector<std::string>{
          "1 blurred shapes have no edge: drawn only where something cuts them",
          "2 shapes or groups are partly transparent: their lines are drawn as if they were not"}));
  const std::string shadow = "<filter id='f'><feDropShadow/></filter>";
  EXPECT_EQ(on_mm_page(shadow + line + "filter='url(#f)'/>").warnings,
            (std::vector<std::string>{"1 filters (shadow, light and the like) are passed over"}));
}

// A page with one line of 40 mm and `more`: what is drawn of it [mm], and the one warning.
TEST(Svg, NothingIsLostInSilence) {
  const std::string box = "<path d='M10 10H20V20H10Z' fill='none' stroke='red' ";
  const std::string spared = "1 shapes are drawn that a missing or empty filter would hide";
  const std::string hidden = "1 shapes are left out: hidden, or wholly transparent";
  const std::string lacks = ", which the file does not hold: ";
  const struct {
    std::string more;
    double length;
    std::vector<std::string> warnings;
  } cases[] = {
      {box + "/>", 80, {}},
      {box + "filter='none' style='mask:none'/>", 80, {}},
      {"<filter id='f'/>" + box + "filter='url(#f)'/>", 80, {spared}},
      {"<filter id='f' width='0'><feOffset/></filter>" + box + "style='filter:url(#f)'/>",
       80,
       {spared}},
      {"<style>.a{filter:url(#f)}</style>" + box + "class='a'/>",
       80,
       {"1 × filter refers to '#f'" + lacks + "passed over", spared}},
      {"<clipPath id='c'/>" + box + "clip-path='url(#c)'/>", 40, {hidden}},
      {"<mask id='m'/><g mask='url(#m)'>" + box + "/></g>", 40, {hidden}},
      {box + "mask='url(#m)'/>", 80, {"1 × mask refers to '#m'" + lacks + "passed over"}},
      {"<clipPath id='c'><circle r='9'/></clipPath>" + box + "clip-path='url(#c)'/>",
       40,
       {"40.0 mm of lines are hidden by fills, wide strokes, clip paths, masks or the page's edge: "
        "left out"}},
      {"<use href='#a'/>", 40, {"1 × <use> refers to '#a'" + lacks + "left out"}},
      {"<use xlink:href='b.svg#a'/>", 40, {"1 × <use> refers to 'b.svg#a'" + lacks + "left out"}},
      {"<rect width='9' height='9' fill='url(\"#g\") none'/>",
       40,
       {"1 × fill refers to '#g'" + lacks + "not painted"}},
      {"<rect width='10' height='10' style='fill:url(#g) red'/>", 80, {}},
      {"<linearGradient id='g'/><rect width='9' height='9' fill='url(#g)'/>",
       40,
       {"1 × fill refers to '#g', which is empty: not painted"}},
      {"<text><textPath href='#a'>a</textPath></text>",
       40,
       {"1 × <textPath> refers to '#a'" + lacks + "left out"}},
      {"<pattern id='p' width='.01' height='.01' patternUnits='userSpaceOnUse'><path d='M0 0 L3 3' "
       "stroke='red'/></pattern><rect width='10' height='10' fill='url(#p)'/>",
       80,
       {"1 shapes are painted with a pattern that is too fine, or on a stroke: it counts "
        "as an even tone, or as a line"}},
      {box + "><animate attributeName='x' to='5'/><animateTransform/></path>",
       80,
       {"2 × <animate>: animations are left out: drawn as it is without them"}},
      {"<image width='9' height='9' href='data:image/png;base64,AAAA'/>",
       40,
       {"1 × <image>: pictures are left out: only paths and shapes are read"}},
      {"<style>.h{display:none}</style><g class='h'>" + box + "/></g>", 40, {hidden}},
      {"<g style='display:none'>" + box + "/></g>", 40, {hidden}},
      {box + "opacity='0'/>", 40, {hidden}},
      {box + "visibility='hidden'/>", 40, {hidden}},
      {box + "stroke-opacity='0'/>", 40, {hidden}},
      {"<defs display='none'>" + box + "/></defs><path d='M0 0h9' fill='none'/>", 40, {}},
      {box + "opacity='.3'/>",
       80,
       {"1 shapes or groups are partly transparent: their lines are drawn as if they were not"}},
      {"<style>@import url(a.css);</style>", 40, {"a style sheet outside of the file is not read"}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.more);
    const Artwork a = on_mm_page("<path d='M10 90H50' stroke='red' fill='none'/>" + c.more);
    double length = 0;
    for (const Stroke& s : a.strokes) length += lines::length(s.points);
    EXPECT_NEAR(length, c.length, 1e-3);
    EXPECT_EQ(a.warnings, c.warnings);
  }
}

TEST(Svg, TheInternalDtdCounts) {
  const std::string strokes =
      "<svg width='109' height='109'><g k:element='a'><path k:type='b' d='M11 54h80'/></g></svg>";
  for (const std::string dtd :
       {"<!ATTLIST g xmlns:k CDATA #FIXED 'http://k' k:element CDATA #IMPLIED>",
        "<!ENTITY ns \"http://k\"><!ATTLIST path\n xmlns:k CDATA '&ns;' k:type (a|b) #REQUIRED >",
        "<!-- don't ]> --><?x '?><!ELEMENT g ANY><!ATTLIST g k:element NOTATION (a|b) 'a' xmlns:k "
        "CDATA #FIXED\n\"http://k\">"}) {
    SCOPED_TRACE(dtd);
    const std::string head =
        "<?xml version='1.0'?><!-- it's one -->\n<!DOCTYPE svg PUBLIC '-//W' "
        "'http://d' [";
    const std::string more =
        "<!ATTLIST svg xmlns CDATA #FIXED 'http://www.w3.org/2000/svg'>"
        "<!ATTLIST path stroke CDATA 'black' fill (none|red) 'none'>] >";
    const Artwork a = parse_svg(head + dtd + more + strokes, "dtd");
    EXPECT_NEAR(lines::length(only(a)), 80 * kPx, 1e-4);
    EXPECT_TRUE(a.warnings.empty());
  }
  // Declared nowhere: read, and told.
  const Artwork a = stroked("<line x2='7' sodipodi:type='x'/><use xlink:href='#none'/>");
  EXPECT_NEAR(lines::length(only(a)), 7, 1e-4);
  EXPECT_EQ(a.warnings.at(0), "the prefix 'sodipodi:' has no namespace: read as if it had one");
}

TEST(Svg, AReplacedFontIsNamed) {
  const Artwork a = on_mm_page(
      "<line x2='7' stroke='red'/><text y='50' font-family='No Such Font, sans-serif'>H</text>"
      "<text y='90' font-family='serif'>H</text><text y='150'>H</text>");
  if (a.strokes.size() == 1) GTEST_SKIP() << "no font on this system";
  ASSERT_EQ(a.warnings.size(), 1u);
  EXPECT_TRUE(a.warnings[0].starts_with("the font 'No Such Font' is not installed: replaced by '"));
}

// As Mermaid writes them; draw.io adds a text for who cannot read HTML.
TEST(Svg, LabelsInHtmlAreDrawn) {
  const auto label = [](int height) {
    return fmt::format(
        "<foreignObject x='10' y='10' width='80' height='{}'><div style='line-height:1.5;"
        "text-align:center'><span><p>H &amp; i</p></span></div></foreignObject>",
        height);
  };
  const std::string line = "<path d='M0 90H7' stroke='red'/>";
  const Artwork a = on_mm_page(line + label(24));
  if (a.strokes.size() == 1) GTEST_SKIP() << "no font on this system";
  EXPECT_TRUE(a.warnings.empty());
  Eigen::AlignedBox2d box;
  for (std::size_t i = 1; i < a.strokes.size(); ++i) {
    for (const Vector2d& p : a.strokes[i].points) box.extend(p);
  }
  EXPECT_NEAR(box.center().x(), 50, 1);
  EXPECT_NEAR(box.max().y(), 10 + 3 + 14, 0.5) << "baseline";
  const Artwork wrapped = on_mm_page(line + label(48));
  EXPECT_EQ(wrapped.strokes.size(), 1u);
  EXPECT_EQ(wrapped.warnings,
            (std::vector<std::string>{
                "1 × <foreignObject>: text in HTML that is not one plain label is left out"}));
  const Artwork either =
      on_mm_page(line + "<switch>" + label(48) + "<text x='9' y='50'>H</text></switch>");
  EXPECT_GT(either.strokes.size(), 1u);
  EXPECT_TRUE(either.warnings.empty());
}

TEST(Svg, MarkersAndPatternsAreDrawn) {
  const std::string marker =
      "<marker id='m' markerWidth='5' markerHeight='5' overflow='visible'><path d='M0 0 L5 5 "
      "V9'/></marker>";
  for (const std::string use :
       {"marker-end='url(#m)'", "style='marker:url(#m)'", "style='marker-mid:url(#m) !important'",
        "class='k'", "marker-start='url(#m)' paint-order='fill markers'"}) {
    SCOPED_TRACE(use);
    const std::string style = "<style>.k{marker-start:url(#m)}</style>";
    const Artwork a = on_mm_page(marker + style +
                                 "<path d='M10 10 H50 V50' fill='none' stroke='red' " + use + "/>");
    EXPECT_GE(a.strokes.size(), 2u);
  }
  // Tiles of 3 mm, cut by the square: 3 × 2 diagonals whole, two thirds of two more cut off.
  const Artwork tiles = on_mm_page(
      "<pattern id='p' width='3' height='3' patternUnits='userSpaceOnUse'><path d='M0 0 L3 3' "
      "stroke='red'/></pattern><rect width='10' height='6' fill='url(#p)'/>");
  double length = 0;
  for (const Stroke& stroke : tiles.strokes) length += lines::length(stroke.points);
  EXPECT_NEAR(length, (6 * 3 + 2 * 1) * std::sqrt(2.0), 1e-3);
  // On a rectangle browsers draw no markers.
  EXPECT_EQ(on_mm_page(marker + "<rect x='9' y='9' width='5' height='5' marker-start='url(#m)'/>")
                .strokes.size(),
            1u);
}

TEST(Svg, TextIsDrawnAsOutlines) {
  // The glyphs are the system's: of them only what holds for any font.
  const auto extent = [](const Artwork& a) {
    Eigen::AlignedBox2d box;
    for (const Stroke& s : a.strokes) {
      for (const Vector2d& p : s.points) box.extend(p);
    }
    return box;
  };
  Artwork one = on_mm_page(
      "<line x1='0' y1='199' x2='1' y2='199' stroke='red'/><text x='50' y='100' "
      "font-size='20'>HH</text>");
  if (one.strokes.size() == 1) {
    ASSERT_EQ(one.warnings.size(), 1u);
    EXPECT_NE(one.warnings[0].find("1 texts are left out"), std::string::npos);
    GTEST_SKIP() << "no font on this system";
  }
  one.strokes.erase(one.strokes.begin());
  ASSERT_EQ(one.strokes.size(), 2u);
  EXPECT_NEAR(extent(one).max().y(), 100, 1e-3);  // an H stands on the base line
  EXPECT_GT(extent(one).min().x(), 50);
  EXPECT_GT(extent(one).sizes().y(), 12);
  EXPECT_LT(extent(one).sizes().y(), 17);
  Artwork turned = on_mm_page(
      "<g transform='translate(100 0) rotate(90) scale(.5)'><text x='50' y='100' "
      "font-size='20'>HH</text></g>");
  EXPECT_NEAR(extent(turned).min().x(), 50, 1e-3);
  EXPECT_NEAR(extent(turned).sizes().x(), extent(one).sizes().y() / 2, 1e-3);
  EXPECT_NEAR(extent(turned).sizes().y(), extent(one).sizes().x() / 2, 1e-3);
}

TEST(Svg, TextInSingleStrokes) {
  const auto read = [](const std::string& text, const std::string& font) {
    return parse_svg(
        "<svg xmlns='http://www.w3.org/2000/svg' width='200mm' height='200mm' viewBox='0 0 200 "
        "200'><g transform='translate(20 90) rotate(30)'><text font-size='20'>" +
            text + "</text></g></svg>",
        "a", {.may_be_empty = true, .single_font = font});
  };
  const Artwork outline = read("HHHHH", ""), single = read("HHHHH", "futural");
  if (outline.strokes.empty()) GTEST_SKIP() << "no font on this system";
  EXPECT_EQ(single.strokes.size(), 15u);
  // In the text's own frame, an H is as high as the system's and stands in its place.
  const auto box_of = [](const Artwork& a) {
    const Eigen::Rotation2Dd back(-std::numbers::pi / 6);
    Eigen::AlignedBox2d box;
    for (const Stroke& s : a.strokes)
      for (const Vector2d& p : s.points) box.extend(back * (p - Vector2d(20, 90)));
    return box;
  };
  const Eigen::AlignedBox2d wanted = box_of(outline), got = box_of(single);
  EXPECT_NEAR(got.min().y(), wanted.min().y(), 0.02 * 20);
  EXPECT_NEAR(got.max().y(), wanted.max().y(), 1e-3);
  EXPECT_NEAR(got.min().x(), wanted.min().x(), 0.15 * 20);
  EXPECT_NEAR(got.max().x(), wanted.max().x(), 0.15 * 20);
  const Artwork accents = read("\u00e9e\u0301", "futural");
  EXPECT_EQ(accents.strokes.size() % 2, 0u);
  EXPECT_GT(accents.strokes.size(), 3u);
  const Artwork lacks = read("H\u20bd", "futural");
  EXPECT_EQ(lacks.strokes.size(), 3u);
  EXPECT_THROW(read("H", "no such font"), InputError);
}

TEST(Svg, AColourThatLeapsWithinAGradientIsALine) {
  const auto length = [](const std::string& gradient, const std::string& stops) {
    return pen_down_length(on_mm_page("<" + gradient + " id='g' " + stops + "</" + gradient +
                                      "><rect x='20' y='20' width='40' height='40' "
                                      "fill='url(#g)'/>")
                               .strokes);
  };
  const std::string red = "<stop offset='.5' stop-color='red'/>",
                    blue = "<stop offset='.5' stop-color='blue'/>";
  EXPECT_NEAR(length("linearGradient", ">" + red + blue), 160 + 40, 1e-3);
  EXPECT_NEAR(length("linearGradient", ">" + red + red), 160, 1e-3);
  EXPECT_NEAR(length("radialGradient", "r='.2'>" + red + blue),
              160 + 2 * std::numbers::pi * 0.1 * 40, 0.06);
  EXPECT_NEAR(length("linearGradient", "x2='.25' spreadMethod='repeat'>" +
                                           std::string("<stop stop-color='red'/>") +
                                           "<stop offset='1' stop-color='blue'/>"),
              160 + 3 * 40, 1e-3);
}

TEST(Svg, OtherEncodings) {
  const std::string rest =
      "<svg xmlns='http://www.w3.org/2000/svg'><g id='caf\xe9'><line x2='9' y2='9' "
      "stroke='red'/></g></svg>";
  EXPECT_EQ(parse_svg("<?xml version='1.0' encoding='ISO-8859-1'?>" + rest, "latin").layers,
            std::vector<std::string>{"caf\xc3\xa9"});
  std::string wide = "\xff\xfe";
  for (const char c : rest) wide += {c, '\0'};
  EXPECT_EQ(parse_svg(wide, "utf-16").layers, std::vector<std::string>{"caf\xc3\xa9"});
}

}  // namespace
}  // namespace impedraw
