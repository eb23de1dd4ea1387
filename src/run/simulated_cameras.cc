#include "impedraw/run/simulated_cameras.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

namespace impedraw {

namespace {

constexpr std::size_t kMostComing = 4096;

}  // namespace

SimulatedCameras::SimulatedCameras(const Scenario& scenario, World& world, const Canvas& canvas,
                                   const ArmModel& arm,
                                   const std::vector<CameraCorrection>& corrections, int threads)
    : world_(world),
      canvas_(canvas),
      arm_(arm),
      time_stamp_(scenario.perception.errors.time_stamp),
      frames_(scenario.perception.frames),
      fiducials_(scenario.perception.fiducials) {
  for (std::size_t i = 0; i < scenario.perception.cameras.size(); ++i) {
    SimulatedCamera camera(scenario, i, frames_.width, frames_.height);
    if (i < corrections.size()) camera.correct(corrections[i]);
    const std::uint64_t seed = camera.seed();
    cameras_.push_back({std::move(camera), 0, SeededNormals(seed ^ 0x6672616d65)});
  }
  coming_.reserve(kMostComing);
  unused_.reserve(kMostComing);
  if (threads == 0) threads = std::thread::hardware_concurrency() > 1 ? 2 : 1;
  if (frames_.depth && threads > 1) second_ = std::thread([this] { render_what_is_queued(); });
}

SimulatedCameras::~SimulatedCameras() {
  if (!second_.joinable()) return;
  ends_ = true;
  ++posted_;
  posted_.notify_one();
  second_.join();
}

SimulatedCameras::Coming* SimulatedCameras::unused() {
  if (unused_.empty()) {
    all_.push_back(std::make_unique<Coming>());
    return all_.back().get();
  }
  Coming* const coming = unused_.back();
  unused_.pop_back();
  return coming;
}

void SimulatedCameras::capture(int number, double time, bool lost) noexcept {
  Camera& camera = cameras_[static_cast<std::size_t>(number)];
  const Pose X_WK = world_.canvas_state().X_WK;
  CanvasFrame frame;
  frame.time = time + time_stamp_;
  frame.camera = number;
  // Drawn for each frame, also of those that are lost, so that one does not change the next.
  const double late = frames_.latency + frames_.latency_jitter * camera.noise.next();
  const bool dropped = std::erfc(-camera.noise.next() / std::sqrt(2.0)) / 2.0 < frames_.drop;
  for (std::size_t i = 0; i < fiducials_.points.size() && i < CanvasFrame::kMostMarks; ++i) {
    Eigen::Vector3d noise;
    for (int k = 0; k < 3; ++k) noise[k] = fiducials_.noise * camera.noise.next();
    const Eigen::Vector3d p_W = X_WK * fiducials_.points[i].p_K;
    if (!camera.camera.sees(p_W, world_, canvas_, X_WK)) continue;
    frame.marks[static_cast<std::size_t>(frame.count++)] = {static_cast<int>(i),
                                                            camera.camera.found_at(p_W, i) + noise};
  }
  if (dropped || lost || coming_.size() == kMostComing) return;
  Coming* const coming = unused();
  coming->frame = frame;
  coming->arrives = time + std::max(0.0, late);
  coming->has_depth =
      frames_.depth && camera.exposed % static_cast<std::uint64_t>(frames_.depth_every) == 0;
  const auto at = std::upper_bound(
      coming_.begin(), coming_.end(), coming->arrives,
      [](double arrives, const Coming* other) { return arrives < other->arrives; });
  coming_.insert(at, coming);
  if (!coming->has_depth) return;
  coming->seed = camera.camera.seed() + (camera.exposed << 20);
  coming->X_WK = X_WK;
  world_.copy_body(&coming->body);
  coming->arm.clear();
  for (const BodyCapsule& c : arm_.body_capsules(world_.state().q))
    coming->arm.push_back({c.a_W, c.b_W, c.radius});
  coming->stage.store(Coming::waiting, std::memory_order_release);
  if (!second_.joinable() || !queue_.give(coming)) return;
  ++posted_;
  posted_.notify_one();
}

void SimulatedCameras::render_if_waiting(Coming* coming) const noexcept {
  int expected = Coming::waiting;
  if (!coming->stage.compare_exchange_strong(expected, Coming::begun, std::memory_order_acq_rel))
    return;
  const SimulatedCamera& camera = cameras_[static_cast<std::size_t>(coming->frame.camera)].camera;
  const CastRays cast = [this, coming](const Eigen::Vector3d& o_W,
                                       std::span<const Eigen::Vector3d> d_W,
                                       std::span<double> distances) {
    constexpr std::size_t kBatch = 64;
    std::array<Eigen::Vector3d, kBatch> d_K;
    const Pose X_KW = coming->X_WK.inverse();
    const Eigen::Vector3d o_K = X_KW * o_W;
    for (std::size_t first = 0; first < d_W.size(); first += kBatch) {
      const std::size_t n = std::min(kBatch, d_W.size() - first);
      for (std::size_t k = 0; k < n; ++k) d_K[k] = X_KW.R * d_W[first + k];
      canvas_.rays(o_K, {d_K.data(), n}, distances.subspan(first, n));
    }
    coming->body.cover(o_W, d_W, distances, PosedBody::Rays::finite);
  };
  camera.render(cast, coming->seed, camera.part(canvas_.bounds(), coming->X_WK), &coming->image);
  coming->stage.store(Coming::done, std::memory_order_release);
  coming->stage.notify_all();
}

void SimulatedCameras::render_what_is_queued() noexcept {
  while (true) {
    const unsigned seen = posted_.load();
    if (ends_) return;
    Coming* coming = nullptr;
    if (queue_.take(&coming))
      render_if_waiting(coming);
    else
      posted_.wait(seen);
  }
}

void SimulatedCameras::expose(bool lost) noexcept {
  const double time = world_.state().time;
  bool posed = false;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Camera& camera = cameras_[i];
    const double due =
        static_cast<double>(camera.exposed) / frames_.rate + static_cast<double>(i) * frames_.skew;
    if (time < due - 1e-9) continue;
    if (!posed) world_.pose_body();
    posed = true;
    capture(static_cast<int>(i), time, lost);
    ++camera.exposed;
  }
}

bool SimulatedCameras::next(double time, CanvasFrame* frame) noexcept {
  if (coming_.empty() || coming_.front()->arrives > time) return false;
  if (given_) unused_.push_back(given_);
  given_ = coming_.front();
  coming_.erase(coming_.begin());
  *frame = given_->frame;
  if (!given_->has_depth) return true;
  render_if_waiting(given_);
  while (given_->stage.load(std::memory_order_acquire) == Coming::begun)
    given_->stage.wait(Coming::begun, std::memory_order_acquire);
  frame->depth = &given_->image;
  frame->camera_model = &cameras_[static_cast<std::size_t>(frame->camera)].camera.believed();
  frame->arm = given_->arm;
  return true;
}

}  // namespace impedraw
