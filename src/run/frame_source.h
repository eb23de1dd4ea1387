// The source of the frames of a canvas that moves: the driver (simulated_cameras.h), a capture that
// is played back, or cameras that stream (both in streamed_capture.h).
#pragma once

#include <string>

#include "impedraw/control/arm_terms.h"
#include "impedraw/run/driver.h"

namespace impedraw {

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  // As Driver::next_frame(), at `time` [s] of the driver's clock.
  virtual bool next(double time, CanvasFrame* frame) noexcept = 0;
  // Frames come as time passes, whatever the driver's clock does: next() must not be called by the
  // loop's thread.
  virtual bool streams() const noexcept { return false; }
  // The arm is at q at `time` [s]: by the loop's thread, once per control step; must not wait.
  virtual void note_joints(double, const JointVector&) noexcept {}
  // For the user after the run, when next() is called no more; empty: nothing.
  virtual std::string remark() const { return {}; }
};

// A driver's own.
class DriverFrames : public FrameSource {
 public:
  explicit DriverFrames(Driver& driver) : driver_(driver) {}
  bool next(double, CanvasFrame* frame) noexcept override { return driver_.next_frame(frame); }

 private:
  Driver& driver_;
};

}  // namespace impedraw
