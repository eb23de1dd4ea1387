#include "impedraw/run/streamed_capture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "impedraw/capture/clean_view.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/text_fields.h"

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

namespace {

namespace fs = std::filesystem;

constexpr double kLook = 3e-3;     // from one look into the folder to the next [s]
constexpr double kNotesFor = 3.0;  // [s]
constexpr double kSilent = 1.0;    // as long as the tracker relies on its last frame [s]

double clock_now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace

double StreamClock::offset(double now, double time) noexcept {
  if (!begun()) {
    first_ = now;
    first_time_ = time;
  }
  last_ = now;
  last_time_ = time;
  if (now - window_ > kWindow) {
    least_before_ = std::exchange(least_, std::numeric_limits<double>::infinity());
    window_ = now;
  }
  least_ = std::min(least_, now - time);
  return std::min(least_, least_before_);
}

StreamedCapture::StreamedCapture(Capture capture, const fs::path& folder, CaptureCameras cameras)
    : folder_(folder), frames_of_(std::move(cameras)) {
  for (CapturedView& view : capture.views) {
    view.depth = {};
    cameras_.emplace_back().view = std::move(view);
  }
  const double now = clock_now(), newest = look(now + kStale), age = now - newest;
  if (age > kStale)
    throw InputError(fmt::format(
        "{}: no view has a 'time' above 0, {}, and perception.frames.enabled asks for frames; "
        "valid are times from the beginning of the run on, a camera that streams (./impedraw "
        "capture --stream), or perception.frames.enabled: false",
        (folder / "capture.json").string(),
        newest == 0.0 ? "no camera streams into its folder"
                      : fmt::format("the newest frame in its folder is {:.3g} s old", age)));
  for (std::size_t i = 0; i < cameras_.size(); ++i)
    frames_of_.add(static_cast<int>(i), cameras_[i].view);
}

double StreamedCapture::look(double stamp) {
  double newest = 0.0;
  std::error_code error;
  for (fs::directory_iterator it(folder_, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    const std::size_t bar = name.find('_', 5);
    if (!name.starts_with("live_") || !name.ends_with(".png") || bar == std::string::npos) continue;
    const std::string_view text = name;
    const auto view = number_in(text.substr(5, bar - 5)),
               microseconds = number_in(text.substr(bar + 1, name.size() - bar - 5));
    if (!view || !microseconds || !(*view >= 0.0 && *view < static_cast<double>(cameras_.size())))
      continue;
    Camera& camera = cameras_[static_cast<std::size_t>(*view)];
    const double stamped = 1e-6 * *microseconds;
    if (!(stamped > camera.last && stamped <= stamp)) continue;
    if (camera.next > 0.0) ++camera.passed;
    if (stamped <= camera.next) continue;
    camera.next = stamped;
    camera.view.file = it->path();
    newest = std::max(newest, stamped);
  }
  return newest;
}

void StreamedCapture::note_joints(double time, const JointVector& q) noexcept {
  noted_.give({time, q});
}

bool StreamedCapture::next(double time, CanvasFrame* frame) noexcept {
  for (Posture posture; noted_.take(&posture);) postures_.push_back(posture);
  while (!postures_.empty() && postures_.front().time < time - kNotesFor) postures_.pop_front();
  if (time <= 0.0) return false;  // the loop has not begun
  const double now = clock_now();
  if (!clock_.begun())
    for (Camera& camera : cameras_)
      camera = {.view = std::move(camera.view), .last = now, .seen = time};
  const double offset = clock_.offset(now, time);
  const auto waits = [](const Camera& camera) { return camera.next > 0.0; };
  if (std::abs(now - looked_) > kLook && std::none_of(cameras_.begin(), cameras_.end(), waits)) {
    look(time + offset);
    looked_ = now;
  }
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Camera& camera = cameras_[i];
    if (time - camera.seen > camera.silence) {
      camera.silence = time - camera.seen;
      camera.silent_from = camera.seen;
    }
    if (!waits(camera)) continue;
    camera.last = std::exchange(camera.next, 0.0);
    const double exposed = camera.last - offset;
    const auto at = std::min_element(
        postures_.begin(), postures_.end(), [exposed](const Posture& a, const Posture& b) {
          return std::abs(a.time - exposed) < std::abs(b.time - exposed);
        });
    if (at != postures_.end()) camera.view.joints.assign(at->q.begin(), at->q.end());
    if (!frames_of_.show(static_cast<int>(i), &camera.view, frame)) {
      ++camera.damaged;
      continue;
    }
    frame->time = exposed;
    ++camera.frames;
    camera.seen = time;
    age_ += clock_now() - camera.last;
    return true;
  }
  return false;
}

std::string StreamedCapture::remark() const {
  std::string text = folder_.string() + ": frames taken:";
  int frames = 0;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const Camera& camera = cameras_[i];
    frames += camera.frames;
    text += fmt::format("{} {} of views[{}]", i ? "," : "", camera.frames, i);
    if (camera.passed > 0) text += fmt::format(", {} passed over for newer ones", camera.passed);
    if (camera.damaged > 0) text += fmt::format(", {} that cannot be read", camera.damaged);
    if (camera.silence > kSilent)
      text += fmt::format(", none for {:.1f} s from t = {:.1f} s on", camera.silence,
                          camera.silent_from);
  }
  if (frames > 0)
    text += fmt::format(
        "; known {:.0f} ms after exposure, and the run went {:.3g} times as fast as their clock",
        1e3 * age_ / frames, clock_.rate());
  return text;
}

std::unique_ptr<FrameSource> capture_frames(const PerceptionSettings& settings, const ArmModel& arm,
                                            const std::vector<CameraCorrection>& corrections,
                                            double* noise) {
  Capture capture = read_capture(
      settings.capture,
      [model = arm](const std::vector<double>& q) mutable {
        return model.tip_pose(
            Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size())));
      },
      true);
  if (noise) {
    *noise = 0.0;
    for (const CapturedView& view : capture.views) *noise = std::max(*noise, noise_at_1m(view));
  }
  CaptureCameras cameras(settings, arm, corrections);
  if (capture.played.empty())
    return std::make_unique<StreamedCapture>(std::move(capture), settings.capture,
                                             std::move(cameras));
  return std::make_unique<PlayedCapture>(std::move(capture), settings.frames.latency,
                                         std::move(cameras));
}

}  // namespace impedraw
