// A ball, a table and a box beside it, in closed form.
#include "impedraw/capture/found_canvas.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/seeded_normals.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kNoise = 0.5e-3, kGood = 0.15e-3;  // [m]

struct Shown {
  PointCloud cloud;
  std::vector<int> what;  // 0: ball, 1: table, 2: box
  SeededNormals random{3};

  void add(const Vector3d& p, int kind, double noise = kNoise) {
    cloud.points.push_back(p + noise * random.next() * Vector3d::UnitZ());
    cloud.camera.push_back(p.y() > 0 ? 0 : 1);
    for (int c = 0; c < 3; ++c) cloud.rgb.push_back(static_cast<std::uint8_t>(kind));
  }
};

// The upper half of a ball of 8 cm on a tilted table, with a box 6 cm beside it.
Shown scene(bool with_ball = true) {
  Shown shown;
  shown.cloud.eyes = {Vector3d(0.6, 0.5, 0.9), Vector3d(0.6, -0.5, 0.9)};
  const auto table = [](double x, double y) { return 0.02 + 0.1 * (x - 0.6) - 0.05 * y; };
  for (double x = 0.35; x < 0.85; x += 0.0021)
    for (double y = -0.3; y < 0.3; y += 0.0023) {
      const double r = std::hypot(x - 0.6, y);
      const bool box = std::abs(x - 0.6) < 0.03 && std::abs(y - 0.17) < 0.03;
      if (with_ball && r < 0.079)
        shown.add({x, y, 0.05 + std::sqrt(0.08 * 0.08 - r * r)}, 0);
      else if (box)
        shown.add({x, y, 0.1}, 2);
      else
        shown.add({x, y, table(x, y)}, 1);
    }
  return shown;
}

TEST(FoundCanvas, TheBallStaysWithoutTableAndBox) {
  const Shown shown = scene();
  const FoundCanvas found = find_canvas(shown.cloud, {{}, {0.6, 0.0}, 0.06}, {"left", "right"});
  ASSERT_EQ(found.canvas.rgb.size(), 3 * found.canvas.points.size());
  const auto count = [](const PointCloud& cloud, int kind) {
    int n = 0;
    for (std::size_t i = 0; i < cloud.points.size(); ++i) n += cloud.rgb[3 * i] == kind;
    return n;
  };
  EXPECT_EQ(count(found.canvas, 1), 0);
  EXPECT_EQ(count(found.canvas, 2), 0);
  EXPECT_EQ(count(found.beside, 0), 0);
  EXPECT_GT(count(found.canvas, 0), 3000);
  EXPECT_EQ(found.canvas.points.size() + found.beside.points.size(), shown.cloud.points.size());
  ASSERT_EQ(found.notes.size(), 3u);
  EXPECT_THAT(found.notes[0], HasSubstr("the table, a plane"));
  EXPECT_THAT(found.notes[1], HasSubstr("left: "));
}

TEST(FoundCanvas, ATableThatIsDrawnOnStays) {
  const Shown shown = scene();
  const FoundCanvas beside = find_canvas(shown.cloud, {{}, {0.45, -0.2}, 0.05});
  int table = 0;
  for (std::size_t i = 0; i < beside.canvas.points.size(); ++i)
    table += beside.canvas.rgb[3 * i] == 1;
  EXPECT_GT(table, 10000);
}

// A ring of 3 to 8 cm with a round wall, on a table; in its middle the bowl's floor, or the table.
// The noise is that of good cameras.
FoundCanvas ring_about(double floor) {
  Shown shown;
  shown.cloud.eyes = {Vector3d(0.6, 0.5, 0.9), Vector3d(0.6, -0.5, 0.9)};
  for (double x = 0.35; x < 0.85; x += 0.0021)
    for (double y = -0.3; y < 0.3; y += 0.0023) {
      const double r = std::hypot(x - 0.6, y), out = std::abs(r - 0.055);
      if (r < 0.03)
        shown.add({x, y, floor}, 2, kGood);
      else if (out < 0.025)
        shown.add({x, y, 0.025 + std::sqrt(0.025 * 0.025 - out * out)}, 0, kGood);
      else
        shown.add({x, y, 0.0}, 1, kGood);
    }
  return find_canvas(shown.cloud, {{}, {0.6, 0.0}, 0.06, false});
}

TEST(FoundCanvas, ABowlKeepsItsThinFloorAndARingNotTheTableInIt) {
  const auto middle_kept = [](const FoundCanvas& found) {
    double kept = 0, all = 0;
    for (const PointCloud* cloud : {&found.canvas, &found.beside})
      for (std::size_t i = 0; i < cloud->points.size(); ++i) {
        if (cloud->rgb[3 * i] != 2) continue;
        all += 1;
        kept += cloud == &found.canvas;
      }
    return kept / all;
  };
  EXPECT_GT(middle_kept(ring_about(2.2e-3)), 0.95);
  EXPECT_LT(middle_kept(ring_about(0.0)), 0.05);
}

TEST(FoundCanvas, AFlatCanvasAloneIsNoTable) {
  Shown shown;
  shown.cloud.eyes = {Vector3d(0.6, 0.0, 0.9)};
  for (double x = 0.5; x < 0.7; x += 0.002)
    for (double y = -0.1; y < 0.1; y += 0.002) shown.add({x, y, 0.1}, 0);
  shown.cloud.camera.assign(shown.cloud.points.size(), 0);
  const FoundCanvas found = find_canvas(shown.cloud, {{}, {0.6, 0.0}, 0.15});
  EXPECT_TRUE(found.beside.points.empty());
  EXPECT_TRUE(found.notes.empty());
}

// Nothing is said by where the drawing happens to be: over the table here.
TEST(FoundCanvas, AnUnplacedDrawingLooksForTheObjectAndNotForTheTable) {
  const Shown shown = scene();
  const FoundCanvas found = find_canvas(shown.cloud, {{}, {0.45, -0.2}, 0.05, false});
  ASSERT_GT(found.canvas.points.size(), 3000u);
  for (std::size_t i = 0; i < found.canvas.points.size(); ++i)
    ASSERT_EQ(found.canvas.rgb[3 * i], 0);
  // Nothing that stands there bears a drawing of a metre: it may lie on the table.
  const FoundCanvas large = find_canvas(shown.cloud, {{}, {0.45, -0.2}, 0.5, false});
  EXPECT_GT(large.canvas.points.size(), found.canvas.points.size() + 10000);
}

// A ball above a plate, 4 cm apart: what is beneath it cannot be drawn on, so that it stays.
TEST(FoundCanvas, AnUnplacedDrawingKnowsWhatHidesTheObject) {
  Shown shown;
  shown.cloud.eyes = {Vector3d(0.6, 0.5, 0.9), Vector3d(0.6, -0.5, 0.9)};
  for (double x = 0.5; x < 0.7; x += 0.002)
    for (double y = -0.1; y < 0.1; y += 0.002) {
      shown.add({x, y, 0.1}, 1);
      const double r2 = 0.03 * 0.03 - (x - 0.6) * (x - 0.6) - y * y;
      if (r2 > 0.0) shown.add({x, y, 0.14 + std::sqrt(r2)}, 0);
      if (x < 0.55 && y < -0.05) shown.add({x + 0.2, y - 0.1, 0.14}, 2);
    }
  const FoundCanvas found = find_canvas(shown.cloud, {{}, {0.6, 0.0}, 0.05, false});
  int ball = 0, beside = 0;
  for (std::size_t i = 0; i < found.canvas.points.size(); ++i) {
    ball += found.canvas.rgb[3 * i] == 0;
    beside += found.canvas.rgb[3 * i] == 2;
  }
  EXPECT_GT(ball, 600);
  EXPECT_EQ(beside, 0);
}

// The drawing is not placed yet: the largest part that stands on the table.
TEST(FoundCanvas, WithNothingUnderTheDrawingTheLargestPartStays) {
  Shown shown = scene();
  const FoundCanvas found = find_canvas(shown.cloud, {{}, {0.9, 0.4}, 0.02});
  for (std::size_t i = 0; i < found.canvas.points.size(); ++i)
    ASSERT_EQ(found.canvas.rgb[3 * i], 0);
}

}  // namespace
}  // namespace impedraw
