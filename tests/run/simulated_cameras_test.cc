// Frames of the simulated cameras: the same whoever renders them, and the same as rays cast one by
// one.
#include "impedraw/run/simulated_cameras.h"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "impedraw/experiment/prepare.h"

namespace impedraw {
namespace {

Prepared prepared(const std::vector<std::string>& assignments) {
  DrawOptions options;
  options.scenario = "scenarios/moving-sway.yaml";
  options.assignments = {"perception.frames.depth=true", "preflight.arm=false",
                         "canvas.motion.ramp=0.1"};
  options.assignments.insert(options.assignments.end(), assignments.begin(), assignments.end());
  return prepare(resolve(options));
}

struct Taken {
  double time;
  int camera;
  Pose X_WK;
  JointVector q;
  DepthImage image;
};

// 0.4 s, in which the arm moves through the picture.
std::vector<Taken> frames(Prepared& e, int threads) {
  World& world = *e.truth.world;
  JointVector q = e.belief.start_q;
  world.set_state(q, JointVector::Zero(q.size()));
  SimulatedCameras cameras(e.scenario, world, *e.truth.canvas, e.belief.arm, {}, threads);
  std::vector<Taken> all;
  std::vector<std::pair<Pose, JointVector>> passed;
  for (int k = 0; k < 400; ++k) {
    passed.emplace_back(world.canvas_state().X_WK, world.state().q);
    cameras.expose(false);
    const double time = world.state().time;
    for (CanvasFrame frame; cameras.next(time, &frame);) {
      const auto& [X_WK, posture] = passed[static_cast<std::size_t>(std::lround(1e3 * frame.time))];
      all.push_back({frame.time, frame.camera, X_WK, posture, *frame.depth});
    }
    JointVector push = JointVector::Zero(q.size());
    push[1] = 40.0 * std::sin(0.02 * k);
    world.step(push, Eigen::Vector3d::Zero());
  }
  return all;
}

bool same(const DepthImage& a, const DepthImage& b) {
  return a.width == b.width && a.height == b.height && a.depth.size() == b.depth.size() &&
         std::memcmp(a.depth.data(), b.depth.data(), a.depth.size() * sizeof(double)) == 0;
}

TEST(SimulatedCameras, OneThreadOrTwoGiveTheSameImages) {
  for (const char* stereo : {"perception.stereo=false", "perception.stereo=true"}) {
    SCOPED_TRACE(stereo);
    Prepared e = prepared({stereo});
    const std::vector<Taken> one = frames(e, 1), two = frames(e, 2);
    ASSERT_GT(one.size(), 20U);
    ASSERT_EQ(two.size(), one.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(two[i].time, one[i].time);
      EXPECT_TRUE(same(two[i].image, one[i].image)) << i;
    }
  }
}

// Rays that cannot meet the canvas are left out of the one, and not of the other.
TEST(SimulatedCameras, PacketsAreRaysOneByOne) {
  Prepared e = prepared({});
  const std::vector<Taken> taken = frames(e, 2);
  const PerceptionSettings& p = e.scenario.perception;
  World& world = *e.truth.world;
  long seen = 0, of_arm = 0;
  for (std::size_t i = 0; i < taken.size(); i += 3) {
    const Taken& t = taken[i];
    const auto c = static_cast<std::size_t>(t.camera);
    const CameraSettings& s = p.cameras[c];
    const DepthCamera camera{p.frames.width, p.frames.height, s.fov_y_deg,
                             look_at(s.p_WC, s.target_W)};
    world.set_state(t.q, JointVector::Zero(t.q.size()));
    const CastRay cast = [&](const Eigen::Vector3d& o, const Eigen::Vector3d& d) {
      const Pose X_KW = t.X_WK.inverse();
      const auto hit = e.truth.canvas->ray(X_KW * o, X_KW.R * d);
      if (!hit) return std::numeric_limits<double>::infinity();
      const double arm = world.ray_to_arm(o, d);
      ++seen;
      of_arm += arm < hit->t;
      return std::min(arm, hit->t);
    };
    const auto frame = static_cast<std::uint64_t>(std::lround(t.time * p.frames.rate));
    const DepthImage image =
        render_depth(camera, cast, p.noise, camera_seed(e.scenario, c) + (frame << 20), 1);
    EXPECT_TRUE(same(image, t.image)) << i;
  }
  EXPECT_GT(seen, 50000);
  EXPECT_GT(of_arm, 100) << "the arm is in the picture";
}

}  // namespace
}  // namespace impedraw
