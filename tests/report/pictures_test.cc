// Pictures: geometry in closed form, and that what must be seen is there.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <regex>
#include <sstream>

#include <cairo.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/canvas/built_in.h"
#include "impedraw/report/picture.h"
#include "impedraw/report/relief.h"
#include "impedraw/report/sheet.h"
#include "log/made_up_folder.h"

namespace impedraw {
namespace {

using testing::text_of;

using PicturesTest = testing::MadeUpFolder;

Eigen::Vector3d from_above(const Eigen::Vector3d& p) {
  return {-1e3 * p.y(), -1e3 * p.x(), 1e3 * p.z()};
}

// The first place in the SVG at which a stroke is so wide: a style by Cairo 1.16, an attribute by
// 1.18.
std::size_t place_of_width(const std::string& svg, const std::string& width) {
  const std::regex stroke("stroke-width(:" + width + ";|=\"" + width + "\")");
  std::smatch found;
  return std::regex_search(svg, found, stroke) ? static_cast<std::size_t>(found.position())
                                               : std::string::npos;
}

TEST(Relief, OfTheBowlIsTheSphere) {
  const TriangleMesh bowl = make_bowl({.edge = 0.003});
  const Relief r = make_relief(bowl.vertices, bowl.triangles, from_above, 200);
  ASSERT_EQ(r.columns, 200);
  int inside = 0;
  for (int i = 0; i < r.rows; ++i) {
    for (int j = 0; j < r.columns; ++j) {
      const double u = r.area.min().x() + (j + 0.5) * r.area.sizes().x() / r.columns;
      const double v = r.area.min().y() + (i + 0.5) * r.area.sizes().y() / r.rows;
      const double radius = std::hypot(u, v + 600.0);
      if (radius > 180.1) {
        EXPECT_TRUE(std::isnan(r.height(i, j)));
      } else if (radius < 179.0) {
        ++inside;
        ASSERT_NEAR(r.height(i, j), 400.0 - std::sqrt(90000.0 - radius * radius), 0.02)
            << u << " " << v;
        EXPECT_GE(r.shade(i, j), 0.0);
        EXPECT_LE(r.shade(i, j), 1.0);
      }
    }
  }
  EXPECT_NEAR(inside, std::numbers::pi / 4 * 200 * 200, 700);
  EXPECT_EQ(r.contour_step, 10.0);
  ASSERT_EQ(r.contours.size(), 5u);  // 110 … 150 mm; the pole is at 100, the rim at 160
  for (const Relief::Line& line : r.contours) {
    EXPECT_NEAR((line.front() - line.back()).norm(), 0.0, 1e-12) << "a closed ring";
    const double radius = (line[0] - Eigen::Vector2d(0, -600)).norm();
    const double height = 400.0 - std::sqrt(90000.0 - radius * radius);
    EXPECT_NEAR(height, 10.0 * std::round(height / 10.0), 0.1);
    for (const Eigen::Vector2d& p : line)
      EXPECT_NEAR((p - Eigen::Vector2d(0, -600)).norm(), radius, 0.3);
  }
  ASSERT_EQ(r.outline.size(), 1u);
  for (const Eigen::Vector2d& p : r.outline[0])
    EXPECT_NEAR((p - Eigen::Vector2d(0, -600)).norm(), 180.0, 1e-6);
}

// A ball of 100 mm radius: whole, with a hole on top, and with the hole beneath.
TEST(Relief, BodiesAreShadedWholeAndTheirHolesMarked) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> whole, open;
  constexpr int kRound = 48, kUp = 24;
  for (int i = 0; i <= kUp; ++i)
    for (int j = 0; j < kRound; ++j) {
      const double up = std::numbers::pi * i / kUp, round = 2 * std::numbers::pi * j / kRound;
      vertices.push_back(0.1 * Eigen::Vector3d(std::sin(up) * std::cos(round),
                                               std::sin(up) * std::sin(round), std::cos(up)));
    }
  for (int i = 0; i < kUp; ++i)
    for (int j = 0; j < kRound; ++j) {
      const auto at = [](int up, int round) {  // each pole is one vertex
        return kRound * up + (up == 0 || up == kUp ? 0 : round % kRound);
      };
      const int a = at(i, j), b = at(i, j + 1), c = at(i + 1, j), d = at(i + 1, j + 1);
      for (const Eigen::Vector3i& t : {Eigen::Vector3i(a, c, d), Eigen::Vector3i(a, d, b)}) {
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        whole.push_back(t);
        if (i >= 4) open.push_back(t);  // without its cap: within 50 mm of the axis
      }
    }
  const auto seen = [](double side) {
    return [side](const Eigen::Vector3d& p) -> Eigen::Vector3d {
      return {-1e3 * side * p.y(), -1e3 * p.x(), 1e3 * side * p.z()};
    };
  };
  const auto shown = [](const Relief& r) { return r.height.array().isFinite().count(); };
  const Relief ball = make_relief(vertices, whole, seen(1.0)),
               top = make_relief(vertices, open, seen(1.0)),
               beneath = make_relief(vertices, open, seen(-1.0));
  for (const Relief* r : {&ball, &top, &beneath}) {
    EXPECT_FALSE(r->is_sheet);
    EXPECT_NEAR(shown(*r), std::numbers::pi / 4 * 400 * 400, 0.02 * 400 * 400);
  }
  EXPECT_EQ(ball.inside.count(), 0);
  EXPECT_EQ(beneath.inside.count(), 0);
  EXPECT_NEAR(top.inside.count(), std::numbers::pi / 4 * 200 * 200, 0.05 * 200 * 200);
  EXPECT_EQ(beneath.outline.size(), 1u);
  EXPECT_TRUE(beneath.seen_outline.empty()) << "the body hides its hole";
  EXPECT_EQ(top.seen_outline.size(), 1u);
}

TEST(Envelope, KeepsEveryPeak) {
  std::vector<double> t, v;
  for (int i = 0; i < 100000; ++i) {
    t.push_back(1e-3 * i);
    v.push_back(i == 31234 ? 50.0 : i == 77777 ? -40.0 : std::sin(0.001 * i));
  }
  std::fill(v.begin() + 50000, v.begin() + 60000, LogRow::kNone);
  const auto at = [&](std::size_t i) { return v[i]; };
  const Envelope e = envelope(t, at, 2000);
  EXPECT_LE(e.t.size(), 2000u);
  EXPECT_TRUE(std::is_sorted(e.t.begin(), e.t.end()));
  const auto high = std::find(e.v.begin(), e.v.end(), 50.0),
             low = std::find(e.v.begin(), e.v.end(), -40.0);
  ASSERT_NE(high, e.v.end());
  ASSERT_NE(low, e.v.end());
  EXPECT_EQ(e.t[high - e.v.begin()], t[31234]);
  EXPECT_EQ(e.t[low - e.v.begin()], t[77777]);
  for (std::size_t i = 0; i < e.t.size(); ++i)
    EXPECT_EQ(std::isnan(e.v[i]), e.t[i] >= 50.0 && e.t[i] < 60.0) << e.t[i];
  EXPECT_EQ(envelope(std::span(t).first(1000), at, 2000).v.size(), 1000u);
}

// Pixels near a colour.
int count(const std::filesystem::path& png, int red, int green, int blue) {
  cairo_surface_t* image = cairo_image_surface_create_from_png(png.c_str());
  EXPECT_EQ(cairo_surface_status(image), CAIRO_STATUS_SUCCESS);
  int found = 0;
  for (int i = 0; i < cairo_image_surface_get_height(image); ++i) {
    const unsigned char* p =
        cairo_image_surface_get_data(image) + i * cairo_image_surface_get_stride(image);
    for (int j = 0; j < cairo_image_surface_get_width(image); ++j, p += 4) {
      found += std::abs(p[2] - red) < 6 && std::abs(p[1] - green) < 6 && std::abs(p[0] - blue) < 6;
    }
  }
  cairo_surface_destroy(image);
  return found;
}

// Dashes of what was left out are there, and widen the picture.
TEST_F(PicturesTest, WhatWasLeftOutIsSeen) {
  const RunData run = made_up({.time_step = 5e-3}, folder_);
  const auto dashes = [&](const PictureSettings& settings) {
    ink_top(run, match_ink(run), settings).write(folder_ / "ink_top");
    return count(folder_ / "ink_top.png", 0, 133, 107);
  };
  EXPECT_EQ(dashes({}), 0);
  PictureSettings settings;
  settings.left_out = {{{0.55, -0.1, 0.2}, {0.55, 0.1, 0.2}}};
  EXPECT_GT(dashes(settings), 300);
}

TEST_F(PicturesTest, InkFarOffAndInkInTheAirHaveTheirOwnColours) {
  RunData run = made_up({.time_step = 5e-3}, folder_);
  const auto colours = [&] {
    ink_top(run, match_ink(run)).write(folder_ / "ink_top");
    const auto png = folder_ / "ink_top.png";
    return std::array{count(png, 250, 184, 97), count(png, 23, 61, 133), count(png, 214, 26, 31),
                      count(png, 158, 33, 168)};
  };
  const auto [target, ink, none_far, none_stray] = colours();
  EXPECT_GT(target, 500);
  EXPECT_GT(ink, 500);
  EXPECT_EQ(none_far, 0);
  EXPECT_EQ(none_stray, 0);
  // 50 rows 2 mm off, and a line drawn long before the stroke begins.
  std::size_t first = 0;
  while (run.stroke[first] < 0) ++first;
  for (std::size_t i = first + 500; i < first + 550; ++i) run.contact_point[i].x() += 2e-3;
  for (std::size_t i = 0; i < 100; ++i) {
    run.contact_point[i] = {0.60 + 4e-4 * static_cast<double>(i), 0.0, 0.1};
    run.f[i] = 5.0;
  }
  const auto [target_now, ink_now, far, stray] = colours();
  EXPECT_GT(far, 50);
  EXPECT_GT(stray, 50);
}

// Pixels of ink across the line grow as the force does, and the legend says so.
TEST_F(PicturesTest, InkIsAsWideAsThePenIsPressed) {
  RunData run = made_up({.force_noise = 0.0, .time_step = 5e-3}, folder_);
  std::size_t begin = 0;
  while (run.stroke[begin] < 0) ++begin;
  run.target_points.clear();
  run.target_stroke.clear();
  const auto pixels = [&](double f, const PenSettings& pen) {
    for (std::size_t i = begin; i < run.rows(); ++i) run.f[i] = run.stroke[i] >= 0 ? f : 0.0;
    for (std::size_t i = 0; i < begin; ++i) run.f[i] = 0.0;
    ink_page(run, match_ink(run),
             [](const Eigen::Vector3d& p) -> Eigen::Vector2d { return 1e3 * p.head<2>(); }, {},
             {.title = " ", .pen = pen})
        .write(folder_ / "ink_page");
    return count(folder_ / "ink_page.png", 23, 61, 133);
  };
  const PenSettings pressed{.width = 1.5, .width_per_newton = 0.5, .nominal_force = 5.0};
  const double nominal = pixels(5.0, pressed);
  EXPECT_NEAR(nominal, pixels(5.0, {.width = 1.5}), 0.02 * nominal);
  EXPECT_NEAR(pixels(7.0, pressed), nominal * 2.5 / 1.5,
              0.12 * nominal);  // edges are blended: a pixel or so a side
  EXPECT_NEAR(pixels(20.0, pressed), nominal * 3.0,
              0.25 * nominal);  // three times as wide, no more
  EXPECT_NEAR(pixels(7.0, {.width = 1.5}), nominal, 0.02 * nominal);
  // Half the line pressed harder: both widths are in the SVG.
  for (std::size_t i = 0; i < run.rows(); ++i)
    run.f[i] = run.stroke[i] < 0 ? 0.0 : i % 2000 < 1000 ? 5.0 : 7.0;
  ink_page(run, match_ink(run),
           [](const Eigen::Vector3d& p) -> Eigen::Vector2d { return 1e3 * p.head<2>(); }, {},
           {.pen = pressed})
      .write(folder_ / "ink_page");
  const std::string svg = text_of(folder_ / "ink_page.svg");
  EXPECT_NE(place_of_width(svg, "1\\.5"), std::string::npos);
  EXPECT_NE(place_of_width(svg, "2\\.4[0-9]*"), std::string::npos);  // 2.5 mm in steps of 0.075 mm
}

TEST_F(PicturesTest, SvgIsInTrueMillimetres) {
  const RunData run = made_up({.time_step = 5e-3}, folder_);
  const auto to_page = [](const Eigen::Vector3d& p) {
    return Eigen::Vector2d(-1e3 * p.y(), 1e3 * (0.6 - p.x()));
  };
  ink_page(run, match_ink(run), to_page, {}).write(folder_ / "ink_page");
  const std::string svg = text_of(folder_ / "ink_page.svg");
  std::smatch size;
  const std::regex head(
      R"re(width="([0-9.]+)mm" height="([0-9.]+)mm" viewBox="0 0 ([0-9.]+) ([0-9.]+)")re");
  ASSERT_TRUE(std::regex_search(svg, size, head));
  EXPECT_EQ(size[1], size[3]);
  EXPECT_EQ(size[2], size[4]);
  // The target's band, from the sine's first point (X 150) to its last (X −150).
  const auto style = place_of_width(svg, "2\\.6"), begin = svg.find("d=\"M ", style),
             end = svg.find('"', begin + 3);
  ASSERT_NE(style, std::string::npos);
  std::istringstream path(svg.substr(begin + 3, end - begin - 3));
  std::vector<Eigen::Vector2d> points;
  for (std::string letter; path >> letter;) path >> points.emplace_back().x() >> points.back().y();
  ASSERT_GT(points.size(), 50u);
  EXPECT_NEAR(points.front().x() - points.back().x(), 300.0, 0.01);
  EXPECT_NEAR(points.front().y() - points.back().y(), 0.0, 0.01);
  const auto [low, high] = std::minmax_element(
      points.begin(), points.end(), [](const auto& p, const auto& q) { return p.y() < q.y(); });
  EXPECT_NEAR(high->y() - low->y(), 100.0, 0.02);
}

TEST_F(PicturesTest, AFolderThatIsNotThereIsNamed) {
  const RunData run = made_up({.time_step = 0.02}, folder_);
  try {
    ink_top(run, match_ink(run)).write(folder_ / "none" / "ink_top");
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("none/ink_top.svg"));
  }
}

}  // namespace
}  // namespace impedraw
