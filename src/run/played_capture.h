// A capture that is played back in time: its views after time 0 are the frames of cameras that keep
// capturing.
//
// A view of time t was exposed t after the run began, and arrives perception.frames.latency later.
// Its depths are read then, cleaned (capture/clean_view.h) and rectified (capture/rectified.h) to
// perception.frames.width × height. A camera is numbered as the first view of the capture from its
// place, whose correction it has. Frames have no marks: the canvas is found by
// its shape. A view that cannot be read is left out.
#pragma once

#include <map>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/capture/capture.h"
#include "impedraw/capture/rectified.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/perception/camera_correction.h"
#include "impedraw/perception/canvas_frame.h"

namespace impedraw {

class PlayedCapture {
 public:
  // corrections: Belief's, of the views. Throws InputError like read_capture(), without a view
  // after time 0, and for cameras that move.
  PlayedCapture(const PerceptionSettings& settings, const ArmModel& arm,
                const std::vector<CameraCorrection>& corrections = {});

  // As Driver::next_frame(), at `time` [s].
  bool next(double time, CanvasFrame* frame) noexcept;

 private:
  double latency_;
  ArmModel arm_;
  Capture capture_;
  std::map<int, Rectified> cameras_;
  std::vector<int> camera_of_;  // of each frame
  std::size_t next_ = 0;
  DepthImage image_;
  std::vector<Capsule> body_;
};

}  // namespace impedraw
