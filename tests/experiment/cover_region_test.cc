// The area and the tones of an SVG that cover.region names, on a page of 40 × 40 mm.
#include "impedraw/experiment/cover_region.h"

#include <gmock/gmock.h>

#include "impedraw/common/errors.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class CoverRegionTest : public ScratchFolder {
 protected:
  CoverRegionTest() {
    grid_ = sample_surface(
        [](double x, double y) {
          return SurfaceHeight::Sample{SurfaceSample{{x, y, 0.1}, Eigen::Vector3d::UnitZ()}};
        },
        {Eigen::Vector2d(0.55, -0.05), Eigen::Vector2d(0.65, 0.05)}, 1e-3, 75.0);
  }
  CoverRegion region(const std::string& shapes) const {
    Scenario s;
    s.cover.region =
        write("a.svg",
              "<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink' "
              "width='40mm' height='40mm' viewBox='0 0 40 40'>" +
                  shapes + "</svg>");
    s.drawing.placement.scale = 1.0;
    return region_of(s, grid_, {});
  }
  // At a place of the page [mm], whose middle lies at (0.6, 0) m, its x along −y.
  static double tone(const SurfaceGrid& grid, const CoverRegion& region, double x, double y) {
    return grid.sample(region.tones, {0.62 - 1e-3 * y, 0.02 - 1e-3 * x});
  }

  SurfaceGrid grid_;
};

// Hatching draws what is nearly black as black; a dose does not.
TEST_F(CoverRegionTest, DarkGreyIsNotBlack) {
  const CoverRegion r = region(
      "<rect width='20' height='40' fill='#222'/><rect x='20' width='20' height='40' "
      "fill='#000'/>");
  EXPECT_NEAR(tone(grid_, r, 10, 20), 0.87, 0.02);
  EXPECT_NEAR(tone(grid_, r, 30, 20), 1.0, 1e-9);
}

// A clear veil darkens what lies under it.
TEST_F(CoverRegionTest, TonesAddUpUnderAClearArea) {
  const CoverRegion r = region(
      "<rect width='40' height='40' fill='#333'/>"
      "<rect x='20' width='20' height='40' fill-opacity='0.4'/>");
  EXPECT_NEAR(tone(grid_, r, 10, 20), 0.8, 0.02);
  EXPECT_NEAR(tone(grid_, r, 30, 20), 0.88, 0.02);
}

// Nothing is told of a pen's lines, which a region does not have.
TEST_F(CoverRegionTest, TellsOfAreasAlone) {
  EXPECT_THAT(region("<rect width='40' height='40'/><rect width='40' height='20'/>"
                     "<rect x='9' width='9' height='20' opacity='0.4'/>")
                  .left_out,
              IsEmpty());
  EXPECT_THAT(
      region("<rect width='40' height='40'/><image width='9' height='9' href='a.png'/>").left_out,
      ElementsAre("1 × <image>: pictures are left out: only paths and shapes are read"));
}

TEST_F(CoverRegionTest, SaysWhatAPictureLacks) {
  try {
    region("<image width='9' height='9' href='a.png'/>");
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("has no filled area to cover (1 × <image>: pictures are"));
    EXPECT_THAT(error.what(), HasSubstr("valid is an SVG with one"));
  }
}

}  // namespace
}  // namespace impedraw
