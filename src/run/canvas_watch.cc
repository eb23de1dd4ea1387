#include "impedraw/run/canvas_watch.h"

#include <chrono>
#include <utility>

#include <fmt/format.h>

namespace impedraw {
namespace {

constexpr std::chrono::milliseconds kPoll{1};

}  // namespace

CanvasWatch::CanvasWatch(std::unique_ptr<CanvasTracker> tracker,
                         std::unique_ptr<GrowingSurface> surface,
                         std::unique_ptr<FrameSource> frames, double stamp_error, bool lock_step)
    : tracker_(std::move(tracker)),
      surface_(std::move(surface)),
      frames_(std::move(frames)),
      stamp_error_(stamp_error),
      lock_step_(lock_step) {
  // Here, before the loop's thread may get a real-time priority, which its threads would inherit.
  if (!lock_step_) taker_ = std::thread([this] { take_frames_until_the_end(); });
}

void CanvasWatch::begin() {
  stage_ = 1;
  stage_.notify_one();
}

void CanvasWatch::end() {
  if (!taker_.joinable()) return;
  stage_ = 2;
  stage_.notify_one();
  taker_.join();
}

bool CanvasWatch::take_frame(double time) {
  const double lag = stamp_lag_;
  const bool restamps = lag != restamped_;
  if (restamps) tracker_->restamp(restamped_ - lag);
  restamped_ = lag;
  CanvasFrame frame;
  if (!frames_->next(time, &frame)) return restamps;
  seen_[frame.camera] = time;
  frame.time -= stamp_error_ + lag;
  tracker_->add(frame);
  if (surface_ && frame.depth) surface_->offer(tracker_->shape()->model().points(), time);
  return true;
}

void CanvasWatch::take_frames_until_the_end() {
  stage_.wait(0);
  while (stage_ == 1) {
    tracker_->follow(now_);  // tells it how late frames are
    if (take_frame(now_)) {
      latest_.slot() = tracker_->belief();
      latest_.give();
    } else {
      std::this_thread::sleep_for(kPoll);
    }
  }
}

std::string CanvasWatch::silence(double time, double first_time) const {
  if (seen_.empty()) return "no camera has sent a frame";
  std::string text;
  for (const auto& [camera, last] : seen_)
    if (time - last > belief().longest_age)
      text += fmt::format("{} of camera {} at t = {:.1f} s",
                          text.empty() ? "the last frame came" : ",", camera, first_time + last);
  return text;
}

void CanvasWatch::update(double time, const JointVector& q) noexcept {
  frames_->note_joints(time, q);
  if (lock_step_) {
    while (take_frame(time)) {
    }
  } else {
    now_ = time;
    latest_.refresh();
  }
  if (surface_) surface_->update(time);
}

CanvasEstimate CanvasWatch::follow(double time) noexcept {
  const CanvasShift felt = felt_.shift(time);
  return lock_step_ ? tracker_->follow(time, felt) : smoothed_.follow(latest_.value(), time, felt);
}

}  // namespace impedraw
