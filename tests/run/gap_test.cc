// Gaps that the cameras do not resolve: the tip falls in, and must not go on beneath the far side.
#include <array>

#include <fmt/format.h>

#include "drawn_scenario.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

// A closed box, as an OBJ's vertices and triangles; `first`: number of its first vertex.
std::string box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, int first) {
  std::string text;
  for (int i = 0; i < 8; ++i)
    text += fmt::format("v {} {} {}\n", i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                        i & 4 ? high.z() : low.z());
  constexpr std::array<std::array<int, 4>, 6> kSides = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& s : kSides)
    for (const auto& t : {std::array{s[0], s[1], s[2]}, std::array{s[0], s[2], s[3]}})
      text += fmt::format("f {} {} {}\n", first + t[0], first + t[1], first + t[2]);
  return text;
}

class Gap : public ScratchFolder {};

// Two plates of 0.5 mm, 3.4 mm apart, and a line of 80 mm across. A tip that went on at the depth
// to which it is let down drew nothing beyond, and was lifted through the plate.
TEST_F(Gap, IsLiftedOutOfAndDrawnOnBehind) {
  const std::string plates = box({0.50, -0.1, 0.1115}, {0.5983, 0.1, 0.112}, 1) +
                             box({0.6017, -0.1, 0.1115}, {0.70, 0.1, 0.112}, 9);
  DrawOptions options;
  options.scenario = "scenarios/surfaces.yaml";
  options.svg = write("line.svg",
                      "<svg xmlns='http://www.w3.org/2000/svg' width='10mm' height='80mm' "
                      "viewBox='0 0 10 80'><path d='M5 0V80' fill='none' stroke='black'/></svg>");
  options.assignments = {"canvas.kind=mesh",
                         "canvas.mesh.file=" + write("plates.obj", plates).string(),
                         "canvas.move=[0.0001, 0, 0]",
                         "drawing.placement.width=null",
                         "drawing.placement.height=80",
                         "drawing.redraw=false"};
  const Figures f = draw_scenario(resolve(options));
  EXPECT_GT(f["coverage"], 0.9);
  EXPECT_LT(f["touchdown_peak"], 8.0);
  double highest = 0.0, deepest = 1.0;
  for (std::size_t i = 0; i < f.run.rows(); ++i) {
    highest = std::max(highest, f.run.contact_force[i].norm());
    deepest = std::min(deepest, f.run.tip_position[i].z());
  }
  EXPECT_LT(highest, 8.0);
  EXPECT_GT(deepest, 0.112 - 5.5e-3);
  ASSERT_FALSE(f.outcome.lacking.empty());
}

}  // namespace
}  // namespace impedraw
