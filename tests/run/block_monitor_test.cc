// Places where a perceived surface does not let the pen pass: what BlockMonitor makes of each, on
// the standard bowl.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "impedraw/run/monitors/block_monitor.h"
#include "made_up_cycle.h"
#include "prepared.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

class Blocked : public testing::Test {
 protected:
  static const Prepared& bowl() {
    static const Prepared e = prepared("bowl-sine");
    return e;
  }

  Blocked() {
    monitor_.begin_path();
    made_.out.mode = ContactMode::contact;
    made_.out.n_WD = Vector3d::UnitZ();
    made_.desired.stroke = 0;
    made_.desired.along = 0.1;
    const auto& points = bowl().belief.perception->cloud().points;
    for (const Vector3d& p : points)
      if ((p - kMiddle).norm() < (made_.arm.X_WE.p - kMiddle).norm()) made_.arm.X_WE.p = p;
    behind(Vector3d::Zero());
  }

  void behind(const Vector3d& by) { made_.out.p_WD = made_.arm.X_WE.p + by; }

  Verdict judge(bool unseen = false) {
    return monitor_.judge(made_.next(), bowl().plan.path, 0.0, unseen, &place_);
  }
  // Cycles until there is a verdict; −1: within 200 there is none.
  int cycles(Verdict* said = nullptr) {
    for (int n = 1; n <= 200; ++n) {
      const Verdict found = judge();
      if (said) *said = found;
      if (found) return n;
    }
    return -1;
  }

  const Vector3d kMiddle{0.6, 0.0, 0.05};  // the bowl's lowest point
  BlockMonitor monitor_{bowl()};
  MadeUpCycle made_;
  std::optional<StrokePart> place_;
};

TEST_F(Blocked, ByAWallThatPushesThePenBackFromWhereThePlanGoes) {
  made_.desired.reference.v_WD = {0.05, 0.0, 0.0};
  behind({3e-3, 0.0, 0.0});
  made_.F_ext.head<3>() = Vector3d(-5.0, 0.0, 5.0);
  Verdict said;
  EXPECT_NEAR(cycles(&said), WallMonitor::kConfirm / MadeUpCycle::kDt, 1.5);
  EXPECT_EQ(said.severity, Severity::lift);
  EXPECT_EQ(said.end, RunEnd::finished);
  EXPECT_EQ(said.rise, Verdict::Rise::a_little);
  ASSERT_TRUE(place_);
  EXPECT_NEAR(place_->from, 0.1 - 3e-3, 1e-12);
  EXPECT_NEAR(place_->to, 0.1, 1e-12);

  made_.arm.V_WE[0] = 0.05;
  EXPECT_EQ(cycles(), -1) << "the pen moves on";
  made_.arm.V_WE[0] = 0.0;
  made_.F_ext[0] = 5.0;
  EXPECT_EQ(cycles(), -1) << "pushed along";
  made_.F_ext[0] = -5.0;
  behind({-3e-3, 0.0, 0.0});
  EXPECT_EQ(cycles(), -1) << "ahead of the plan";
  behind({3e-3, 0.0, 0.0});
  made_.desired.stroke = -1;
  EXPECT_EQ(cycles(), -1) << "between strokes";
}

// A wire: it pulls the ball against the normal and aside, and the pen goes out from beneath it.
TEST_F(Blocked, ByWhatHoldsTheBallOfTheTip) {
  made_.F_ext.head<3>() = Vector3d(-3.0, 0.0, -3.0);
  Verdict said;
  EXPECT_NEAR(cycles(&said), SideMonitor::kConfirmPull / MadeUpCycle::kDt, 1.5);
  EXPECT_TRUE(said.aside_W.isApprox(Vector3d(-1e-3, 0.0, 0.0), 1e-9)) << said.aside_W.transpose();
  made_.F_ext[2] = 3.0;
  EXPECT_EQ(cycles(), -1);
  made_.F_ext.head<3>() = Vector3d(5.0, 0.0, 2.0);
  EXPECT_NEAR(cycles(&said), SideMonitor::kConfirm / MadeUpCycle::kDt, 1.5);
  EXPECT_TRUE(said.aside_W.isZero(0.0)) << "the foot of a wall";
}

// A cut pushes its cone aside by 1.4 times as much as along the normal. That is no wall, also where
// the estimated normal is 15° off.
TEST_F(Blocked, NotByTheForcesOfACut) {
  Prepared engraving = prepared("bowl-engrave");
  BlockMonitor monitor(engraving);
  const auto stopped = [&](double off_deg) {
    monitor.begin_path();
    const double off = off_deg * std::numbers::pi / 180.0;
    made_.F_ext.head<3>() = Eigen::AngleAxisd(-off, Vector3d::UnitY()) * Vector3d(-5.3, 0.0, 3.7);
    for (int i = 0; i < 200; ++i)
      if (monitor.judge(made_.next(), engraving.plan.path, 0.0, false, &place_)) return true;
    return false;
  };
  EXPECT_FALSE(stopped(0.0));
  EXPECT_FALSE(stopped(15.0));
  EXPECT_TRUE(stopped(30.0));
}

TEST_F(Blocked, ByAGapInWhichTheTipSinks) {
  made_.F_ext[2] = 5.0;
  made_.surface = {SurfaceStatus::ok, Vector3d::UnitZ(), 0.0};
  EXPECT_EQ(cycles(), -1);
  made_.desired.along = 0.12;
  made_.F_ext[2] = 0.0;
  made_.surface.distance = -1.4e-3;
  EXPECT_EQ(cycles(), -1);
  made_.surface.distance = -1.6e-3;
  ASSERT_EQ(cycles(), 1);
  EXPECT_NEAR(place_->from, 0.1, 1e-12) << "where the surface held the tip last";
  EXPECT_NEAR(place_->to, 0.12, 1e-12);
  made_.out.mode = ContactMode::lift;
  EXPECT_EQ(cycles(), -1) << "it is on its way up";
}

// Cameras that err together put the surface millimetres beside where it is, which the run's first
// touch tells: before it, no gap is certain.
TEST_F(Blocked, ByAGapBelowWhereASurfaceWasFelt) {
  const auto deepest = [this] {
    monitor_.begin_path();
    made_.F_ext[2] = 0.0;
    made_.surface = {SurfaceStatus::ok, Vector3d::UnitZ(), 0.0};
    while (made_.surface.distance > -20e-3 && !judge()) made_.surface.distance -= 0.1e-3;
    return made_.surface.distance;
  };
  EXPECT_NEAR(deepest(), -9e-3, 0.2e-3);
  monitor_.begin_path();
  made_.surface.distance = -4e-3;
  made_.F_ext[2] = 5.0;
  EXPECT_EQ(cycles(), -1);
  EXPECT_NEAR(deepest(), -7e-3, 0.2e-3);
  made_.surface.distance = 2e-3;
  made_.F_ext[2] = 5.0;
  EXPECT_EQ(cycles(), -1);
  EXPECT_NEAR(deepest(), -3e-3, 0.2e-3);
}

// A surface that falls under a pen that moves along it is followed; what gives way under a pen that
// only goes down is a gap.
TEST_F(Blocked, ByAGapAlongWhoseSideTheTipGoesDown) {
  const auto falls = [this](const Vector3d& v) {
    monitor_.begin_path();
    made_.F_ext[2] = 5.0;
    made_.arm.V_WE.head<3>() = v;
    made_.surface = {SurfaceStatus::ok, Vector3d::UnitZ(), 0.0};
    EXPECT_EQ(cycles(), -1);
    for (int i = 0; i < 60; ++i) {
      made_.surface.distance += 1e-3 * v.z();
      if (judge()) return true;
    }
    return false;
  };
  EXPECT_TRUE(falls({0.0, 0.0, -0.05}));
  EXPECT_FALSE(falls({0.05, 0.0, -0.05}));
}

TEST_F(Blocked, WhereThePenRetreatsAndTheCamerasSawNoSurface) {
  made_.out.mode = ContactMode::retreat;
  EXPECT_EQ(cycles(), -1) << "the cameras saw one: a fault of perception";
  made_.out.mode = ContactMode::contact;
  EXPECT_EQ(cycles(), -1);
  made_.arm.X_WE.p.z() += 0.5;
  behind(Vector3d::Zero());
  made_.out.mode = ContactMode::retreat;
  EXPECT_EQ(cycles(), 1);
  EXPECT_EQ(cycles(), -1) << "told once";
}

TEST_F(Blocked, WhereARattleTellsOfSomethingThatTheCamerasDoNotResolve) {
  EXPECT_FALSE(judge());
  EXPECT_TRUE(judge(true));
  ASSERT_TRUE(place_);
  EXPECT_EQ(place_->stroke, 0);
}

// Between strokes it is the one that the plan comes down to; going there, the next if asked for.
TEST_F(Blocked, APlaceBetweenStrokesIsWhereThePlanComesDown) {
  const TipPath& path = bowl().plan.path;
  const StrokeTimes& first = path.strokes().front();
  PathSample up;
  up.stroke = -1;
  EXPECT_FALSE(place_on_path(up, path, first.approach - 0.1, false));
  for (const auto& [planned, ahead] :
       {std::pair(first.approach - 0.1, true), std::pair(first.approach + 1e-3, false)}) {
    const auto place = place_on_path(up, path, planned, ahead);
    ASSERT_TRUE(place);
    EXPECT_EQ(place->stroke, first.number);
    EXPECT_NEAR(place->from, 0.0, 1e-3);
  }
  EXPECT_FALSE(place_on_path(up, path, path.strokes().back().end + 0.1, true));
}

TEST(BlockMonitor, FeelsNothingWithoutAMeasuredWrench) {
  const Prepared e = prepared("bowl-sine-natural");
  BlockMonitor monitor(e);
  EXPECT_FALSE(monitor.feels());
  MadeUpCycle made;
  made.desired.stroke = 0;
  std::optional<StrokePart> place;
  EXPECT_FALSE(monitor.judge(made.next(), e.plan.path, 0.0, true, &place));
  EXPECT_FALSE(place);
}

}  // namespace
}  // namespace impedraw
