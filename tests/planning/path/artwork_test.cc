// The drawing in artwork/, from its file to a path on the bowl.
#include <gtest/gtest.h>

#include "impedraw/drawing/svg.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/target.h"
#include "planning/surfaces.h"

namespace impedraw {
namespace {

TEST(Artwork, KoiFitTheBowl) {
  const Artwork koi = read_svg("artwork/koi.svg");
  EXPECT_TRUE(koi.warnings.empty());
  EXPECT_EQ(koi.layers, (std::vector<std::string>{"pond", "koi", "page", "water"}));
  PlacementSettings placement;
  placement.fit_radius_m = 0.118;  // as large as on its page
  const std::vector<PlacedStroke> strokes = placed_strokes(koi, place(koi, placement));
  const TipPath path = plan_tip_path(strokes, surfaces::bowl, surfaces::brisk());
  const TargetLine target = project_target(strokes, surfaces::bowl);
  EXPECT_EQ(target.stroke.back() + 1, static_cast<int>(strokes.size()));
  EXPECT_LT(path.pen_down_length(), 4.5);
  double target_length = 0, drawing_time = 0;
  for (std::size_t i = 1; i < target.points.size(); ++i) {
    if (target.stroke[i] == target.stroke[i - 1])
      target_length += (target.points[i] - target.points[i - 1]).norm();
  }
  for (const StrokeTimes& s : path.strokes()) drawing_time += s.end - s.start;
  EXPECT_NEAR(path.pen_down_length(), target_length, 2e-3 * target_length);
  EXPECT_GT(path.pen_down_length() / drawing_time, 0.035);
  std::printf("koi: %zu strokes, %.2f m, %.0f s, pen down %.0f s\n", strokes.size(),
              path.pen_down_length(), path.duration(), drawing_time);
}

}  // namespace
}  // namespace impedraw
