// Drawings on a bowl that moves, judged in its own frame, against the limits of bounds.json.
#include <cmath>

#include <fmt/format.h>

#include "drawn_scenario.h"
#include "impedraw/common/errors.h"
#include "impedraw/simulation/canvas_motion.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

TEST(MovingCanvas, Conveyor) {
  draw_within_bounds("moving-conveyor");
  draw_within_bounds("moving-conveyor-M");
}
TEST(MovingCanvas, Turntable) {
  draw_within_bounds("moving-turntable");
  draw_within_bounds("moving-turntable-M");
}
TEST(MovingCanvas, Heave) {
  draw_within_bounds("moving-heave");
  draw_within_bounds("moving-heave-M");
}
TEST(MovingCanvas, Sway) {
  draw_within_bounds("moving-sway");
  draw_within_bounds("moving-sway-M");
}
TEST(MovingCanvas, Jolts) {
  draw_within_bounds("moving-jolts");
  draw_within_bounds("moving-jolts-M");
}
TEST(MovingCanvas, StandingIsWatchedAllTheSame) {
  draw_within_bounds("standing-noisy");
  draw_within_bounds("standing-noisy-M");
}
TEST(MovingCanvas, HalfASecondWithoutFramesInTheArmsShadow) {
  draw_within_bounds("moving-lost");
  draw_within_bounds("moving-lost-M");
}

// The frames stay away for so long that the estimate is no longer to be relied on.
TEST(MovingCanvas, PenLetsGoOfALostCanvasAndComesBack) {
  const Figures f =
      draw_scenario("moving-turntable", {"faults=[{kind: no_frames, start: 0.5, duration: 2}]"});
  EXPECT_GT(f.outcome.met.at("surface_lost"), 0.5);
  EXPECT_LT(f["force_peak"], 10.0);
  EXPECT_GT(f["coverage"], 0.99);
}

// With the motion told exactly what is left is the controller's error, and that of the normals.
TEST(MovingCanvas, ErrorsAreThoseOfTheEstimate) {
  for (const char* name : {"moving-heave", "moving-sway", "moving-jolts"}) {
    const Figures f = draw_scenario(name, {"perception.canvas_pose=true"});
    EXPECT_LT(f["ink_error_rms"], 0.03) << name;
    EXPECT_LT(f["ink_error_max"], 0.3) << name;
    EXPECT_LT(f["force_sd"], 0.05) << name;
  }
}

// A canvas that moves and is taken for one that stands is not drawn on: what following it is worth.
TEST(MovingCanvas, WithoutFollowingTheDrawingIsLost) {
  const Figures f = draw_scenario("moving-turntable", {"perception.frames.enabled=false"});
  EXPECT_GT(f["ink_error_rms"], 3.0);
}

// The same frames give the same drawing, whatever moved the canvas to where they show it: nothing
// that controls or plans reads canvas.motion. A turn of nothing about another centre is another
// motion with the same frames.
TEST(MovingCanvas, OnlyFramesTellHowItMoves) {
  const Figures one = draw_scenario("moving-heave"),
                other = draw_scenario("moving-heave", {"canvas.motion.centre=[0.1, 0.7, -0.3]"});
  // up to rounding of the canvas's pose
  EXPECT_NEAR(one["ink_error_rms"], other["ink_error_rms"], 1e-5);
  EXPECT_NEAR(one["force_sd"], other["force_sd"], 1e-5);
}

// A sinusoid that runs backwards in time is the same with the other sign: it is followed as well.
TEST(MovingCanvas, ASwingBackwardsInTimeIsFollowedAsWell) {
  const Figures one = draw_scenario("moving-heave"),
                other = draw_scenario("moving-heave", {"canvas.motion.sway=[0, 0, -0.05]"});
  EXPECT_NEAR(one["ink_error_rms"], other["ink_error_rms"], 0.3 * one["ink_error_rms"]);
  EXPECT_NEAR(one["force_sd"], other["force_sd"], 0.3 * one["force_sd"]);
}

// The same heave, as a tracker of the bowl's rim recorded it at 30 Hz, its ramp included.
class RecordedCanvas : public ScratchFolder {};

TEST_F(RecordedCanvas, IsDrawnOnAsTheMotionItself) {
  CanvasMotionSettings heave;
  heave.sway = {0.0, 0.0, 0.05};
  heave.sway_frequency = 0.5;
  heave.ramp = 2.0;
  const CanvasMotion motion(heave);
  std::string rows = "t,x,y,z,qw,qx,qy,qz\n";
  for (int i = 0; i <= 30 * 60; ++i) {
    const Eigen::Vector3d p = motion.at(i / 30.0).X_WK.p + Eigen::Vector3d(0.78, 0.0, 0.162);
    rows += fmt::format("{},{},{},{},1,0,0,0\n", i / 30.0, p.x(), p.y(), p.z());
  }
  const std::string file = write("rim.csv", rows).string();
  const Figures f =
      draw_scenario("moving-heave", {"canvas.motion.sway=[0, 0, 0]", "canvas.motion.file=" + file});
  const Figures direct = draw_scenario("moving-heave");
  EXPECT_NEAR(f["ink_error_rms"], direct["ink_error_rms"], 0.2 * direct["ink_error_rms"]);
  EXPECT_NEAR(f["force_sd"], direct["force_sd"], 0.2 * direct["force_sd"]);
}

// Two letters, and the bowl is moved by 60 mm after the first: the second waits until it stands.
TEST(MovingCanvas, PenWaitsWhileItIsMovedByHandBetweenStrokes) {
  const std::vector<std::string> moved = {
      "drawing.text.text=ll",         "drawing.placement.fit_radius=0.03",
      "canvas.motion.sway=[0, 0, 0]", "canvas.motion.velocity=[0, -0.04, 0]",
      "canvas.motion.start=9.6",      "canvas.motion.ramp=0.3",
      "canvas.motion.stop=11.1"};
  std::vector<std::string> waiting = moved;
  waiting.push_back("perception.frames.wait_for_rest=true");
  const auto share_moving = [](const Figures& f) {  // of the contact, while the bowl moves [s]
    double time = 0.0;
    for (std::size_t i = 1; i < f.run.time.size(); ++i) {
      const bool moves = f.run.time[i] > 9.9 && f.run.time[i] < 11.3;
      if (moves && f.run.contact_force[i].norm() > 0.5) time += f.run.time[i] - f.run.time[i - 1];
    }
    return time;
  };
  const Figures follows = draw_scenario("moving-heave", moved),
                waits = draw_scenario("moving-heave", waiting);
  EXPECT_GT(share_moving(follows), 0.3) << "the second letter is drawn meanwhile";
  EXPECT_LT(share_moving(waits), share_moving(follows) - 0.3);
  EXPECT_GT(waits["coverage"], 0.999);
  EXPECT_LT(waits["ink_error_rms"], 0.1);
  EXPECT_GT(waits.run.time.size(), follows.run.time.size() + 500) << "steps of 1 ms";
}

// Marks are not needed where the canvas has a shape.
TEST(MovingCanvas, ShapeAloneTellsWhereItIs) {
  const Figures f = draw_scenario("moving-shape");
  EXPECT_GT(f["contact_fraction"], 0.999);
  EXPECT_LT(f["ink_error_rms"], 0.3);
  EXPECT_LT(f["force_sd"], 0.1);
  EXPECT_EQ(f.outcome.canvas_open, "");
}

// Both together: less noise of the pose, so a steadier force.
TEST(MovingCanvas, ShapeHelpsMarks) {
  const Figures f = draw_scenario("moving-jolts", {"perception.frames.depth=true"});
  EXPECT_GT(f["contact_fraction"], 0.999);
  EXPECT_LT(f["ink_error_rms"], 0.55);
  EXPECT_LT(f["force_sd"], 0.35);
}

// The surface under the pen is that of all frames, not that of the snapshot alone.
TEST(MovingCanvas, FramesAverageTheNoiseOfAStandingCanvasAway) {
  const Figures snapshot = draw_scenario(
      "standing-noisy", {"perception.frames.depth=true", "perception.frames.grow_surface=false"});
  const Figures grows = draw_scenario("standing-noisy", {"perception.frames.depth=true"});
  EXPECT_LT(grows["normal_error_mean"], 0.3 * snapshot["normal_error_mean"]);
  EXPECT_LT(grows["tilt_mean"], 0.3 * snapshot["tilt_mean"]);
  // The ink follows the estimate of the pose, not the normal.
  EXPECT_LT(grows["ink_error_rms"], 1.1 * snapshot["ink_error_rms"]);
}

// Waves along x look the same wherever they slide along y.
TEST(MovingCanvas, WhatTheShapeLeavesOpenIsNamed) {
  const Figures f =
      draw_scenario("moving-heave", {"perception.frames.depth=true", "perception.frames.rate=10",
                                     "canvas.kind=wave", "perception.fiducials.points=[]"});
  EXPECT_NE(f.outcome.canvas_open.find("slides along (0.0"), std::string::npos)
      << f.outcome.canvas_open;
  EXPECT_GT(f["contact_fraction"], 0.99);
}

// The bowl is in reach while it is drawn on, and soon after no more.
TEST(MovingCanvas, ArmDoesNotRunAfterWhatIsDrawn) {
  const std::string marks =
      "[{position: [0.78, 0.51, 0.162]}, {position: [0.6, 0.69, 0.162]}, "
      "{position: [0.42, 0.51, 0.162]}, {position: [0.6, 0.33, 0.162]}]";
  const Figures f = draw_scenario(
      "moving", {"drawing.text.text=o", "drawing.placement.fit_radius=0.015",
                 "drawing.placement.centre=[0.6, 0.51]", "canvas.move=[0, 0.51, 0]",
                 "canvas.motion.start=9.5", "canvas.motion.velocity=[0, -0.15, 0]",
                 "perception.region_lower=[0.25, -0.75, 0]",
                 "perception.region_upper=[1, 0.95, 0.6]", "perception.fiducials.points=" + marks});
  EXPECT_GT(f["coverage"], 0.999);
  EXPECT_LT(f["ink_error_rms"], 0.2);
}

TEST(MovingCanvas, LeavesTheReachAndIsLetGo) {
  const Figures f = draw_scenario("moving-conveyor",
                                  {"canvas.motion.start=1", "canvas.motion.velocity=[0, -0.09, 0]"},
                                  RunEnd::stopped);
  EXPECT_NE(f.outcome.cause.find("left the arm's reach"), std::string::npos) << f.outcome.cause;
  EXPECT_LT(f["force_peak"], 15.0);
}

std::string refused(const std::vector<std::string>& assignments) {
  try {
    draw_scenario("moving-heave", assignments, RunEnd::stopped);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(MovingCanvas, BadInputIsNamed) {
  EXPECT_NE(refused({"perception.fiducials.points=[{position: [0,0,0]}, {position: [1,0,0]}, "
                     "{position: [2,0,0]}]"})
                .find("straight line"),
            std::string::npos);
  EXPECT_NE(refused({"perception.fiducials.points=[]"}).find("0 points"), std::string::npos);
  EXPECT_NE(refused({"canvas.motion.file=nowhere.csv"}).find("canvas.motion"), std::string::npos);
  EXPECT_NE(refused({"perception.enabled=false"}).find("perception.frames.enabled"),
            std::string::npos);
}

TEST(MovingCanvas, CamerasThatNeverSeeItAreSaid) {
  const Figures f =
      draw_scenario("moving-heave",
                    {"perception.fiducials.points=[{position: [5,0,0]}, {position: [5,1,0]}, "
                     "{position: [5,0,1]}]"},
                    RunEnd::stopped);
  EXPECT_NE(f.outcome.cause.find("no camera saw three marks"), std::string::npos)
      << f.outcome.cause;
}

}  // namespace
}  // namespace impedraw
