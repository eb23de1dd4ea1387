// The frames of cameras that stream into a capture's folder while it is read: what ./impedraw
// capture --stream writes, or another program (docs/capture.md, "As it is taken").
//
// File     live_<view>_<µs>.png, depths of the camera of views[<view>] as that says, exposed
//          so many microseconds after 1970 by this machine's clock. It takes its name once it is
//          whole.
// Clock    a frame of stamp s is of the driver's time s − o; o: the least difference of both clocks
//          in the last 10 to 20 s. The loop's time is late by up to a cycle, or while it plans.
// Order    of each camera the newest frame counts; older ones are passed over.
// Arm      at the exposure, as the loop noted it.
#pragma once

#include <deque>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/capture/capture.h"
#include "impedraw/capture/lens.h"
#include "impedraw/common/exchange.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/perception/camera_correction.h"
#include "impedraw/run/frame_source.h"

namespace impedraw {

// A capture that is played back in time: its views after time 0 are the frames of cameras that keep
// capturing.
//
// A view of time t was exposed t after the run began, and arrives perception.frames.latency later.
// A camera is numbered as the first view of the capture from its place. Frames have no marks: the
// canvas is found by its shape. A view that cannot be read is left out.

// The standing cameras of a capture, by number. Makes frames of their images: depths are cleaned
// (capture/clean_view.h) and rectified (capture/lens.h) to perception.frames.width × height.
class CaptureCameras {
 public:
  // corrections: Belief's, of the views.
  CaptureCameras(const PerceptionSettings& settings, const ArmModel& arm,
                 std::vector<CameraCorrection> corrections);

  // Throws InputError for one too many.
  void add(int camera, const CapturedView& view);
  // The frame of a view whose depths are read now, the arm at view->joints; false: they cannot be
  // read. *frame is valid until the next call.
  bool show(int camera, CapturedView* view, CanvasFrame* frame);

 private:
  ArmModel arm_;
  std::vector<CameraCorrection> corrections_;
  int width_, height_;
  std::filesystem::path file_;  // capture.json
  std::map<int, Rectified> cameras_;
  DepthImage image_;
  std::vector<Capsule> body_;
};

class PlayedCapture : public FrameSource {
 public:
  // Throws InputError for cameras that move.
  PlayedCapture(Capture capture, double latency, CaptureCameras cameras);

  bool next(double time, CanvasFrame* frame) noexcept override;

 private:
  Capture capture_;
  double latency_;
  CaptureCameras cameras_;
  std::vector<int> camera_of_;  // of each frame
  std::size_t next_ = 0;
};

// The clock that stamps frames, this machine's, and the driver's [s].
class StreamClock {
 public:
  // Both, read together: how far a stamp is beyond the driver's time.
  double offset(double now, double time) noexcept;
  bool begun() const noexcept { return first_ > 0.0; }
  // The rate of the driver's time by the clock that it was read with, over all that was read.
  double rate() const noexcept { return (last_time_ - first_time_) / (last_ - first_); }

 private:
  static constexpr double kWindow = 10.0;  // [s]

  double least_ = std::numeric_limits<double>::infinity(), least_before_ = least_, window_ = 0.0;
  double first_ = 0.0, last_ = 0.0, first_time_ = 0.0, last_time_ = 0.0;
};

class StreamedCapture : public FrameSource {
 public:
  static constexpr double kStale = 2.0;  // the newest frame is older: nothing streams [s]

  // Throws InputError if nothing streams into the capture's folder.
  StreamedCapture(Capture capture, const std::filesystem::path& folder, CaptureCameras cameras);

  bool next(double time, CanvasFrame* frame) noexcept override;
  bool streams() const noexcept override { return true; }
  void note_joints(double time, const JointVector& q) noexcept override;
  std::string remark() const override;

 private:
  struct Posture {
    double time = 0.0;
    JointVector q;
  };
  struct Camera {
    CapturedView view;              // its file: the next frame, of stamp `next`
    double next = 0.0, last = 0.0;  // stamps [s]
    double seen = 0.0, silence = 0.0, silent_from = 0.0;  // by the driver's clock [s]
    int frames = 0, damaged = 0, passed = 0;
  };

  // The next of each camera is the newest file that is newer than its last, and no newer than
  // `stamp` [s]. Returns the stamp of the newest of all.
  double look(double stamp);

  std::filesystem::path folder_;
  CaptureCameras frames_of_;
  std::vector<Camera> cameras_;
  StreamClock clock_;
  double looked_ = 0.0;  // by this machine's clock [s]
  double age_ = 0.0;     // of all frames together, when they were known [s]
  Queue<Posture, 1024> noted_;
  std::deque<Posture> postures_;
};

// The frames of perception.capture: played back where it has views after time 0. corrections:
// Belief's, of the views. *noise: of its first views' depths at 1 m, as they say or as it is
// estimated (capture/clean_view.h) [m]. Throws InputError like read_capture() and the two classes.
std::unique_ptr<FrameSource> capture_frames(const PerceptionSettings& settings, const ArmModel& arm,
                                            const std::vector<CameraCorrection>& corrections = {},
                                            double* noise = nullptr);

}  // namespace impedraw
