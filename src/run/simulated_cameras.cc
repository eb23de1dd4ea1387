#include "impedraw/run/simulated_cameras.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "impedraw/experiment/snapshot.h"

namespace impedraw {

namespace {

constexpr std::size_t kMostComing = 4096;
constexpr double kSkin = 5e-3;  // what is hit this close before a mark is the mark itself [m]

constexpr double kRoundArm = 0.05;  // capsules stand for its links to within this [m]

// Whether a ray comes near a capsule, taken as a ball about all of it.
bool passes(const Eigen::Vector3d& o, const Eigen::Vector3d& d, const Capsule& c) noexcept {
  const Eigen::Vector3d middle = 0.5 * (c.a_W + c.b_W) - o;
  const double radius = 0.5 * (c.b_W - c.a_W).norm() + c.radius + kRoundArm;
  return (middle - middle.dot(d) * d).squaredNorm() < radius * radius;
}

}  // namespace

SimulatedCameras::SimulatedCameras(const Scenario& scenario, World& world, const Canvas& canvas,
                                   ArmModel& arm)
    : world_(world),
      canvas_(canvas),
      arm_(arm),
      noise_(scenario.perception.noise),
      depth_scale_(1.0 + scenario.perception.errors.depth_scale),
      frames_(scenario.perception.frames),
      fiducials_(scenario.perception.fiducials) {
  for (std::size_t i = 0; i < scenario.perception.cameras.size(); ++i) {
    const CameraSettings& c = scenario.perception.cameras[i];
    const DepthCamera believed = {frames_.width, frames_.height, c.fov_y_deg,
                                  look_at(c.p_WC, c.target_W)};
    const std::uint64_t seed = camera_seed(scenario, i);
    cameras_.push_back({believed, true_camera(believed, scenario.perception.errors, seed), 0, seed,
                        SeededNormals(seed ^ 0x6672616d65)});
  }
  coming_.reserve(kMostComing);
}

bool SimulatedCameras::sees(const DepthCamera& camera, const Eigen::Vector3d& p_W,
                            const Pose& X_WK) const noexcept {
  const Eigen::Vector3d p_C = camera.X_WC.inverse() * p_W;
  if (p_C.z() <= 0.0) return false;
  const double f = camera.focal_length();
  if (std::abs(p_C.x() / p_C.z()) * f > 0.5 * camera.width ||
      std::abs(p_C.y() / p_C.z()) * f > 0.5 * camera.height)
    return false;
  const Eigen::Vector3d way = p_W - camera.X_WC.p;
  const double distance = way.norm();
  const Eigen::Vector3d direction = way / distance;
  if (world_.ray_to_arm(camera.X_WC.p, direction) < distance - kSkin) return false;
  const auto hit = canvas_.ray(X_WK.inverse() * camera.X_WC.p, X_WK.R.transpose() * direction);
  return !hit || hit->t > distance - kSkin;
}

void SimulatedCameras::capture(int number, double time, bool lost) noexcept {
  Camera& camera = cameras_[static_cast<std::size_t>(number)];
  const Pose X_WK = world_.canvas_state().X_WK;
  Coming coming;
  coming.frame.time = time;
  coming.frame.camera = number;
  // Drawn for each frame, also of those that are lost, so that one does not change the next.
  const double late = frames_.latency + frames_.latency_jitter * camera.noise.next();
  const bool dropped = std::erfc(-camera.noise.next() / std::sqrt(2.0)) / 2.0 < frames_.drop;
  const Pose error = camera.believed.X_WC * camera.actual.X_WC.inverse();
  for (std::size_t i = 0; i < fiducials_.points.size() && i < CanvasFrame::kMostMarks; ++i) {
    Eigen::Vector3d noise;
    for (int k = 0; k < 3; ++k) noise[k] = fiducials_.noise * camera.noise.next();
    const Eigen::Vector3d p_W = X_WK * fiducials_.points[i].p_K;
    if (!sees(camera.actual, p_W, X_WK)) continue;
    coming.frame.marks[static_cast<std::size_t>(coming.frame.count++)] = {static_cast<int>(i),
                                                                          error * p_W + noise};
  }
  if (dropped || lost || coming_.size() == kMostComing) return;
  coming.arrives = time + std::max(0.0, late);
  if (frames_.depth && camera.exposed % static_cast<std::uint64_t>(frames_.depth_every) == 0)
    take_image(camera, X_WK, &coming);
  const auto at =
      std::upper_bound(coming_.begin(), coming_.end(), coming.arrives,
                       [](double arrives, const Coming& other) { return arrives < other.arrives; });
  coming_.insert(at, std::move(coming));
}

// Only the pixels about the canvas can see it; the others are cast at nothing.
void SimulatedCameras::take_image(const Camera& camera, const Pose& X_WK, Coming* coming) const {
  for (const BodyCapsule& c : arm_.body_capsules(world_.state().q))
    coming->arm.push_back({c.a_W, c.b_W, c.radius});
  const Pose X_KW = X_WK.inverse();
  const Eigen::AlignedBox3d& box = canvas_.bounds();
  const CastRay cast = [&](const Eigen::Vector3d& o, const Eigen::Vector3d& d) {
    constexpr double kNothing = std::numeric_limits<double>::infinity();
    const Eigen::Vector3d o_K = X_KW * o, d_K = X_KW.R * d;
    // The box, by its slabs.
    double from = 0.0, to = kNothing;
    for (int i = 0; i < 3; ++i) {
      const double a = (box.min()[i] - o_K[i]) / d_K[i], b = (box.max()[i] - o_K[i]) / d_K[i];
      from = std::max(from, std::min(a, b));
      to = std::min(to, std::max(a, b));
    }
    if (!(from <= to + 1e-9)) return kNothing;
    const auto hit = canvas_.ray(o_K, d_K);
    if (!hit) return kNothing;
    for (const Capsule& c : coming->arm)
      if (passes(o, d, c)) return std::min(hit->t, world_.ray_to_arm(o, d));
    return hit->t;
  };
  coming->image = render_depth(camera.actual, cast, noise_, camera.seed + (camera.exposed << 20));
  for (double& depth : coming->image.depth) depth *= depth_scale_;
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
  if (coming_.empty() || coming_.front().arrives > time) return false;
  given_ = std::move(coming_.front());
  coming_.erase(coming_.begin());
  *frame = given_.frame;
  if (!given_.image.depth.empty()) {
    frame->depth = &given_.image;
    frame->camera_model = &cameras_[static_cast<std::size_t>(frame->camera)].believed;
    frame->arm = given_.arm;
  }
  return true;
}

}  // namespace impedraw
