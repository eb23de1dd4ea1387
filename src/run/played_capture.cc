#include "impedraw/run/played_capture.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "impedraw/capture/clean_view.h"
#include "impedraw/common/errors.h"

namespace impedraw {

namespace {

constexpr std::size_t kMostCameras = 16;

}  // namespace

CaptureCameras::CaptureCameras(const PerceptionSettings& settings, const ArmModel& arm,
                               std::vector<CameraCorrection> corrections)
    : arm_(arm),
      corrections_(std::move(corrections)),
      width_(settings.frames.width),
      height_(settings.frames.height),
      file_(settings.capture / "capture.json") {}

void CaptureCameras::add(int camera, const CapturedView& view) {
  const auto number = static_cast<std::size_t>(camera);
  const Pose T = number < corrections_.size() ? corrections_[number].T : Pose();
  cameras_.try_emplace(camera, view.lens, T * view.X_WC, width_, height_);
  if (cameras_.size() > kMostCameras)
    throw InputError(fmt::format(
        "{}: its frames were taken from more than {} places; valid are cameras that stand",
        file_.string(), kMostCameras));
}

bool CaptureCameras::show(int camera, CapturedView* view, CanvasFrame* frame) {
  try {
    read_depth(view);
    clean(view);
  } catch (const InputError&) {
    return false;
  }
  const Rectified& rectified = cameras_.at(camera);
  rectified.depths(view->depth, &image_);
  view->depth = {};
  body_.clear();
  const Eigen::Map<const Eigen::VectorXd> q(view->joints.data(),
                                            static_cast<Eigen::Index>(view->joints.size()));
  if (q.size() == arm_.joints())
    for (const BodyCapsule& c : arm_.body_capsules(q)) body_.push_back({c.a_W, c.b_W, c.radius});
  *frame = {};
  frame->camera = camera;
  frame->depth = &image_;
  frame->camera_model = &rectified.camera();
  frame->arm = body_;
  return true;
}

PlayedCapture::PlayedCapture(Capture capture, double latency, CaptureCameras cameras)
    : capture_(std::move(capture)), latency_(latency), cameras_(std::move(cameras)) {
  std::vector<Pose> places;
  for (CapturedView& view : capture_.views) {
    places.push_back(view.X_WC);
    view = {};
  }
  for (const CapturedView& view : capture_.played) {
    const auto at = std::find_if(places.begin(), places.end(), [&view](const Pose& X) {
      return X.p == view.X_WC.p && X.R == view.X_WC.R;
    });
    camera_of_.push_back(static_cast<int>(at - places.begin()));
    if (at == places.end()) places.push_back(view.X_WC);
    cameras_.add(camera_of_.back(), view);
  }
}

bool PlayedCapture::next(double time, CanvasFrame* frame) noexcept {
  while (next_ < capture_.played.size() && *capture_.played[next_].time + latency_ <= time) {
    CapturedView& view = capture_.played[next_];
    if (!cameras_.show(camera_of_[next_++], &view, frame)) continue;
    frame->time = *view.time;
    return true;
  }
  return false;
}

}  // namespace impedraw
