// Hatching against areas in closed form and a winding number of its own.
#include "impedraw/drawing/hatch.h"

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

std::vector<Vector2d> circle(const Vector2d& centre, double radius, bool reversed = false) {
  std::vector<Vector2d> line;
  for (int i = 0; i < 720; ++i) {
    const double a = (reversed ? -1 : 1) * 2 * std::numbers::pi * i / 720;
    line.push_back(centre + radius * Vector2d(std::cos(a), std::sin(a)));
  }
  return line;
}

// By the sum of the angles under which p sees each side.
int winding(const Vector2d& p, const std::vector<std::vector<Vector2d>>& outlines) {
  double sum = 0;
  for (const auto& outline : outlines) {
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vector2d a = outline[i] - p, b = outline[(i + 1) % outline.size()] - p;
      sum += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    }
  }
  return static_cast<int>(std::lround(sum / (2 * std::numbers::pi)));
}

bool inside(const Vector2d& p, const Area& area) {
  const int w = winding(p, area.outlines);
  return area.even_odd ? w % 2 != 0 : w != 0;
}

double perimeter(const Area& area) {
  double sum = 0;
  for (auto outline : area.outlines) {
    outline.push_back(outline.front());
    sum += lines::length(outline);
  }
  return sum;
}

TEST(Hatch, RingWithAHole) {
  const double area = std::numbers::pi * (40 * 40 - 15 * 15);
  for (const bool even_odd : {true, false}) {
    for (const double angle : {0.0, 45.0, 90.0, 123.0}) {
      for (const double spacing : {0.5, 2.0}) {
        SCOPED_TRACE(fmt::format("{} {} {}", even_odd, angle, spacing));
        const Area ring{
            {circle({70.3, 60.2}, 40), circle({70.3, 60.2}, 15, !even_odd)}, even_odd, 0};
        const std::vector<Stroke> lines =
            hatch_lines(ring, {.spacing_mm = spacing, .angle_deg = angle}, 1);
        EXPECT_NEAR(pen_down_length(lines) * spacing, area, spacing * perimeter(ring));
        EXPECT_NEAR(pen_down_length(lines) * spacing, area, 0.02 * area);
        EXPECT_NEAR(static_cast<double>(lines.size()), (80 + 30) / spacing,
                    3);  // twice where the hole is
        const Vector2d along(std::cos(angle * std::numbers::pi / 180),
                             -std::sin(angle * std::numbers::pi / 180));
        for (const Stroke& line : lines) {
          ASSERT_EQ(line.points.size(), 2u);
          EXPECT_NEAR(std::abs((line.points[1] - line.points[0]).normalized().dot(along)), 1, 1e-6);
          for (const double s : {0.01, 0.3, 0.5, 0.99})
            EXPECT_TRUE(inside(line.points[0] + s * (line.points[1] - line.points[0]), ring));
          for (const Vector2d& end : line.points) {  // on an outline
            const double r = (end - Vector2d(70.3, 60.2)).norm();
            EXPECT_LT(std::min(std::abs(r - 40), std::abs(r - 15)), 1e-3);
          }
        }
      }
    }
  }
}

TEST(Hatch, RandomPolygonsHaveNoLineOutsideAndNoneMissing) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0, 50);
    Area area{{}, seed % 2 == 0, 0};
    for (unsigned k = 0; k < 1 + seed % 3; ++k) {
      area.outlines.emplace_back();
      for (int i = 0; i < 7; ++i)
        area.outlines.back().push_back({any(random), any(random)});  // crosses itself
    }
    const double spacing = 0.7, angle = any(random) * std::numbers::pi / 25;
    const auto lines = hatch_lines(
        area, {.spacing_mm = 2 * spacing, .angle_deg = angle * 180 / std::numbers::pi}, 2);
    for (const Stroke& line : lines) {
      for (const double s : {0.002, 0.37, 0.998})
        EXPECT_TRUE(inside(line.points[0] + s * (line.points[1] - line.points[0]), area));
    }
    // Points of the rows themselves: drawn if and only if inside, but for a hair about the
    // outlines.
    const Vector2d along(std::cos(angle), -std::sin(angle)),
        across(std::sin(angle), std::cos(angle));
    int looked_at = 0;
    for (int i = 0; i < 300; ++i) {
      const Vector2d p(any(random), any(random));
      const Vector2d on_row =
          p + ((std::floor(across.dot(p) / spacing) + 0.5) * spacing - across.dot(p)) * across;
      bool near_outline = false, drawn = false;
      for (auto outline : area.outlines) {
        outline.push_back(outline.front());
        near_outline = near_outline || lines::distance(on_row, outline) < 1e-3;
      }
      for (const Stroke& line : lines) drawn = drawn || lines::distance(on_row, line.points) < 1e-5;
      if (near_outline) continue;
      ++looked_at;
      EXPECT_EQ(drawn, inside(on_row, area)) << on_row.transpose();
    }
    EXPECT_GT(looked_at, 250);
  }
}

TEST(Hatch, RowsAlternateAndCrossesStandAcross) {
  const Area square{{{{0, 0}, {10, 0}, {10, 10}, {0, 10}}}, false, 3};
  const auto lines = hatch_lines(square, {.spacing_mm = 1, .angle_deg = 0}, 1);
  ASSERT_EQ(lines.size(), 10u);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_NEAR(lines[i].points[0].y(), i + 0.5, 1e-6);
    EXPECT_NEAR(lines[i].points[0].x(), i % 2 ? 10 : 0, 1e-6);
    EXPECT_EQ(lines[i].layer, 3);
  }
  EXPECT_NEAR(pen_up_length(lines), 9, 1e-6);  // one spacing from row to row
  const auto crossed = hatch_lines(square, {.spacing_mm = 1, .angle_deg = 0, .cross = true}, 1);
  ASSERT_EQ(crossed.size(), 20u);
  for (std::size_t i = 10; i < 20; ++i)
    EXPECT_NEAR(crossed[i].points[0].x(), crossed[i].points[1].x(), 1e-6);
  EXPECT_TRUE(hatch_lines(square, {}, 1).empty());
  EXPECT_THROW(hatch_lines(square, {.spacing_mm = 1e-6}, 1), InputError);
  EXPECT_THROW(hatch_lines(square, {.spacing_mm = std::nan("")}, 1), InputError);
}

TEST(Hatch, EachPlaceOfABentFrameIsOnePlaceOfThePage) {
  Eigen::AlignedBox2d box(Vector2d(-20, 10), Vector2d(80, 90));
  // It bends, is steep, and falls where x > 60: made to rise there.
  const SurfaceDistances distances = [](const Vector2d& across) {
    return [across](const Vector2d& p) {
      const double y = across.dot(p);
      return p.x() > 60 ? -y : 1.4 * y + 3 * std::sin(0.1 * p.x()) + 2 * std::sin(0.2 * y);
    };
  };
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(0, 1);
  for (const double angle : {0.0, 0.7, 2.0}) {
    const HatchFrame frame(angle, distances, box, 2);
    for (int i = 0; i < 1000; ++i) {
      const Vector2d p = box.min() + box.sizes().cwiseProduct(Vector2d(any(random), any(random)));
      EXPECT_LT((frame.to_page(frame.to_H(p)) - p).norm(), 1e-9);
      if (p.x() > 55) continue;
      const double wanted = distances({std::sin(angle), std::cos(angle)})(p);
      EXPECT_NEAR(frame.to_H(p).y(), wanted, 0.1) << "between samples 2 mm apart";
    }
  }
}

TEST(Hatch, JoinedLinesStayInsideAndLoseNothing) {
  const Area square{{{{20, 20}, {80, 20}, {80, 80}, {20, 80}}}, false, 0};
  const Area ring{{circle({70.3, 60.2}, 40), circle({70.3, 60.2}, 15)}, true, 0};
  Area comb{{{{0, 0}, {60, 0}}}, false, 0};
  for (int i = 5; i >= 0; --i)
    for (const Vector2d& p : {Vector2d(10 * i + 6, 10), Vector2d(10 * i + 6, 40),
                              Vector2d(10 * i, 40), Vector2d(10 * i, 10)})
      comb.outlines[0].push_back(p);
  for (const auto& [area, most] :
       std::vector<std::pair<const Area*, unsigned>>{{&square, 1}, {&ring, 4}, {&comb, 14}}) {
    for (const double angle : {0.0, 45.0, 77.0}) {
      SCOPED_TRACE(fmt::format("{} {}", most, angle));
      const HatchSettings settings{.spacing_mm = 1, .angle_deg = angle};
      const auto lines = hatch_lines(*area, settings, 1),
                 strokes = hatch_strokes(*area, settings, 1);
      EXPECT_LE(strokes.size(), most);
      EXPECT_GT(pen_down_length(strokes),
                pen_down_length(lines) - 0.501 * static_cast<double>(lines.size()));
      std::size_t ends = 0;
      for (const Stroke& stroke : strokes) {
        ends += stroke.points.size();
        for (std::size_t i = 1; i < stroke.points.size(); ++i) {
          for (const double s : {0.001, 0.2, 0.5, 0.8, 0.999})
            EXPECT_TRUE(inside(stroke.points[i - 1] + s * (stroke.points[i] - stroke.points[i - 1]),
                               *area));
        }
      }
      EXPECT_EQ(ends, 2 * lines.size());
    }
  }
}

constexpr HatchStyle kRings[] = {HatchStyle::concentric, HatchStyle::contour_parallel};

TEST(Hatch, RingsOfASquareLieAsFarApartAsAsked) {
  const Area square{{{{20, 20}, {80, 20}, {80, 80}, {20, 80}}}, false, 0};
  const Vector2d middle(50, 50);
  for (const HatchStyle style : kRings) {
    const bool circles = style == HatchStyle::concentric;
    const HatchSettings settings{.spacing_mm = 2, .style = style};
    const auto lines = hatch_lines(square, settings, 2),
               strokes = hatch_strokes(square, settings, 2);
    EXPECT_NEAR(pen_down_length(lines), 3600, 5);
    EXPECT_LE(strokes.size(), circles ? 4u : 1u);  // the corners' arcs are apart
    EXPECT_NEAR(pen_down_length(strokes), 3600, circles ? 500 : 50) << "with what joins them";
    for (const Stroke& line : lines) {
      for (const Vector2d& p : line.points) {
        const Vector2d from = (p - middle).cwiseAbs();
        const double distance = circles ? from.norm() : 30 - from.maxCoeff();
        const double row = distance - 0.5;
        const bool on_outline = circles && from.maxCoeff() > 30 - 1e-6;
        EXPECT_TRUE(std::abs(row - std::round(row)) < 2e-3 || on_outline) << p.transpose();
      }
    }
  }
  EXPECT_THROW(hatch_lines(square, {.spacing_mm = 2, .style = kRings[0], .cross = true}, 1),
               InputError);
  for (const HatchStyle style : kRings)
    EXPECT_THROW(hatch_lines(square, {.spacing_mm = 1e-5, .style = style}, 1), InputError);
}

TEST(Hatch, RingsOfRandomPolygonsStayInsideAndLeaveNoGap) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    for (const HatchStyle style : kRings) {
      SCOPED_TRACE(fmt::format("{} {}", seed, static_cast<int>(style)));
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> any(0, 50);
      Area area{{}, seed % 2 == 0, 0};
      for (unsigned k = 0; k < 1 + seed % 3; ++k) {
        area.outlines.emplace_back();
        for (int i = 0; i < 7; ++i) area.outlines.back().push_back({any(random), any(random)});
      }
      const HatchSettings settings{.spacing_mm = 1.4, .style = style};
      const auto lines = hatch_lines(area, settings, 2), strokes = hatch_strokes(area, settings, 2);
      EXPECT_LT(strokes.size(), lines.size());
      const auto near_outline = [&](const Vector2d& p, double hair) {
        for (auto outline : area.outlines) {
          outline.push_back(outline.front());
          if (lines::distance(p, outline) < hair) return true;
        }
        return false;
      };
      for (const std::vector<Stroke>* drawn : {&lines, &strokes})
        for (const Stroke& line : *drawn)
          for (std::size_t i = 1; i < line.points.size(); i += 5) {
            const Vector2d p = (line.points[i] + line.points[i - 1]) / 2;
            EXPECT_TRUE(inside(p, area) || near_outline(p, 1e-3)) << p.transpose();
          }
      for (int i = 0; i < 200; ++i) {
        const Vector2d p(any(random), any(random));
        if (!inside(p, area) || near_outline(p, 1.5)) continue;
        double nearest = INFINITY;
        for (const Stroke& line : lines)
          nearest = std::min(nearest, lines::distance(p, line.points));
        // Insets end within a spacing of where those from all sides meet.
        EXPECT_LT(nearest, style == HatchStyle::concentric ? 0.36 : 1.05) << p.transpose();
      }
    }
  }
}

// Length of the lines whose middle lies in the box, times the spacing.
double inked(const std::vector<Stroke>& lines, const Eigen::AlignedBox2d& box) {
  double sum = 0;
  for (const Stroke& line : lines) {
    for (std::size_t i = 1; i < line.points.size(); ++i) {
      const Vector2d a = line.points[i - 1], way = line.points[i] - a;
      for (int k = 0; k < 100; ++k)
        if (box.contains(a + (k + 0.5) / 100 * way)) sum += way.norm() / 100;
    }
  }
  return sum;
}

TEST(Hatch, ATintHasWiderLinesAndAGradientFewer) {
  const auto length_of = [](const std::string& fills) {
    const std::string svg = fmt::format(
        R"(<svg xmlns="http://www.w3.org/2000/svg" width="200mm" viewBox="0 0 200 100">{}</svg>)",
        fills);
    std::vector<double> lengths;
    for (const Area& area : parse_svg(svg, "tints").areas)
      lengths.push_back(pen_down_length(hatch_lines(area, {.spacing_mm = 1}, 1)));
    return lengths;
  };
  const auto rect = [](int x, const std::string& fill) {
    return fmt::format("<rect x='{}' y='10' width='40' height='40' {}/>", x, fill);
  };
  const auto expect_lengths = [&](const std::string& fills, std::vector<double> tones) {
    const std::vector<double> lengths = length_of(fills);
    ASSERT_EQ(lengths.size(), tones.size()) << fills;
    for (std::size_t i = 0; i < tones.size(); ++i)
      EXPECT_NEAR(lengths[i], 1600 * tones[i], 40) << fills << " " << i;
  };
  expect_lengths(rect(10, "fill='#000'") + rect(60, "fill='#808080'") + rect(110, "fill='#c0c0c0'"),
                 {1, 0.498, 0.247});
  expect_lengths(rect(10, "fill='#f00'") + rect(60, "fill='#ff8080'"), {1, 0.498});
  expect_lengths(rect(10, "fill='#808080'"), {0.498});
  expect_lengths(rect(10, "fill='#123'") + rect(60, "fill='#f00'"), {1, 1});
  expect_lengths(rect(10, "fill='#000' fill-opacity='0.6'"), {0.6});
  expect_lengths("<g opacity='0.6'>" + rect(10, "fill='#000' fill-opacity='0.5'") + "</g>", {0.3});

  // A pattern of too many tiles: a disc and a bar cover 0.2827 + 0.2 of each.
  expect_lengths(
      "<pattern id='p' width='.1' height='.1' patternUnits='userSpaceOnUse'>"
      "<circle cx='.05' cy='.05' r='.03'/><path d='M0 .09h.1' stroke='#000' "
      "stroke-width='.02'/></pattern>" +
          rect(10, "fill='url(#p)'"),
      {0.4827});

  // From black at the left to white at the right.
  const auto gradient = [&](const std::string& kind, const std::string& stops) {
    const Artwork artwork = parse_svg(
        fmt::format(
            R"svg(<svg xmlns="http://www.w3.org/2000/svg" width="200mm" viewBox="0 0 200 100">
            <{0} id="g">{1}</{0}><rect x="10" y="10" width="160" height="80" fill="url(#g)"/>
            </svg>)svg",
            kind, stops),
        "gradient");
    EXPECT_EQ(artwork.areas.size(), 1u);
    return artwork.areas.at(0);
  };
  const std::string stops = "<stop stop-color='black'/><stop offset='1' stop-color='white'/>";
  for (const HatchStyle style :
       {HatchStyle::boustrophedon, HatchStyle::concentric, HatchStyle::contour_parallel}) {
    SCOPED_TRACE(static_cast<int>(style));
    const auto lines = hatch_lines(gradient("linearGradient", stops),
                                   {.spacing_mm = 0.5, .style = style, .angle_deg = 30}, 1);
    for (int i = 0; i < 8; ++i) {
      const Eigen::AlignedBox2d part(Vector2d(10 + 20 * i, 10), Vector2d(30 + 20 * i, 90));
      EXPECT_NEAR(0.5 * inked(lines, part) / 1600, 1 - (i + 0.5) / 8, 0.04) << i;
    }
  }
  const auto strokes = hatch_strokes(gradient("linearGradient", stops), {.spacing_mm = 0.5}, 1);
  EXPECT_LT(strokes.size(), 250u);  // of 330 rows, each cut once
}

TEST(Hatch, FillsOfAnSvg) {
  const std::string svg =
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100">
    <rect width="100" height="100" fill="white"/>
    <g id="a"><path d="M10 10h40v40h-40z M20 20h20v20h-20z" FILL/></g>
    <g id="b"><path d="M60 60h30v30h-30z" fill="none" stroke="red"/>
      <circle cx="75" cy="20" r="10" fill="red" stroke="black"/></g></svg>)";
  const auto with = [&](const std::string& fill) {
    std::string text = svg;
    text.replace(text.find("FILL"), 4, fill);
    return parse_svg(text, "fills");
  };
  const Artwork nonzero = with("fill='#123'"), even_odd = with("fill='#123' fill-rule='evenodd'");
  ASSERT_EQ(nonzero.areas.size(), 2u);  // neither the white page nor what is stroked alone
  EXPECT_FALSE(nonzero.areas[0].even_odd);
  EXPECT_TRUE(even_odd.areas[0].even_odd);
  EXPECT_EQ(nonzero.layers[nonzero.areas[0].layer], "a");
  EXPECT_EQ(nonzero.layers[nonzero.areas[1].layer], "b");
  // The white page is not drawn as a frame; the inner square is not seen within its own colour.
  EXPECT_EQ(nonzero.strokes.size(), 3u);
  EXPECT_EQ(even_odd.strokes.size(), 4u);
  const auto length = [](const Area& area) {
    return pen_down_length(hatch_lines(area, {.spacing_mm = 1, .angle_deg = 30}, 2)) / 2;
  };
  EXPECT_NEAR(length(nonzero.areas[0]), 1600, 20);
  EXPECT_NEAR(length(even_odd.areas[0]), 1200, 20);
  EXPECT_NEAR(length(even_odd.areas[1]), 100 * std::numbers::pi, 10);

  // Lines stand behind their layer's strokes; without outlines what is stroked stays, and the white
  // page's layer is gone.
  Artwork hatched = even_odd;
  apply_hatch(hatched, {.spacing_mm = 5}, 1);
  for (std::size_t i = 1; i < hatched.strokes.size(); ++i)
    EXPECT_LE(hatched.strokes[i - 1].layer, hatched.strokes[i].layer);
  EXPECT_EQ(hatched.layers.size(), 2u);
  hatched = even_odd;
  apply_hatch(hatched, {.spacing_mm = 5, .outline = false}, 1);
  EXPECT_EQ(hatched.layers, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(std::count_if(hatched.strokes.begin(), hatched.strokes.end(),
                          [](const Stroke& s) { return s.closed; }),
            2);
}

}  // namespace
}  // namespace impedraw
