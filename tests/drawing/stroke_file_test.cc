#include "impedraw/drawing/stroke_file.h"

#include <filesystem>
#include <fstream>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/artwork_file.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Lines = std::vector<std::vector<Vector2d>>;

Lines lines_of(const Artwork& artwork) {
  Lines lines;
  for (const Stroke& stroke : artwork.strokes) lines.push_back(stroke.points);
  return lines;
}
Lines read(const std::string& text, bool csv = false) {
  return lines_of(parse_strokes(text, "a", csv));
}

std::string message(const std::string& text, bool csv = false) {
  try {
    parse_strokes(text, "a", csv);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(StrokeFile, LinesDotsAndClosedStrokes) {
  const Artwork a = parse_strokes(
      "200 150\n10 20\n30.5 20\nEnd\n# a dot\n50\t60\nEND\n\n0 0\n9 0\n9 9\n0 0\nend\n", "a",
      false);
  EXPECT_EQ(lines_of(a),
            (Lines{{{10, 20}, {30.5, 20}}, {{50, 60}}, {{0, 0}, {9, 0}, {9, 9}, {0, 0}}}));
  EXPECT_EQ(a.page.max(), Vector2d(200, 150));
  EXPECT_FALSE(a.strokes[0].closed || a.strokes[1].closed);
  EXPECT_TRUE(a.strokes[2].closed);
  EXPECT_EQ(a.layers.size(), 1u);
  EXPECT_TRUE(a.warnings.empty());
  EXPECT_EQ(read("9 9\n1 2\n1 2\n3 4\n3 4\nEnd"),
            (Lines{{{1, 2}, {3, 4}}}));  // consecutive points differ
  EXPECT_EQ(read("9 9\n5 5\n5 5\nEnd"), (Lines{{{5, 5}}}));
}

TEST(StrokeFile, WhatIsWrittenIsRead) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-300, 300);
    Lines lines(1 + random() % 8);
    std::string text = "200 100\r\n", commas = "200,100\n", blank_rows, columns = "y;stroke;x\n";
    for (std::size_t i = 0; i < lines.size(); ++i) {
      for (unsigned k = 0; k <= random() % 9; ++k) lines[i].emplace_back(any(random), any(random));
      for (const Vector2d& p : lines[i]) {
        text += fmt::format("{} {}\r\n", p.x(), p.y());
        commas += fmt::format("{}, {}\n", p.x(), p.y());
        blank_rows += fmt::format("{},{}\n", p.x(), p.y());
        columns += fmt::format("{};{};{}\n", p.y(), i, p.x());
      }
      text += "End\r\n";
      commas += "End\n";
      blank_rows += "\n";
    }
    EXPECT_EQ(read(text), lines);
    EXPECT_EQ(read(commas, true), lines);
    EXPECT_EQ(read(blank_rows, true), lines);
    EXPECT_EQ(read("x,y\n" + blank_rows, true), lines);
    EXPECT_EQ(read(columns, true), lines);
  }
}

TEST(StrokeFile, SharesOfThePage) {
  const Artwork a = parse_strokes("480 440\n0.25 0.5\n1 0\nEnd", "a", false);
  EXPECT_EQ(lines_of(a), (Lines{{{120, 220}, {480, 0}}}));
  EXPECT_EQ(
      a.warnings,
      (std::vector<std::string>{
          "all coordinates lie between 0 and 1: taken as fractions of the page, 480 × 440 mm"}));
  EXPECT_EQ(read("480 440\n0.25 0.5\n1.5 0\nEnd"), (Lines{{{0.25, 0.5}, {1.5, 0}}}));
  EXPECT_EQ(read("1 1\n0.25 0.5\n1 0\nEnd"), (Lines{{{0.25, 0.5}, {1, 0}}}));
}

TEST(StrokeFile, FaultsNameTheirLine) {
  EXPECT_EQ(message(""), "a: line 0: the file ends before the page's width and height");
  EXPECT_EQ(message("hello\n"),
            "a: line 1: must hold the page's width and height, two numbers, and perhaps 'width' or "
            "'force'");
  EXPECT_EQ(message("0 10\n"),
            "a: line 1: the page is 0 × 10 mm; both must be > 0 and at most 1e+06");
  EXPECT_EQ(message("End\n"), "a: line 1: End before the page's width and height");
  EXPECT_EQ(message("9 9\n1 2\n3 x\nEnd"), "a: line 3: '3 x' where 2 numbers or End must be");
  EXPECT_EQ(message("9 9\n\n1 2 3\n"), "a: line 3: '1 2 3' where 2 numbers or End must be");
  EXPECT_EQ(message("9 9\n1\n"), "a: line 2: '1' where 2 numbers or End must be");
  EXPECT_EQ(message("9 9\nnan 1\n"), "a: line 2: nan is not within ± 1e+06 mm");
  EXPECT_EQ(message("9 9\n1 -inf\n"), "a: line 2: -inf is not within ± 1e+06 mm");
  EXPECT_EQ(message("9 9\n1 2e6\n"), "a: line 2: 2e6 is not within ± 1e+06 mm");
  EXPECT_EQ(message("a,b\n1,2\n", true),
            "a: line 1: the header names no columns x and y (and perhaps stroke)");
  EXPECT_NE(message("x;y;Z\n1;2;3\n", true).find("a point cloud, not strokes"), std::string::npos);
  EXPECT_NE(message("1,2,3\n4,5,6\n", true).find("a point cloud, not strokes"), std::string::npos);
  EXPECT_EQ(message("x,y,z,stroke\n1,2,3,a\n4,5,6,a\n", true), "accepted");
  EXPECT_EQ(message("x,y\n1,,2\n", true), "a: line 2: '1,,2' where 2 numbers or End must be");
  EXPECT_EQ(message("9 9\nEnd\n"), "a: there is no stroke in it");
  EXPECT_EQ(message(std::string("9 9\n1\0 2", 8)), "a: not a text file of strokes");
  const Artwork cut = parse_strokes("9 9\n1 2\nEnd\n3 4\n5 6\n", "a", false);
  EXPECT_EQ(cut.strokes.size(), 2u);
  EXPECT_EQ(cut.warnings, (std::vector<std::string>{
                              "the last stroke has no End: the file may be cut off after line 5"}));
}

TEST(ArtworkFile, TheExtensionChooses) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / "impedraw_artwork_file";
  std::filesystem::create_directories(folder);
  const auto file = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    return folder / name;
  };
  EXPECT_EQ(lines_of(read_artwork(file("a.TXT", "9 9\n1 2\n3 4\nEnd\n"))),
            (Lines{{{1, 2}, {3, 4}}}));
  EXPECT_EQ(lines_of(read_artwork(file("a.strokes", "9 9\n1 2\n3 4\nEnd\n"))),
            (Lines{{{1, 2}, {3, 4}}}));
  EXPECT_EQ(lines_of(read_artwork(file("a.csv", "x,y\n1,2\n3,4\n"))), (Lines{{{1, 2}, {3, 4}}}));
  EXPECT_EQ(
      read_artwork(file("a.svg", "<svg xmlns='http://www.w3.org/2000/svg'><circle r='9'/></svg>"))
          .strokes.size(),
      1u);
  EXPECT_THROW(read_artwork(file("a.png", "9 9\n1 2\n3 4\nEnd\n")), InputError);
  EXPECT_THROW(read_artwork(folder / "missing.txt"), InputError);
  EXPECT_THROW(read_artwork(folder / "a.svg", {}, PageUnit::cm), InputError);
  EXPECT_EQ(lines_of(read_artwork(folder / "a.csv", {}, PageUnit::cm)),
            (Lines{{{10, 20}, {30, 40}}}));
  std::filesystem::remove_all(folder);
}

TEST(StrokeFile, UnitsOfItsNumbers) {
  const auto read = [](PageUnit unit, const std::string& text) {
    return parse_strokes(text, "a", false, {.unit = unit});
  };
  for (const auto& [unit, mm] : {std::pair(PageUnit::file, 1.0),
                                 {PageUnit::mm, 1.0},
                                 {PageUnit::cm, 10.0},
                                 {PageUnit::in, 25.4},
                                 {PageUnit::m, 1000.0},
                                 {PageUnit::px, 25.4 / 96}}) {
    SCOPED_TRACE(mm);
    const Artwork a = read(unit, "20 10\n1 2\n4 6\nEnd\n");
    EXPECT_LT((a.page.max() - mm * Eigen::Vector2d(20, 10)).norm(), 1e-9);
    EXPECT_LT((a.strokes.at(0).points.back() - mm * Eigen::Vector2d(4, 6)).norm(), 1e-9);
  }
  // Metres within 1 are metres, not shares, once that is said.
  EXPECT_EQ(read(PageUnit::m, "2 2\n.1 .2\n.3 .4\nEnd\n").strokes.at(0).points.at(0),
            Eigen::Vector2d(100, 200));
  EXPECT_EQ(read(PageUnit::file, "2 2\n.1 .2\n.3 .4\nEnd\n").strokes.at(0).points.at(0),
            Eigen::Vector2d(.2, .4));
  EXPECT_THROW(read(PageUnit::m, "2 2\n1 1001\nEnd\n"), InputError);  // beyond 1e6 mm
}

TEST(StrokeFile, WidthsAndForcesOfItsPoints) {
  const auto read = [](const std::string& text, bool csv, PageUnit unit = PageUnit::file) {
    return parse_strokes(text, "a", csv, {.unit = unit}).strokes.at(0);
  };
  using Press = std::vector<double>;
  const Stroke csv = read("x,y,stroke,width\n1,2,0,.5\n3,4,0,2\n3,4,0,9\n", true, PageUnit::cm);
  EXPECT_EQ(csv.press, (Press{5, 20}));
  EXPECT_FALSE(csv.by_force);
  const Stroke page = read("100 50 Force\n10 20 1.5\n30 40 8\nEnd\n", false, PageUnit::cm);
  EXPECT_EQ(page.press, (Press{1.5, 8}));
  EXPECT_TRUE(page.by_force);
  // Shares of the page: the width stays.
  const Stroke share = read("100 50 width\n.1 .2 1.5\n.3 .4 8\nEnd\n", false);
  EXPECT_EQ(share.press, (Press{1.5, 8}));
  EXPECT_EQ(share.points.at(0), Eigen::Vector2d(10, 10));
  EXPECT_TRUE(read("100 50\n10 20\n30 40\nEnd\n", false).press.empty());
  for (const auto& [text, is_csv] : {std::pair("x,y,width,force\n1,2,3,4\n", true),
                                     {"x,y,force\n1,2,-1\n", true},
                                     {"x,y,width\n1,2,nan\n", true},
                                     {"x,y,width\n1,2\n", true},
                                     {"10 20 widths\n1 2 3\nEnd\n", false},
                                     {"10 20 width\n1 2\nEnd\n", false}})
    EXPECT_THROW(read(text, is_csv), InputError) << text;
}

TEST(StrokeFile, TooManyPointsAreNamed) {
  std::string text;
  for (int i = 0; i < 5'000'001; ++i) text += i % 2 ? "1,1\n" : "1,2\n";
  try {
    parse_strokes(text, "a.csv", true, {});
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "a.csv: line 5000001: more than 5000000 points");
  }
}

}  // namespace
}  // namespace impedraw
