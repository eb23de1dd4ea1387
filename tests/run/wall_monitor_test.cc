// A pen before a wall, and what must not be taken for one.
#include "impedraw/run/monitors/wall_monitor.h"
#include "impedraw/run/monitors/side_monitor.h"
#include "impedraw/run/monitors/sink_monitor.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kCycle = 1e-3;
const Vector3d n = Vector3d::UnitZ(), v_D(0.05, 0.0, 0.0);

// Cycles until the wall is noticed; −1: not within a second.
int cycles(const Vector3d& v, const Vector3d& behind, const Vector3d& F,
           const Vector3d& desired = v_D) {
  WallMonitor watch;
  for (int i = 1; i <= 1000; ++i)
    if (watch.update(n, desired, v, behind, F, kCycle)) return i;
  return -1;
}

TEST(WallMonitor, NoticesATipThatStandsAndIsPushedBack) {
  EXPECT_EQ(cycles(Vector3d::Zero(), {2e-3, 0, 0}, {-6, 0, 5}),
            std::lround(WallMonitor::kConfirm / kCycle));
}

TEST(WallMonitor, NeedsForceLagAndStandstillTogether) {
  EXPECT_EQ(cycles({0.04, 0, 0}, {2e-3, 0, 0}, {-6, 0, 5}), -1);        // it moves
  EXPECT_EQ(cycles(Vector3d::Zero(), {2e-3, 0, 0}, {-1.5, 0, 5}), -1);  // friction alone
  EXPECT_EQ(cycles(Vector3d::Zero(), {0.5e-3, 0, 0}, {-6, 0, 5}), -1);  // it is in place
  EXPECT_EQ(cycles(Vector3d::Zero(), {2e-3, 0, 0}, {0, -9, 5}), -1);    // pushed aside, not back
  EXPECT_EQ(cycles(Vector3d::Zero(), {2e-3, 0, 0}, {-6, 0, 5}, {1e-3, 0, 0}), -1);  // none wanted
}

TEST(WallMonitor, IgnoresForceAndMotionAlongTheNormal) {
  EXPECT_EQ(cycles(Vector3d::Zero(), {2e-3, 0, 0}, {-6, 0, 5}, {0.05, 0, 0.05}),
            cycles(Vector3d::Zero(), {2e-3, 0, 0}, {-6, 0, 7}));
}

// Pressed on with 20 N, a tip at rest is held by 6 N of friction.
TEST(WallMonitor, TakesNoFrictionForAWall) {
  EXPECT_EQ(cycles(Vector3d::Zero(), {2e-3, 0, 0}, {-6, 0, 20}), -1);
  EXPECT_GT(cycles(Vector3d::Zero(), {2e-3, 0, 0}, {-17, 0, 20}), 0);
}

// A hand's push of 10 N against the motion for less than kConfirm, again and again.
TEST(WallMonitor, ForgetsShortBlows) {
  WallMonitor watch;
  const int blow = static_cast<int>(0.6 * WallMonitor::kConfirm / kCycle);
  for (int i = 0; i < 5000; ++i) {
    const bool pushed = i % (2 * blow) < blow;
    EXPECT_FALSE(watch.update(n, v_D, pushed ? Vector3d::Zero() : v_D, {2e-3, 0, 0},
                              pushed ? Vector3d(-10, 0, 5) : Vector3d(-1.5, 0, 5), kCycle));
  }
}

int cycles_aside(const Vector3d& F) {
  SideMonitor watch;
  for (int i = 1; i <= 1000; ++i)
    if (watch.update(n, F, kCycle)) return i;
  return -1;
}

TEST(SinkMonitor, NoticesATipThatFallsBelowWhereItTouched) {
  SinkMonitor watch;
  EXPECT_FALSE(watch.update(-0.2e-3, 0.0, true, kCycle));
  EXPECT_FALSE(watch.update(-1.6e-3, 0.0, false, kCycle));
  EXPECT_FALSE(watch.update(-1.6e-3, 0.0, true, kCycle));  // a hollow that was not seen
  EXPECT_FALSE(watch.update(-3.0e-3, 0.0, false, kCycle));
  EXPECT_TRUE(watch.update(-3.2e-3, 0.0, false, kCycle));
  watch.reset();
  EXPECT_FALSE(watch.update(-2.9e-3, 0.0, false, kCycle));  // pen and cameras err a little
  EXPECT_TRUE(watch.update(-3.1e-3, 0.0, false, kCycle));
  EXPECT_FALSE(watch.update(std::nan(""), 0.0, false, kCycle));
}

// Touched all the time, and going down by so much per way along the surface.
TEST(SinkMonitor, NoticesATipThatSlidesDownTheSideOfAGap) {
  const auto deepest = [](double steepness) {
    SinkMonitor watch;
    for (int i = 0; i < 100; ++i) EXPECT_FALSE(watch.update(-0.3e-3, 0.02e-3, true, kCycle));
    double distance = -0.3e-3;
    while (distance > -8e-3 && !watch.update(distance, 0.02e-3, true, kCycle))
      distance -= steepness * 0.02e-3;
    return distance;
  };
  EXPECT_GT(deepest(10.0), -3.0e-3);
  EXPECT_LT(deepest(1.7), -8.0e-3);  // a slope of 60° that the cameras took for level
}

// A noisy wrench tells of touches in the air.
TEST(SinkMonitor, TakesNoShortTouchForTheSurface) {
  SinkMonitor watch;
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(watch.update(1.4e-3, 0.0, true, kCycle));
  EXPECT_FALSE(watch.update(1.0e-3, 0.0, false, kCycle));
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(watch.update(-0.3e-3, 0.0, true, kCycle));
}

TEST(SideMonitor, NoticesATipThatIsPushedAside) {
  EXPECT_EQ(cycles_aside({-6, 5, 2}), std::lround(SideMonitor::kConfirm / kCycle));
  EXPECT_GT(cycles_aside({-5, 0, -1}), 0);  // even into the surface
}

TEST(SideMonitor, TakesNeitherFrictionNorASlopeForAWall) {
  EXPECT_EQ(cycles_aside({-1.5, 0, 5}), -1);  // friction of 0.3
  // a normal that is 40° off, and friction: 57°
  const double lean = (40.0 + 16.7) * std::numbers::pi / 180.0;
  EXPECT_EQ(cycles_aside(8.0 * Vector3d(std::sin(lean), 0, std::cos(lean))), -1);
  EXPECT_EQ(cycles_aside({-3, 0, 0.5}), -1);  // gently
}

// A slim cone cuts with twice as much force across as along the normal.
TEST(SideMonitor, BearsWhatTheLawExpectsOfACutter) {
  const auto notices = [](const Vector3d& F) {
    SideMonitor watch(3.0);
    for (int i = 0; i < 1000; ++i)
      if (watch.update(n, F, kCycle)) return true;
    return false;
  };
  EXPECT_FALSE(notices({-6, 0, 2.5}));
  EXPECT_TRUE(notices({-6, 0, 1.5}));
}

TEST(SideMonitor, ForgetsShortBlows) {
  SideMonitor watch;
  const int blow = static_cast<int>(0.6 * SideMonitor::kConfirm / kCycle);
  for (int i = 0; i < 5000; ++i)
    EXPECT_FALSE(
        watch.update(n, i % (2 * blow) < blow ? Vector3d(-9, 0, 2) : Vector3d(-1, 0, 5), kCycle));
}

// A ball that is caught between a wire and the ground meets both in turns. A canvas never pulls.
TEST(SideMonitor, NoticesACanvasThatPulls) {
  const auto pulls = [](double wire, int of) {
    SideMonitor watch;
    for (int i = 1; i <= 1000; ++i)
      if (watch.update(n, i % of == 0 ? Vector3d{-3, 0, -wire} : Vector3d{0, 0, 12}, kCycle))
        return watch.caught() ? i : 0;
    return -1;
  };
  EXPECT_EQ(pulls(3.0, 1), 2);
  EXPECT_GT(pulls(3.0, 2), 0);
  EXPECT_LE(pulls(3.0, 2), 6);
  EXPECT_EQ(pulls(1.5, 2), -1);   // noise of a pen that hardly touches
  EXPECT_EQ(pulls(3.0, 50), -1);  // a reading now and then
}

}  // namespace
}  // namespace impedraw
