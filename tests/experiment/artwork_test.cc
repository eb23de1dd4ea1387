// From drawing settings to strokes: each step against what the file was made of.
#include "impedraw/experiment/artwork.h"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/drawing/order.h"
#include "impedraw/experiment/prepare.h"

namespace impedraw {
namespace {

using testing::HasSubstr;

// A filled square of 80 mm with a hole of 40, and a dashed line of 90: 10 drawn, 5 left out, six
// times.
class MadeArtwork : public testing::Test {
 protected:
  MadeArtwork() {
    std::ofstream(file_) << R"(<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm"
        viewBox="0 0 100 100">
      <path d="M10 10h80v80h-80z M30 30v40h40v-40z" fill="green"/>
      <path d="M5 95 h90" fill="none" stroke="black" stroke-dasharray="10 5"/></svg>)";
    settings_.svg = file_;
  }
  ~MadeArtwork() override { std::filesystem::remove(file_); }

  Artwork made() const {
    const Shape shape = make_artwork(settings_, SettingErrors(places_));
    EXPECT_EQ(shape.drawn.strokes.size(), shape.target().strokes.size());
    return shape.drawn;
  }
  double length() const { return pen_down_length(made().strokes); }
  std::string error() const {
    try {
      made();
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  }

  std::filesystem::path file_ =
      std::filesystem::temp_directory_path() / "impedraw_made_artwork.svg";
  Places places_;
  DrawingSettings settings_;
};

TEST_F(MadeArtwork, DashesAreApplied) {
  EXPECT_EQ(made().strokes.size(), 2u + 6);
  EXPECT_NEAR(length(), 320 + 160 + 60, 1e-2);
  EXPECT_TRUE(made().warnings.empty());
}

TEST_F(MadeArtwork, HatchIsSpacedOnTheCanvas) {
  settings_.hatch.spacing_mm = 1;
  settings_.placement.scale = 0.5;  // 2 mm on the page
  const double area = 80 * 80 - 40 * 40;
  // Lines at 45° that are joined along the outline: a join has √2 of the spacing. Across them lie
  // 80 √2, and 40 √2 more where the hole parts them.
  const auto expect_hatch = [&](double other, double wanted, double tolerance, double joins) {
    EXPECT_GT(length() - other, wanted - tolerance);
    EXPECT_LT(length() - other, wanted + tolerance + joins);
  };
  constexpr double kJoins = 2.0 * (80 + 40);
  expect_hatch(540, area / 2, 0.02 * area, kJoins);
  settings_.placement.scale = 2.0;
  expect_hatch(540, area * 2, 0.02 * area, kJoins);
  settings_.hatch.cross = true;
  expect_hatch(540, area * 4, 0.04 * area, 2 * kJoins);
  settings_.hatch.cross = false;
  settings_.hatch.outline = false;
  expect_hatch(60, area * 2, 0.02 * area, kJoins);
  // The placement of what comes out is the one that the spacing was made for.
  settings_.placement.scale.reset();
  settings_.placement.fit_width_m =
      0.17;  // 85 mm from the first dash to the end of the last: scale 2
  EXPECT_NEAR(place(made(), placement_settings(settings_)).scale(), 2, 1e-6);
  expect_hatch(60, area * 2, 0.02 * area, kJoins);
  settings_.hatch.spacing_mm = 0;
  EXPECT_NEAR(length(), 60, 1e-2);
}

TEST_F(MadeArtwork, OrderShortensTheWayInTheAir) {
  settings_.hatch.spacing_mm = 4;
  settings_.placement.scale = 1.0;
  const std::vector<Stroke> ordered = made().strokes;
  settings_.keep_order = true;
  const std::vector<Stroke> kept = made().strokes;
  EXPECT_EQ(ordered.size(), kept.size());
  EXPECT_NEAR(pen_down_length(ordered), pen_down_length(kept), 1e-6);
  // Rounding decides between equally near lines to join, so what is left to gain differs.
  EXPECT_LT(pen_up_length(ordered), 0.9 * pen_up_length(kept));
  EXPECT_TRUE(kept[0].closed && kept[1].closed);  // as in the file
}

TEST_F(MadeArtwork, TextIsAnArtworkToo) {
  settings_.svg.clear();
  settings_.text.text = "Fa\\nb";
  EXPECT_FALSE(placement_settings(settings_).scale.has_value());  // fitted as a file
  settings_.text.size_mm = 20;
  const PlacementSettings placing = placement_settings(settings_);
  EXPECT_EQ(placing.scale, 1.0);
  settings_.keep_order = true;
  const auto stem = placed_strokes(made(), place(made(), placing)).at(0).p_P;
  EXPECT_NEAR(stem.front().x() - stem.back().x(), 0.020, 1e-9);
  settings_.placement.width_mm = 30;
  EXPECT_FALSE(placement_settings(settings_).scale.has_value());
  settings_.keep_order = false;
  EXPECT_LE(pen_up_length(made().strokes), pen_up_length(make_text(settings_.text).strokes));
  settings_.text.text = "\xe4\xb8\xad";
  EXPECT_THAT(error(), HasSubstr("U+4E2D"));
}

TEST_F(MadeArtwork, WhatDoesNotGoTogether) {
  settings_.unit = PageUnit::cm;
  EXPECT_THAT(error(), HasSubstr("an SVG defines its own unit"));
  settings_.unit = PageUnit::file;
  settings_.text.text = "a";
  EXPECT_THAT(error(), HasSubstr("drawing.svg and drawing.text.text are both given"));
  settings_.text.text.clear();
  settings_.hatch.outline = false;
  std::ofstream(file_)
      << "<svg xmlns='http://www.w3.org/2000/svg'><rect width='9' height='9' fill='red'/></svg>";
  EXPECT_THAT(error(), HasSubstr("nothing is left to draw"));
}

TEST(ResolvedDrawing, TheCommandLinesArtworkReplacesTheScenarios) {
  DrawOptions options;
  options.text = "hello";
  const Scenario text = resolve(options);
  EXPECT_EQ(text.drawing.text.text, "hello");
  EXPECT_TRUE(text.drawing.svg.empty());
  EXPECT_EQ(text.name, "text");
  EXPECT_EQ(text.log.rate, LogRate::reduced);
  EXPECT_EQ(resolve({}).log.rate, LogRate::full) << "the standard sine is judged from its log";
  options.text.clear();
  options.assignments = {"drawing.text.text=from the scenario"};
  EXPECT_EQ(resolve(options).drawing.text.text, "from the scenario");
  options.shape = "M";
  EXPECT_TRUE(resolve(options).drawing.text.text.empty());
}

}  // namespace
}  // namespace impedraw
