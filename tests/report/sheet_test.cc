// Ticks of an axis, whatever its range.
#include "impedraw/report/sheet.h"
#include "impedraw/report/cover_picture.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

TEST(Ticks, RoundAndFew) {
  EXPECT_EQ(ticks(-1.5, 3.2, 4.7), (std::vector<double>{-1, 0, 1, 2, 3}));
  EXPECT_EQ(ticks(0, 45, 45), (std::vector<double>{0, 10, 20, 30, 40}));
  EXPECT_EQ(ticks(-90000, 100000, 190000), (std::vector<double>{-50000, 0, 50000, 100000}));
  EXPECT_TRUE(ticks(0.2, 0.8, 0.6).empty());
}

// A thick target on a small page: its entry is no higher than the text beside it.
TEST(Legend, EntriesStayWithinTheirLine) {
  const auto stem = std::filesystem::temp_directory_path() / "impedraw_sheet_test";
  Sheet sheet{.title = "legend", .area = {Eigen::Vector2d(0, 0), Eigen::Vector2d(20, 20)}};
  sheet.legend = {{{1.0, 0.0, 0.0}, 50.0, "target"}};
  sheet.content = [](cairo_t*) {};
  write_sheet(sheet, stem);
  std::stringstream svg;
  svg << std::ifstream(stem.string() + ".svg").rdbuf();
  EXPECT_EQ(svg.str().find("stroke-width=\"50\""), std::string::npos);
  EXPECT_NE(svg.str().find("stroke-width"), std::string::npos);
}

// What is outside is cut off: a place of 10 mm in a map of 200 mm.
TEST(CoverPicture, ShowsWhatIsCovered) {
  const auto stem = std::filesystem::temp_directory_path() / "impedraw_cover_picture_test";
  CoverPicture picture{.title = "t", .subtitle = "", .nx = 40, .ny = 40, .step = 5e-3};
  picture.treated.assign(1600, Treated::outside);
  picture.dose.assign(1600, std::nan(""));
  for (const int v : {820, 821, 860, 861})
    picture.treated[static_cast<std::size_t>(v)] = Treated::once;
  write_cover(picture, stem);
  std::stringstream svg;
  svg << std::ifstream(stem.string() + ".svg").rdbuf();
  EXPECT_NE(svg.str().find("height=\"62\""), std::string::npos) << svg.str().substr(0, 200);
}

// A range that one step cannot be counted up in, and none at all.
TEST(Ticks, AnyRange) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (const double range : {1e-300, 1.0, 9.9e3, 1e9, 1e17, 1e300}) {
    for (const double low : {-0.5 * range, 0.0, 1e6, 1e17, 1e300}) {
      const std::vector<double> places = ticks(low, low + range, range);
      EXPECT_LE(places.size(), 11u) << low << ", " << range;
      for (std::size_t i = 1; i < places.size(); ++i) EXPECT_GE(places[i], places[i - 1]);
    }
  }
  EXPECT_TRUE(ticks(0, kInf, kInf).empty());
  EXPECT_TRUE(ticks(std::nan(""), 1, 1).empty());
}

}  // namespace
}  // namespace impedraw
