// Widths and forces of lines as forces of the pen: the pen's straight line between, and its limits.
#include "impedraw/experiment/line_forces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using testing::Contains;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Strokes of 10 mm, drawn twice as large.
PlacedArtwork lines(std::vector<Stroke> strokes) {
  PlacedArtwork artwork;
  for (Stroke& stroke : strokes) stroke.points = {{0, 0}, {10, 0}};
  artwork.shape.drawn.strokes = std::move(strokes);
  artwork.shape.drawn.layers = {"page"};
  artwork.placement.A *= 2.0;
  artwork.strokes = placed_strokes(artwork.shape.drawn, artwork.placement);
  return artwork;
}

class LineForces : public testing::Test {
 protected:
  std::vector<PlacedStroke> given(std::vector<Stroke> strokes) {
    PlacedArtwork artwork = lines(std::move(strokes));
    give_forces(scenario_, SettingErrors(places_), &artwork);
    notes_ = artwork.notes;
    return artwork.strokes;
  }

  Places places_;
  Scenario scenario_;
  std::vector<std::string> notes_;
};

TEST_F(LineForces, AWidthIsAForceOfThePensModelWithinItsLimits) {
  Stroke thin, fine, thick, swelling;
  thin.width = 0.05;
  fine.width = 0.4;  // 0.8 mm as drawn: 4 N
  thick.width = 4;
  swelling.press = {0.4, 0.7};
  const Stroke unknown;
  scenario_.pen.width_per_newton = 0.2;
  const auto strokes = given({thin, fine, thick, swelling, unknown});
  const auto N = [](double force) { return DoubleNear(force, 1e-9); };
  EXPECT_THAT(strokes[0].force, ElementsAre(N(1.25), N(1.25)));  // 0.25 mm, a quarter of the width
  EXPECT_THAT(strokes[1].force, ElementsAre(N(4), N(4)));
  EXPECT_THAT(strokes[2].force, ElementsAre(N(8), N(8)));
  EXPECT_THAT(strokes[3].force, ElementsAre(N(4), N(7)));
  EXPECT_THAT(strokes[4].force, IsEmpty());
  ASSERT_EQ(notes_.size(), 1u);
  EXPECT_THAT(notes_[0],
              HasSubstr("lines of 0.1 to 8 mm are asked for, the pen can 0.25 to 1.6: of "
                        "80 mm, 20 mm are drawn lighter and 20 mm heavier"));
  EXPECT_EQ(hardest(scenario_, strokes), 8.0);
  scenario_.pen.least_force = 9.0;
  EXPECT_THROW(given({thin}), InputError);
}

TEST_F(LineForces, LayersHavePensSpeedsWaitsAndPauses) {
  Stroke first, second;
  first.colour = 0x0000ff;
  second.layer = 1;
  second.width = 0.6;
  PlacedArtwork artwork = lines({first, first, second, second});
  artwork.shape.drawn.layers = {"1 blue", "!2+S50+D700 wide"};
  scenario_.path.draw_speed = 0.05;
  scenario_.pens.resize(2);
  scenario_.pens[0].layer = "wide";
  scenario_.pens[0].width_per_newton = 0.1;
  scenario_.pens[0].width = 0.9;
  scenario_.pens[0].colour = "#102030";
  scenario_.pens[1].layer = "1";
  scenario_.pens[1].force = 3.0;
  scenario_.pens[1].speed = 0.02;
  give_forces(scenario_, SettingErrors(places_), &artwork);
  const auto& strokes = artwork.strokes;
  EXPECT_THAT(strokes[1].force, ElementsAre(3.0, 3.0));
  EXPECT_THAT(strokes[2].force, ElementsAre(DoubleNear(8.0, 1e-9), DoubleNear(8.0, 1e-9)));
  EXPECT_DOUBLE_EQ(strokes[0].speed, 0.02);
  EXPECT_DOUBLE_EQ(strokes[3].speed, 0.025);
  EXPECT_TRUE(!strokes[0].pause && !strokes[2].pause) << "the change of pens waits";
  EXPECT_THAT(artwork.notes, Contains(HasSubstr("pens are changed 1 time,")));
  EXPECT_EQ(strokes[2].wait, 0.7);
  EXPECT_EQ(strokes[3].wait, 0.0);
  const std::vector<DrawnPen> pens =
      layer_pens(scenario_, artwork.shape.drawn, SettingErrors(places_));
  EXPECT_EQ(pens[0].name, "blue");
  EXPECT_EQ(pens[0].colour, 0x0000ffu);
  EXPECT_EQ(pens[1].colour, 0x102030u);
  EXPECT_EQ(pens[1].line.width, 0.9);
  EXPECT_EQ(pens[0].number, -1) << "the pen of `pen`, at another speed";
  EXPECT_EQ(pens[1].number, 0);
  scenario_.pens[0] = scenario_.pens[1];
  scenario_.pens[0].layer = "wide";
  give_forces(scenario_, SettingErrors(places_), &artwork);
  EXPECT_TRUE(!strokes[0].pause && strokes[2].pause && !strokes[3].pause) << "one pen";
  scenario_.pens[1].layer = "third";
  EXPECT_THROW(layer_pens(scenario_, artwork.shape.drawn, SettingErrors(places_)), InputError);
}

TEST_F(LineForces, APenOfOneWidthIsToldAndForcesActByThemselves) {
  Stroke thin, thick, pressed;
  thin.width = 0.4;
  thick.width = 4;
  pressed.by_force = true;
  pressed.press = {2, 30};
  const auto strokes = given({thin, thick, pressed});
  EXPECT_THAT(strokes[0].force, IsEmpty());
  EXPECT_THAT(strokes[2].force, ElementsAre(2, 8));  // not scaled
  EXPECT_THAT(notes_, ElementsAre(HasSubstr("lines of 0.8 to 8 mm are drawn alike"),
                                  HasSubstr("forces of 2 to 30 N are asked for")));
  given({thin, thin});
  EXPECT_THAT(notes_, IsEmpty());
  scenario_.perception.enabled = false;
  EXPECT_THAT(given({pressed})[0].force, IsEmpty());
  EXPECT_THAT(notes_, ElementsAre(HasSubstr("without perception")));
}

}  // namespace
}  // namespace impedraw
