// Takes the cameras' frames: where the canvas is, how it moves, and what its surface is like.
//
// In lock-step frames are taken by the control loop's thread, at the cycle at which they arrive, so
// that a run does not depend on the machine. On a wall clock, and where cameras stream, a thread of
// its own takes them. The loop then uses what has been found so far: it never waits, allocates
// nothing and takes no lock (common/exchange.h).
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "impedraw/common/exchange.h"
#include "impedraw/perception/canvas_tracker.h"
#include "impedraw/perception/felt_motion.h"
#include "impedraw/perception/growing_surface.h"
#include "impedraw/run/frame_source.h"

namespace impedraw {

class CanvasWatch {
 public:
  // surface: null where the surface stays as the snapshot saw it. stamp_error: FrameSettings [s].
  CanvasWatch(std::unique_ptr<CanvasTracker> tracker, std::unique_ptr<GrowingSurface> surface,
              std::unique_ptr<FrameSource> frames, double stamp_error, bool lock_step);
  ~CanvasWatch() { end(); }
  CanvasWatch(const CanvasWatch&) = delete;
  CanvasWatch& operator=(const CanvasWatch&) = delete;

  // After the driver was started, and before it is stopped.
  void begin();
  void end();
  // The source's, after the end.
  std::string remark() const { return frames_->remark(); }
  // The cameras of which no frame has come lately at `time`, and since when, in times of a run that
  // began at -first_time; empty: none. After the end.
  std::string silence(double time, double first_time) const;

  // Once per control step, before the following. The arm is at q.
  void update(double time, const JointVector& q) noexcept;
  CanvasEstimate follow(double time) noexcept;
  // The tip in this step, where a wrench is measured.
  void feel(const PenTouch& pen, double time) noexcept {
    felt_.update(belief(), pen, time);
    stamp_lag_ = felt_.stamps().lag();
  }
  const FeltMotion& felt() const noexcept { return felt_; }
  // Null: as the snapshot saw it.
  const GrowingSurface* surface() const noexcept { return surface_.get(); }
  const CanvasBelief& belief() const noexcept {
    return lock_step_ ? tracker_->belief() : latest_.value();
  }

 private:
  bool take_frame(double time);  // true: what is known changed
  void take_frames_until_the_end();

  std::unique_ptr<CanvasTracker> tracker_;  // on a wall clock, of the other thread
  std::unique_ptr<GrowingSurface> surface_;
  std::unique_ptr<FrameSource> frames_;
  double stamp_error_;
  bool lock_step_;
  FeltMotion felt_;
  // On a wall clock.
  SmoothedCanvas smoothed_;
  Latest<CanvasBelief> latest_;
  std::atomic<double> now_ = 0.0;        // of the loop [s]
  std::atomic<double> stamp_lag_ = 0.0;  // beyond the error that is known [s]
  std::atomic<int> stage_ = 0;           // 0: not begun, 1: takes frames, 2: at its end
  std::thread taker_;
  double restamped_ = 0.0;      // the stamp_lag_ that all frames have [s]
  std::map<int, double> seen_;  // when the last frame of each camera came [s]
};

}  // namespace impedraw
