// The picture of the distortion on a plane tilted by 30°, where both maps have one colour each.
#include "impedraw/report/distortion_picture.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <cairo.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include "impedraw/planning/wrap/wrap.h"

namespace impedraw {
namespace {

const Eigen::Vector2d kCentre(0.60, 0);

std::optional<SurfaceSample> tilted(double x, double y) {
  return SurfaceSample{{x, y, x / std::sqrt(3)}, Eigen::Vector3d(-0.5, 0, std::sqrt(3) / 2)};
}

// Of the pixels between two shares of the picture's width, how many are within 3 of a colour.
double share_of_colour(cairo_surface_t* png, double from, double to, int r, int g, int b) {
  const int width = cairo_image_surface_get_width(png),
            height = cairo_image_surface_get_height(png);
  int count = 0, all = 0;
  for (int i = 0; i < height; ++i) {
    const auto* row = reinterpret_cast<const std::uint32_t*>(
        cairo_image_surface_get_data(png) + i * cairo_image_surface_get_stride(png));
    for (int j = static_cast<int>(from * width); j < to * width; ++j, ++all) {
      const auto near = [&](int shift, int desired) {
        return std::abs(static_cast<int>(row[j] >> shift & 255) - desired) <= 3;
      };
      count += near(16, r) && near(8, g) && near(0, b);
    }
  }
  return static_cast<double>(count) / all;
}

class DistortionPictureTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder); }
  void TearDown() override { std::filesystem::remove_all(folder); }

  PlacedStroke stroke() const {
    const std::vector<Eigen::Vector2d> points = {kCentre - Eigen::Vector2d(0.05, 0.05),
                                                 kCentre + Eigen::Vector2d(0.05, 0.05)};
    return {points, points};
  }
  void write(const std::filesystem::path& stem) const {
    const std::vector<PlacedStroke> strokes = {stroke()};
    const Wrap wrap(tilted, kCentre, strokes);
    const WrappedStrokes wrapped = wrap.wrap(strokes);
    write_distortion({"tilted", wrap.chart(), strokes, wrapped.strokes,
                      distortion_of_projection(strokes, tilted),
                      distortion_of_wrap(strokes, tilted, wrap.chart()), 1000},
                     stem);
  }

  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("impedraw_distortion_{}", ::getpid());
};

TEST_F(DistortionPictureTest, ShowsTheSlopeOnTheLeftAndNothingOnTheRight) {
  write(folder / "wrap");
  cairo_surface_t* png = cairo_image_surface_create_from_png((folder / "wrap.png").c_str());
  ASSERT_EQ(cairo_surface_status(png), CAIRO_STATUS_SUCCESS);
  EXPECT_EQ(cairo_image_surface_get_width(png), 1000);
  // 1/cos 30° − 1 = 15.47 % of a scale that ends at 20 %: 0.0940 of the way from the fourth of its
  // five colours to the last.
  const auto mixed = [](double a, double b) {
    return static_cast<int>(std::lround(255 * (a + 0.0940 * (b - a))));
  };
  const int r = mixed(0.82, 0.48), g = mixed(0.31, 0.08), b = mixed(0.18, 0.14);
  EXPECT_GT(share_of_colour(png, 0, 0.42, r, g, b), 0.12);
  EXPECT_LT(share_of_colour(png, 0.45, 0.85, r, g, b), 0.001);
  EXPECT_GT(share_of_colour(png, 0.45, 0.85, 245, 242, 232), 0.12);
  EXPECT_LT(share_of_colour(png, 0, 0.42, 245, 242, 232), 0.001);
  cairo_surface_destroy(png);
  std::ostringstream svg;
  svg << std::ifstream(folder / "wrap.svg").rdbuf();
  EXPECT_THAT(svg.str(), ::testing::HasSubstr("mm\""));
}

TEST_F(DistortionPictureTest, SaysWhereItCannotWrite) {
  try {
    write(folder / "none" / "wrap");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("none/wrap.svg"));
  }
}

}  // namespace
}  // namespace impedraw
