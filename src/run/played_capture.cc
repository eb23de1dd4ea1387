#include "impedraw/run/played_capture.h"

#include <algorithm>

#include <fmt/format.h>

#include "impedraw/capture/clean_view.h"
#include "impedraw/common/errors.h"

namespace impedraw {

namespace {

constexpr std::size_t kMostCameras = 16;

Eigen::Map<const Eigen::VectorXd> vector_of(const std::vector<double>& q) {
  return {q.data(), static_cast<Eigen::Index>(q.size())};
}

}  // namespace

PlayedCapture::PlayedCapture(const PerceptionSettings& settings, const ArmModel& arm,
                             const std::vector<CameraCorrection>& corrections)
    : latency_(settings.frames.latency), arm_(arm) {
  if (!settings.frames.depth)
    throw InputError(
        "perception.frames.depth is false, and a capture that is played back has depths alone; "
        "valid is true");
  capture_ = read_capture(
      settings.capture,
      [this](const std::vector<double>& q) { return arm_.tip_pose(vector_of(q)); }, true);
  if (capture_.played.empty())
    throw InputError(fmt::format(
        "{}: no view has a 'time' above 0, and perception.frames.enabled asks for frames; valid "
        "are times from the beginning of the run on, or perception.frames.enabled: false",
        (settings.capture / "capture.json").string()));
  std::vector<Pose> places;
  const auto number_of = [&places](const CapturedView& view) {
    const auto same = [&view](const Pose& X) { return X.p == view.X_WC.p && X.R == view.X_WC.R; };
    return static_cast<int>(std::find_if(places.begin(), places.end(), same) - places.begin());
  };
  for (CapturedView& view : capture_.views) {
    places.push_back(view.X_WC);
    view = {};
  }
  for (const CapturedView& view : capture_.played) {
    const int camera = number_of(view);
    if (camera == static_cast<int>(places.size())) places.push_back(view.X_WC);
    camera_of_.push_back(camera);
    const auto number = static_cast<std::size_t>(camera);
    const Pose T = number < corrections.size() ? corrections[number].T : Pose();
    cameras_.try_emplace(camera, view.lens, T * view.X_WC, settings.frames.width,
                         settings.frames.height);
    if (cameras_.size() > kMostCameras)
      throw InputError(fmt::format(
          "{}: its frames were taken from more than {} places; valid are cameras that stand",
          (settings.capture / "capture.json").string(), kMostCameras));
  }
}

bool PlayedCapture::next(double time, CanvasFrame* frame) noexcept {
  while (next_ < capture_.played.size() && *capture_.played[next_].time + latency_ <= time) {
    const Rectified& camera = cameras_.at(camera_of_[next_]);
    CapturedView& view = capture_.played[next_++];
    try {
      read_depth(&view);
      clean(&view);
    } catch (const InputError&) {
      continue;
    }
    camera.depths(view.depth, &image_);
    view.depth = {};
    body_.clear();
    if (static_cast<int>(view.joints.size()) == arm_.joints())
      for (const BodyCapsule& c : arm_.body_capsules(vector_of(view.joints)))
        body_.push_back({c.a_W, c.b_W, c.radius});
    *frame = {};
    frame->time = *view.time;
    frame->camera = camera_of_[next_ - 1];
    frame->depth = &image_;
    frame->camera_model = &camera.camera();
    frame->arm = body_;
    return true;
  }
  return false;
}

}  // namespace impedraw
