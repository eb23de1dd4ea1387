// A capture that is played back in time, or that cameras stream into: what its frames show and
// when, and drawings on a canvas that stands, or moves as they show.
#include "impedraw/run/streamed_capture.h"

#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <Eigen/Geometry>

#include "capture/grey_png.h"
#include "drawn_scenario.h"
#include "impedraw/capture/capture.h"
#include "impedraw/common/errors.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

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
  // Images of the standard cameras at time 0 and, from then on, `rate` times a second. noise: of
  // the depths, at 1 m [m].
  void film(const Canvas& canvas, const CanvasMotion& motion, double rate, double until,
            double noise = 0.0) {
    std::string views;
    const std::vector<DepthCamera> cameras = standard_cameras();
    for (int k = 0; k <= static_cast<int>(rate * until); ++k)
      for (std::size_t c = 0; c < cameras.size(); ++c) {
        const double time = k / rate;
        const std::string name = fmt::format("d{}_{}.png", c, k);
        write_grey_png(folder_ / name,
                       image(canvas, k ? motion.at(time).X_WK : Pose(), cameras[c].X_WC, noise));
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

  static GreyImage image(const Canvas& canvas, const Pose& X_WK, const Pose& X_WC,
                         double noise = 0.0) {
    static std::mt19937 random(1);
    std::normal_distribution<double> normal;
    GreyImage image{kPlayedWidth, kPlayedHeight, {}};
    const Pose X_KC = X_WK.inverse() * X_WC;
    for (int j = 0; j < kPlayedHeight; ++j)
      for (int i = 0; i < kPlayedWidth; ++i) {
        const auto hit = canvas.ray(X_KC.p, X_KC.R * *kLens.direction_C(i, j));
        const double z = hit ? hit->t + noise * hit->t * hit->t * normal(random) : 0.0;
        image.values.push_back(static_cast<std::uint16_t>(std::lround(z / kScale)));
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

  // A canvas that moves slowly, and a short drawing.
  const std::vector<std::string> slow_ = {"canvas.motion.sway=[0, 0.02, 0]",
                                          "canvas.motion.sway_frequency=0.2",
                                          "canvas.motion.roll=0.02",
                                          "drawing.text.text=-",
                                          "drawing.placement.fit_radius=0.03",
                                          "perception.watch=3",
                                          "canvas.motion.ramp=1"};
};

TEST_F(PlayedCaptureFolder, FramesComeInTimeAndShowTheCanvasThroughAnyLens) {
  const Scenario swaying = resolve_scenario("moving-shape");
  Prepared truth = prepare(swaying);
  const CanvasMotion& motion = truth.truth.world->canvas_motion();
  film(*truth.truth.canvas, motion, 5.0, 1.0);
  const Scenario s = resolve_scenario("moving-shape", played());
  const auto film_of = capture_frames(s.perception, truth.belief.arm);
  CanvasFrame frame;
  EXPECT_FALSE(film_of->next(0.2 + s.perception.frames.latency - 1e-6, &frame));
  int frames = 0;
  double last = 0.0;
  while (film_of->next(1.0 + s.perception.frames.latency + 1e-9, &frame)) {
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
  Prepared truth = prepare(resolve_scenario("moving-shape", slow_));
  film(*truth.truth.canvas, truth.truth.world->canvas_motion(), 10.0, 14.0);
  const Figures f = draw_scenario("moving-shape", played(slow_));
  EXPECT_GT(f["contact_fraction"], 0.999);
  EXPECT_LT(f["ink_error_rms"], 0.3);
  EXPECT_GT(f["coverage"], 0.97);
  EXPECT_LT(f["force_sd"], 0.4);
}

// Cameras as noisy as real ones: the tracker learns it from their first images.
TEST_F(PlayedCaptureFolder, NoisyFramesAreFollowed) {
  Prepared truth = prepare(resolve_scenario("moving-shape", slow_));
  film(*truth.truth.canvas, truth.truth.world->canvas_motion(), 10.0, 14.0, 1.5e-3);
  const Figures f = draw_scenario("moving-shape", played(slow_));
  EXPECT_GT(f["contact_fraction"], 0.99);
  EXPECT_LT(f["ink_error_rms"], 0.5);
  EXPECT_GT(f["coverage"], 0.95);
}

// Where the canvas would be by then nobody knows: the pen waits where it was foreseen.
TEST_F(PlayedCaptureFolder, ACaptureThatEndsTooEarlyIsNamed) {
  Prepared truth = prepare(resolve_scenario("moving-shape", slow_));
  film(*truth.truth.canvas, truth.truth.world->canvas_motion(), 10.0, 6.0);
  Prepared drawing = prepare(resolve_scenario("moving-shape", played(slow_)));
  const std::filesystem::path log = folder_ / "run.h5";
  const RunOutcome outcome = run(drawing, log, 0.0);
  EXPECT_EQ(outcome.end, RunEnd::stopped);
  EXPECT_THAT(outcome.cause,
              ContainsRegex("no camera has known the canvas for 45 s.*; the last frame came of "
                            "camera 0 at t = 6\\.. s, of camera 1 .*, of camera 2 at t = 6"));
}

TEST_F(PlayedCaptureFolder, WhatCannotBePlayedIsSaid) {
  const auto error_of = [&](const std::vector<std::string>& more) {
    try {
      const Scenario s = resolve_scenario("moving-shape", played(more));
      Prepared e = prepare(s);
      capture_frames(s.perception, e.belief.arm);
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
  const auto film_of = capture_frames(s.perception, truth.belief.arm);
  int frames = 0;
  for (CanvasFrame frame; film_of->next(9.0, &frame);) ++frames;
  EXPECT_EQ(frames, 2);
}

double clock_now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

// The canvas as cameras that stream into the folder see it.
class StreamedCaptureFolder : public PlayedCaptureFolder {
 protected:
  explicit StreamedCaptureFolder()
      : truth_(prepare(resolve_scenario("moving-shape", slow_))), cameras_(standard_cameras()) {
    film(canvas(), truth_.truth.world->canvas_motion(), 1.0, 0.0);
  }

  const Canvas& canvas() const { return *truth_.truth.canvas; }

  std::filesystem::path live(int camera, double stamp) const {
    return folder_ / fmt::format("live_{}_{}.png", camera, std::llround(1e6 * stamp));
  }
  void stream(int camera, double stamp, const Pose& X_WK = {}) const {
    const auto part = folder_ / fmt::format(".live_{}", camera);
    write_grey_png(part, image(canvas(), X_WK, cameras_[static_cast<std::size_t>(camera)].X_WC));
    std::filesystem::rename(part, live(camera, stamp));
  }

  // Draws in step with the clock while cameras stream, until the run's time `until` [s]; soon after
  // that as fast as may be.
  RunOutcome draw(bool moves, double until, Metrics* metrics = nullptr) {
    std::vector<std::string> more = slow_;
    if (!moves) more.insert(more.end(), {"canvas.motion.sway=[0, 0, 0]", "canvas.motion.roll=0"});
    Prepared drawing = prepare(resolve_scenario("moving-shape", played(more)));
    stream(0, clock_now());
    const CanvasMotion& motion = drawing.truth.world->canvas_motion();
    std::atomic<double> begun = 0.0;
    std::atomic<bool> ends = false;
    std::thread writer([&] {
      std::vector<std::filesystem::path> kept;
      for (int k = 0; !ends; ++k) {
        const double now = clock_now(), time = begun > 0.0 ? now - begun : 0.0;
        if (time > until) return;
        stream(k % 3, now, motion.at(time).X_WK);
        kept.push_back(live(k % 3, now));
        if (kept.size() > 60) std::filesystem::remove(kept[kept.size() - 60]);
        std::this_thread::sleep_for(std::chrono::milliseconds(30));
      }
    });
    RunHooks hooks;
    hooks.held = [&](double time) {
      if (begun == 0.0) begun = clock_now() - time;
      if (time > until + 2.0 || clock_now() - begun >= time) return false;
      std::this_thread::sleep_for(std::chrono::microseconds(500));
      return true;
    };
    const std::filesystem::path log = folder_ / "run.h5";
    const RunOutcome outcome = run(drawing, log, 0.0, hooks);
    ends = true;
    writer.join();
    if (metrics) *metrics = compute_metrics(read_run(log));
    return outcome;
  }

  Prepared truth_;
  std::vector<DepthCamera> cameras_;
};

TEST_F(StreamedCaptureFolder, FramesAreTakenAsTheyCome) {
  stream(0, clock_now());
  const Scenario s = resolve_scenario("moving-shape", played());
  ArmModel arm = truth_.belief.arm;
  const auto frames = capture_frames(s.perception, arm);
  ASSERT_TRUE(frames->streams());
  const double begun = clock_now() - 5.0;
  const auto time = [begun] { return clock_now() - begun; };
  CanvasFrame frame;
  // True once there is one, and false if none comes soon.
  const auto comes = [&](int polls) {
    for (int i = 0; i < polls; ++i) {
      if (frames->next(time(), &frame)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  };
  constexpr int kSoon = 5000, kNot = 30;
  EXPECT_FALSE(frames->next(0.0, &frame)) << "before the loop has begun";
  EXPECT_FALSE(comes(kNot)) << "what was exposed before is of no use";

  JointVector q = truth_.belief.start_q;
  const double noted = time();
  frames->note_joints(noted, q);
  q[1] += 0.3;
  frames->note_joints(noted + 0.5, q);
  const Pose X_WK{{0.01, 0.02, 0.0}, Eigen::Matrix3d::Identity()};
  const double stamp = clock_now();
  stream(1, stamp, X_WK);
  ASSERT_TRUE(comes(kSoon));
  EXPECT_NEAR(frame.time, stamp - begun, 1e-3);
  EXPECT_EQ(frame.camera, 1);
  const Pose X_KC = X_WK.inverse() * frame.camera_model->X_WC;
  int seen = 0;
  for (int j = 0; j < frame.depth->height; j += 5)
    for (int i = 0; i < frame.depth->width; i += 5) {
      const double z = frame.depth->at(i, j);
      if (!std::isfinite(z)) continue;
      ++seen;
      EXPECT_LT(canvas().closest(X_KC * (z * frame.camera_model->direction_C(i, j))).distance,
                1e-3);
    }
  EXPECT_GT(seen, 300);
  const std::vector<BodyCapsule> body = arm.body_capsules(truth_.belief.start_q);
  ASSERT_EQ(frame.arm.size(), body.size()) << "the arm as it was then";
  EXPECT_EQ(frame.arm.back().a_W, body.back().a_W);

  stream(1, stamp - 0.02);
  EXPECT_FALSE(comes(kNot)) << "older than the last";
  stream(2, clock_now() + 60.0);
  EXPECT_FALSE(comes(kNot)) << "of the future";
  for (const char* other :
       {"live_9_1.png", "live_0_.png", "live_-1_1.png", "live_0_99999999999999999999.png",
        "live_0_nan.png", "live_0_1.png.part"})
    std::filesystem::copy_file(live(1, stamp), folder_ / other);
  std::ofstream(live(0, clock_now())) << "cut";
  EXPECT_FALSE(comes(kNot)) << "damaged";
  ASSERT_EQ(mkfifo(live(0, clock_now()).c_str(), 0600), 0);
  EXPECT_FALSE(comes(kNot)) << "a pipe, which would block";
  std::filesystem::create_directory(live(0, clock_now()));
  EXPECT_FALSE(comes(kNot)) << "a folder";
  const double last = clock_now();
  for (int k = 4; k >= 0; --k) stream(0, last - 1e-3 * k);
  stream(2, last);
  ASSERT_TRUE(comes(kSoon));
  EXPECT_EQ(frame.camera, 0);
  EXPECT_NEAR(frame.time, last - begun, 1e-3) << "the newest alone";
  ASSERT_TRUE(comes(kSoon));
  EXPECT_EQ(frame.camera, 2) << "the future of one does not hide it";
  EXPECT_FALSE(comes(kNot));
  std::filesystem::remove_all(folder_);
  EXPECT_FALSE(comes(kNot)) << "while the folder is replaced";
  EXPECT_THAT(frames->remark(),
              ContainsRegex("taken: 1 of views.0., 4 passed over for newer ones, 3 that cannot be "
                            "read.*, 1 of views.1.*, 1 of views.2.*; known .* ms after exposure"));
}

TEST_F(StreamedCaptureFolder, ACanvasThatStandsAndOneThatMovesAreDrawnOn) {
  for (const bool moves : {false, true}) {
    SCOPED_TRACE(moves);
    Metrics metrics;
    const RunOutcome outcome = draw(moves, 1e9, &metrics);
    EXPECT_EQ(outcome.end, RunEnd::finished) << outcome.cause;
    EXPECT_GT(metrics.contact_fraction.or_nan(), 0.99) << outcome.frames;
    EXPECT_LT(metrics.ink_error_rms.or_nan(), 0.5);
    EXPECT_GT(metrics.coverage.or_nan(), 0.95);
    EXPECT_THAT(outcome.frames, Not(HasSubstr("read")));
  }
}

TEST_F(StreamedCaptureFolder, AStreamThatEndsIsNamed) {
  for (const bool moves : {false, true}) {
    SCOPED_TRACE(moves);
    const RunOutcome outcome = draw(moves, 5.0);
    EXPECT_EQ(outcome.end, RunEnd::stopped);
    EXPECT_THAT(outcome.cause, HasSubstr("no camera has known the canvas for 45 s"));
    EXPECT_THAT(
        outcome.cause,
        ContainsRegex("the last frame came of camera 0 at t = [45]\\.. s, of camera 1 at t = "
                      "[45]\\.. s, of camera 2 at t = [45]\\.. s$"));
    EXPECT_THAT(outcome.frames, HasSubstr("of views[2], none for "));
  }
}

TEST_F(StreamedCaptureFolder, WithoutAStreamNothingIsDrawn) {
  const Scenario s = resolve_scenario("moving-shape", played());
  const auto error = [&] {
    try {
      capture_frames(s.perception, truth_.belief.arm);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(error(), HasSubstr("./impedraw capture --stream"));
  stream(0, clock_now() - 300.0);
  EXPECT_THAT(error(), HasSubstr("the newest frame in its folder is 300 s old"));
  stream(1, clock_now());
  EXPECT_EQ(error(), "");
}

}  // namespace
}  // namespace impedraw
