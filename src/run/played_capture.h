// A capture that is played back in time: its views after time 0 are the frames of cameras that keep
// capturing.
//
// A view of time t was exposed t after the run began, and arrives perception.frames.latency later.
// A camera is numbered as the first view of the capture from its place. Frames have no marks: the
// canvas is found by its shape. A view that cannot be read is left out.
#pragma once

#include <map>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/capture/capture.h"
#include "impedraw/capture/rectified.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/perception/camera_correction.h"
#include "impedraw/run/frame_source.h"

namespace impedraw {

// The standing cameras of a capture, by number. Makes frames of their images: depths are cleaned
// (capture/clean_view.h) and rectified (capture/rectified.h) to perception.frames.width × height.
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

}  // namespace impedraw
