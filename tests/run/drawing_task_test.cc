// The moves that drawings answer with. No arm moves: a made-up pen follows, is blocked, or loses
// the canvas.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "canvas/mesh_files.h"
#include "impedraw/run/drawings.h"
#include "impedraw/run/remaining.h"
#include "run/prepared.h"

namespace impedraw {
namespace {

using testing::HasSubstr;

// A pen at the end of the plan's way in, on a canvas in its place.
struct MadeUpPen {
  explicit MadeUpPen(Experiment& e) : experiment(e) {
    pen.q = e.belief.start_q;
    pen.X_WE = e.belief.arm.tip_pose(pen.q);
  }
  // Ink along a part of a stroke.
  void inks(int stroke, double from, double to) {
    ink.add(stroke, from, true);
    ink.add(stroke, to, true);
    ink.add(-1, 0.0, false);
  }
  // Ink all along the first stroke but for these shares of it.
  void inks_around(double from, double to) {
    const double length = plane_length(experiment.plan.strokes[0]);
    inks(0, 0.0, from * length);
    inks(0, to * length, length);
  }
  void inks_all() {
    for (std::size_t i = 0; i < experiment.plan.strokes.size(); ++i)
      inks(static_cast<int>(i), 0.0, plane_length(experiment.plan.strokes[i]));
  }
  Situation now() const { return {pen, canvas, nullptr, history, ink, last}; }

  Experiment& experiment;
  CarriedPen pen;
  CanvasStatus canvas = CanvasStatus::ok;
  CanvasHistory history{Eigen::Vector3d::Zero()};
  InkWatch ink;
  PathEnd last;
};

TEST(StandingDrawing, DrawsItsPlanAndEnds) {
  Experiment e = prepared("bowl-sine");
  StandingDrawing drawing(e, e.plan.path);
  MadeUpPen pen(e);
  const Move move = drawing.next(pen.now());
  EXPECT_EQ(move.kind, Move::Kind::draw);
  EXPECT_EQ(move.path.duration(), e.plan.path.duration());
  EXPECT_FALSE(move.again);
  pen.inks_all();
  const Move end = drawing.next(pen.now());
  EXPECT_EQ(end.kind, Move::Kind::end);
  EXPECT_EQ(end.cause, "");
  EXPECT_TRUE(drawing.record().drawn_again.empty());
}

TEST(StandingDrawing, DrawsAGapOnceMore) {
  Experiment e = prepared("bowl-sine");
  StandingDrawing drawing(e, e.plan.path);
  MadeUpPen pen(e);
  drawing.next(pen.now());
  pen.inks_around(0.3, 0.4);
  const Move move = drawing.next(pen.now());
  ASSERT_EQ(move.kind, Move::Kind::draw);
  EXPECT_TRUE(move.again);
  ASSERT_EQ(drawing.record().drawn_again.size(), 1u);
  EXPECT_NEAR(drawing.record().drawn_again[0].from, 0.3 * plane_length(e.plan.strokes[0]), 1e-12);
  EXPECT_EQ(drawing.next(pen.now()).kind, Move::Kind::end) << "once";
}

// A gap that lies low may be behind a height that the first pass went over.
TEST(StandingDrawing, GoesToAGapAsHighAsTheFirstPassWent) {
  Experiment e = prepared("bowl-sine");
  StandingDrawing drawing(e, e.plan.path);
  MadeUpPen pen(e);
  drawing.next(pen.now());
  pen.inks_around(0.49, 0.51);
  pen.pen.X_WE = Pose{e.plan.path.at(e.plan.path.duration()).reference.p_WD, pen.pen.X_WE.R};
  const Move move = drawing.next(pen.now());
  ASSERT_EQ(move.kind, Move::Kind::draw);
  const auto highest = [&](const TipPath& path) {
    double z = -1.0;
    for (double t = 0.5 * path.duration(); t <= path.duration(); t += 1e-2)
      z = std::max(z, path.at(t).reference.p_WD.z());
    return z;
  };
  EXPECT_GT(highest(move.path), highest(e.plan.path) - 1e-3);
}

// What came to lie over the gap, as far as the plan knows, bars the way there.
TEST(StandingDrawing, LeavesAGapToWhichNoWayLeads) {
  Experiment e = prepared("bowl-sine");
  StandingDrawing drawing(e, e.plan.path);
  MadeUpPen pen(e);
  drawing.next(pen.now());
  pen.inks_around(0.49, 0.51);
  const PlacedStroke& stroke = e.plan.strokes[0];
  const Eigen::Vector2d middle = place_on(stroke, 0.5 * plane_length(stroke)).p_P;
  TriangleMesh block = box(0.04, 0.04, 0.1);
  const Eigen::Vector3d p = e.artwork.X_WP * e.surface()(middle.x(), middle.y())->p_P;
  for (Eigen::Vector3d& v : block.vertices) v += p - Eigen::Vector3d(0.02, 0.02, 0.0);
  e.belief.obstacle = std::make_shared<const Canvas>(block);
  EXPECT_EQ(drawing.next(pen.now()).kind, Move::Kind::end);
  EXPECT_FALSE(drawing.record().walls.empty());
}

// A pen that is blocked in the middle of the stroke, with ink from `from` on, as a share of it.
Move goes_around(StandingDrawing* drawing, MadeUpPen* pen, double length, double from) {
  drawing->next(pen->now());
  const double at = 0.5 * length;
  pen->inks(0, from * length, at - BlockedPlaces::kBefore);
  pen->last.blocked = StrokePart{0, at, at};
  Move around = drawing->next(pen->now());
  pen->inks(0, at + BlockedPlaces::kBeyond, length);
  pen->last = {};
  return around;
}

TEST(StandingDrawing, GoesOnBehindABlockedPlaceAndDoesNotDrawItAgain) {
  Experiment e = prepared("bowl-sine");
  StandingDrawing drawing(e, e.plan.path);
  MadeUpPen pen(e);
  const Move around = goes_around(&drawing, &pen, plane_length(e.plan.strokes[0]), 0.0);
  ASSERT_EQ(around.kind, Move::Kind::draw);
  EXPECT_FALSE(around.again);
  ASSERT_EQ(around.path.strokes().size(), 1u);
  EXPECT_LT(around.path.strokes()[0].length, 1.5 * e.plan.path.strokes()[0].length / 2.0);
  EXPECT_EQ(drawing.next(pen.now()).kind, Move::Kind::end);
  ASSERT_EQ(drawing.record().walls.size(), 1u);
}

// What lacks ink before a blocked place is left for the end: a pad would treat it once more after
// each such place.
TEST(StandingDrawing, LeavesWhatItPassedForTheEnd) {
  Experiment e = prepared("bowl-sine");
  StandingDrawing drawing(e, e.plan.path);
  MadeUpPen pen(e);
  const double length = plane_length(e.plan.strokes[0]);
  const Move around = goes_around(&drawing, &pen, length, 0.1);
  EXPECT_EQ(around.path.strokes().size(), 1u);
  const Move again = drawing.next(pen.now());
  EXPECT_TRUE(again.again);
  ASSERT_EQ(drawing.record().drawn_again.size(), 1u);
  EXPECT_NEAR(drawing.record().drawn_again[0].to, 0.1 * length, 1e-12);
}

// A pad that goes by within half of its radius treats.
TEST(FaceReach, IsHalfAPadsRadiusAndNothingForAPen) {
  EXPECT_EQ(face_reach(prepared("bowl-sine")), 0.0);
  EXPECT_NEAR(face_reach(prepared("bowl-sine", {"tool.kind=pad", "tool.radius=0.02"})), 0.01,
              1e-12);
}

TEST(TouchedDrawing, GoesStrokeByStrokeThenUp) {
  Experiment e =
      prepared("bowl-sine-touch", {"drawing.text.text=il", "drawing.placement.width=20"});
  TouchedDrawing drawing(e, e.plan.strokes);
  MadeUpPen pen(e);
  const int strokes = static_cast<int>(e.plan.strokes.size());
  ASSERT_GE(strokes, 2);
  for (int i = 0; i < strokes; ++i) {
    const Move move = drawing.next(pen.now());
    ASSERT_EQ(move.kind, Move::Kind::draw);
    EXPECT_EQ(move.touch->before, i);
    EXPECT_EQ(move.touch->all, strokes);
    if (i == 0) pen.inks(0, 0.0, plane_length(e.plan.strokes[0]));
  }
  EXPECT_EQ(drawing.next(pen.now()).kind, Move::Kind::lift);
  for (int i = 1; i < strokes; ++i) {
    const Move move = drawing.next(pen.now());
    ASSERT_EQ(move.kind, Move::Kind::draw);
    EXPECT_TRUE(move.again);
    EXPECT_EQ(move.touch->all, strokes - 1);
  }
  EXPECT_EQ(drawing.next(pen.now()).kind, Move::Kind::lift);
  EXPECT_EQ(drawing.next(pen.now()).kind, Move::Kind::end);
}

TEST(MovingDrawing, WatchesFirstAndEndsIfNoCameraSeesTheCanvas) {
  Experiment e = prepared("standing-noisy");
  MovingDrawing drawing(e, 0.0);
  MadeUpPen pen(e);
  pen.pen.time = 0.25;
  const Move watch = drawing.next(pen.now());
  EXPECT_EQ(watch.kind, Move::Kind::wait);
  EXPECT_EQ(watch.until, 0.25 + e.scenario.perception.watch);
  pen.canvas = CanvasStatus::lost;
  const Move end = drawing.next(pen.now());
  EXPECT_EQ(end.kind, Move::Kind::end);
  EXPECT_THAT(end.cause, HasSubstr("no camera saw three marks of the canvas"));
}

TEST(MovingDrawing, GivesAStrokeUpThatLeavesTheReachTimeAndAgain) {
  Experiment e = prepared("standing-noisy", {"drawing.skip_unreachable=true"});
  MovingDrawing drawing(e, 5.0);
  MadeUpPen pen(e);
  EXPECT_EQ(drawing.next(pen.now()).kind, Move::Kind::lift) << "of a resumed run";
  EXPECT_EQ(drawing.next(pen.now()).kind, Move::Kind::wait);
  pen.last.left_reach = true;
  for (int i = 0; i < MovingDrawing::kMostLeft; ++i) {
    ASSERT_EQ(drawing.next(pen.now()).kind, Move::Kind::draw);
    EXPECT_TRUE(drawing.record().unreached.empty());
  }
  drawing.next(pen.now());
  ASSERT_EQ(drawing.record().unreached.size(), 1u);
  EXPECT_THAT(drawing.record().unreached[0].text, HasSubstr("left the arm's reach at t = 5.0"));
}

}  // namespace
}  // namespace impedraw
