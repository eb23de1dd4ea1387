// A capture that is played back in time: what its frames show and when, and a drawing on a canvas
// that moves as they show.
#include "impedraw/run/played_capture.h"

#include <cmath>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <Eigen/Geometry>

#include "drawn_scenario.h"
#include "impedraw/capture/png_image.h"
#include "impedraw/common/errors.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

constexpr double kScale = 1e-4;  // [m]
constexpr int kPlayedWidth = 212, kPlayedHeight = 160;
const Lens kLens = {.width = kPlayedWidth,
                    .height = kPlayedHeight,
                    .fx = 190.0,
                    .fy = 189.0,
                    .cx = 108.3,
                    .cy = 77.6,
                    .model = Lens::Model::brown_conrady,
                    .k = {0.02, -0.05, 3e-4, -2e-4, 0.01}};

class PlayedCaptureFolder : public ScratchFolder {
 protected:
  // Images of the standard cameras at time 0 and, from then on, `rate` times a second.
  void film(const Canvas& canvas, const CanvasMotion& motion, double rate, double until) {
    std::string views;
    const std::vector<DepthCamera> cameras = standard_cameras();
    for (int k = 0; k <= static_cast<int>(rate * until); ++k)
      for (std::size_t c = 0; c < cameras.size(); ++c) {
        const double time = k / rate;
        const std::string name = fmt::format("d{}_{}.png", c, k);
        write_grey_png(folder_ / name,
                       image(canvas, k ? motion.at(time).X_WK : Pose(), cameras[c].X_WC));
        const Pose& X = cameras[c].X_WC;
        const Eigen::Quaterniond q(X.R);
        views += fmt::format(
            R"({}{{"depth": "{}", "depth_scale": {}, "width": {}, "height": {}, "fx": {}, )"
            R"("fy": {}, "cx": {}, "cy": {}, "distortion": {{"model": "brown_conrady", )"
            R"("coefficients": [{}]}}, )"
            R"("X_WC": {{"p": [{}, {}, {}], "q_wxyz": [{}, {}, {}, {}]}}, "time": {}}})",
            views.empty() ? "" : ",\n", name, kScale, kLens.width, kLens.height, kLens.fx, kLens.fy,
            kLens.cx, kLens.cy, fmt::join(kLens.k, ", "), X.p.x(), X.p.y(), X.p.z(), q.w(), q.x(),
            q.y(), q.z(), time);
      }
    write("capture.json",
          R"({"format": "impedraw-capture", "version": 1, "views": [)" + views + "]}");
  }

  static GreyImage image(const Canvas& canvas, const Pose& X_WK, const Pose& X_WC) {
    GreyImage image{kPlayedWidth, kPlayedHeight, {}};
    const Pose X_KC = X_WK.inverse() * X_WC;
    for (int j = 0; j < kPlayedHeight; ++j)
      for (int i = 0; i < kPlayedWidth; ++i) {
        const auto hit = canvas.ray(X_KC.p, X_KC.R * *kLens.direction_C(i, j));
        image.values.push_back(hit ? static_cast<std::uint16_t>(std::lround(hit->t / kScale))
                                   : std::uint16_t{0});
      }
    return image;
  }

  std::vector<std::string> played(std::vector<std::string> more = {}) const {
    // Later settings win: `more` comes last.
    more.insert(
        more.begin(),
        {"perception.source=capture", "perception.capture=" + folder_.string(),
         "perception.frames.depth=true", "perception.fiducials.points=[]", "preflight.arm=false"});
    return more;
  }
};

TEST_F(PlayedCaptureFolder, FramesComeInTimeAndShowTheCanvasThroughAnyLens) {
  const Scenario swaying = resolve_scenario("moving-shape");
  Prepared truth = prepare(swaying);
  const CanvasMotion& motion = truth.truth.world->canvas_motion();
  film(*truth.truth.canvas, motion, 5.0, 1.0);
  const Scenario s = resolve_scenario("moving-shape", played());
  PlayedCapture film_of(s.perception, truth.belief.arm);
  CanvasFrame frame;
  EXPECT_FALSE(film_of.next(0.2 + s.perception.frames.latency - 1e-6, &frame));
  int frames = 0;
  double last = 0.0;
  while (film_of.next(1.0 + s.perception.frames.latency + 1e-9, &frame)) {
    EXPECT_GE(frame.time, last);
    last = frame.time;
    EXPECT_EQ(frame.camera, frames % 3);
    ++frames;
    ASSERT_TRUE(frame.depth && frame.camera_model);
    const Pose X_KC = motion.at(frame.time).X_WK.inverse() * frame.camera_model->X_WC;
    double squares = 0.0;
    int seen = 0;
    for (int j = 0; j < frame.depth->height; j += 3)
      for (int i = 0; i < frame.depth->width; i += 3) {
        const double z = frame.depth->at(i, j);
        if (!std::isfinite(z)) continue;
        const SurfacePoint on =
            truth.truth.canvas->closest(X_KC * (z * frame.camera_model->direction_C(i, j)));
        squares += on.distance * on.distance;
        ++seen;
      }
    EXPECT_GT(seen, 500);
    EXPECT_LT(std::sqrt(squares / seen), 0.15e-3);
  }
  EXPECT_EQ(frames, 15);
}

TEST_F(PlayedCaptureFolder, ADrawingFollowsWhatIsPlayed) {
  const std::vector<std::string> slow = {"canvas.motion.sway=[0, 0.02, 0]",
                                         "canvas.motion.sway_frequency=0.2",
                                         "canvas.motion.roll=0.02",
                                         "drawing.text.text=-",
                                         "drawing.placement.fit_radius=0.03",
                                         "perception.watch=3",
                                         "canvas.motion.ramp=1"};
  Prepared truth = prepare(resolve_scenario("moving-shape", slow));
  film(*truth.truth.canvas, truth.truth.world->canvas_motion(), 10.0, 14.0);
  const Figures f = draw_scenario("moving-shape", played(slow));
  EXPECT_GT(f["contact_fraction"], 0.999);
  EXPECT_LT(f["ink_error_rms"], 0.3);
  EXPECT_GT(f["coverage"], 0.97);
  EXPECT_LT(f["force_sd"], 0.4);
}

TEST_F(PlayedCaptureFolder, WhatCannotBePlayedIsSaid) {
  const auto error_of = [&](const std::vector<std::string>& more) {
    try {
      const Scenario s = resolve_scenario("moving-shape", played(more));
      Prepared e = prepare(s);
      PlayedCapture(s.perception, e.belief.arm);
      return std::string("no error");
    } catch (const InputError& e) {
      return std::string(e.what());
    }
  };
  Prepared truth = prepare(resolve_scenario("moving-shape"));
  film(*truth.truth.canvas, truth.truth.world->canvas_motion(), 1.0, 0.0);
  EXPECT_THAT(error_of({}), HasSubstr("no view has a 'time' above 0"));
  film(*truth.truth.canvas, truth.truth.world->canvas_motion(), 2.0, 0.5);
  EXPECT_EQ(error_of({}), "no error");
  EXPECT_THAT(error_of({"perception.frames.depth=false"}), HasSubstr("perception.frames.depth"));
  // A frame that cannot be read is left out.
  std::ofstream(folder_ / "d1_1.png") << "cut";
  const Scenario s = resolve_scenario("moving-shape", played());
  PlayedCapture film_of(s.perception, truth.belief.arm);
  int frames = 0;
  for (CanvasFrame frame; film_of.next(9.0, &frame);) ++frames;
  EXPECT_EQ(frames, 2);
}

}  // namespace
}  // namespace impedraw
