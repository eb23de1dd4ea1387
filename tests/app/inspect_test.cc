// What inspect says of artwork, against what the file was made of.
#include "impedraw/app/commands.h"

#include <cmath>
#include <fstream>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

nlohmann::ordered_json described(const std::string& name, const std::string& text) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("impedraw_inspect_" + name);
  std::ofstream(file) << text;
  const nlohmann::ordered_json found = describe_artwork(file);
  std::filesystem::remove(file);
  return found;
}

TEST(Inspect, Svg) {
  const auto found = described("a.svg", R"(<svg xmlns="http://www.w3.org/2000/svg"
      xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"
      width="100mm" height="50mm" viewBox="0 0 200 100">
    <g inkscape:label="ring"><circle cx="20" cy="20" r="10" fill="white" stroke="red"/></g>
    <g id="box">
      <path d="M0 60 h60 v20 h-60 z M0 70 h10" fill="none" stroke="#000" stroke-dasharray="1"/>
      <path d="M0 0H9"/></g></svg>)");
  EXPECT_EQ(found["strokes"], 3);
  EXPECT_NEAR(found["length_mm"].get<double>(), (20 * std::numbers::pi + 160 + 10) / 2, 1e-4 * 100);
  const double expected[] = {0, 5, 30, 40};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(found["bbox_mm"][i].get<double>(), expected[i], 1e-3);
  EXPECT_EQ(found["layers"].dump(), R"([{"name":"ring","strokes":1},{"name":"box","strokes":2}])");
  ASSERT_EQ(found["warnings"].size(), 2u);  // dashes, and a fill without an area
  EXPECT_NE(found["warnings"][1].get<std::string>().find("with their dashes there are "),
            std::string::npos);
}

TEST(Inspect, LengthOfManySmallArcs) {
  // Curves far smaller than the page: a thousand arcs of radius 0.2 mm on 500 mm.
  std::string d;
  for (int i = 0; i < 1000; ++i)
    d += "M" + std::to_string(i % 50 * 10) + " " + std::to_string(i / 50 * 25 + 1) +
         "a.2 .2 0 0 1 .4 0";
  const auto found = described(
      "b.svg",
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="500mm" height="500mm" viewBox="0 0 500 500">
      <path fill="none" stroke="red" d=")" +
          d + "\"/></svg>");
  EXPECT_EQ(found["strokes"], 1000);
  EXPECT_NEAR(found["length_mm"].get<double>(), 200 * std::numbers::pi,
              1e-3 * 200 * std::numbers::pi);
}

TEST(Inspect, StrokesDotsAndNothing) {
  const auto found = described("c.csv", "x,y\n1,2\n4,6\n\n10,0\n");
  EXPECT_EQ(found["strokes"], 2);
  EXPECT_NEAR(found["length_mm"].get<double>(), 5, 1e-12);
  EXPECT_EQ(found["bbox_mm"].dump(), "[1.0,0.0,10.0,6.0]");
  const auto empty = described(
      "d.svg", "<svg xmlns='http://www.w3.org/2000/svg'><path d='M0 0H9' fill='none'/></svg>");
  EXPECT_EQ(empty["strokes"], 0);
  EXPECT_TRUE(empty["bbox_mm"].is_null());
  EXPECT_EQ(empty["warnings"].size(), 1u);
  EXPECT_THROW(described("e.svg", "<svg"), InputError);
  EXPECT_THROW(described("e.gif", "GIF"), InputError);
}

}  // namespace
}  // namespace impedraw
