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
#include <string>
#include <vector>

#include "impedraw/common/exchange.h"
#include "impedraw/run/played_capture.h"

namespace impedraw {

// The clock that stamps frames, this machine's, and the driver's [s].
class StreamClock {
 public:
  // Both, read together: how far a stamp is beyond the driver's time.
  double offset(double now, double time) noexcept;
  bool begun() const noexcept { return first_ > 0.0; }
  // Of the driver's, over all that was read.
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

  // Of each camera the next is the newest file that is newer than its last, and no newer than
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
