// One frame of one camera, 320 × 240 px of the standard bowl with 1 mm of noise at 1 m.
//
// Rendering, by the simulator: every pixel is cast, in packets; the floor is rays cast one by one.
// Perception: its points and normals alone, and all of it, with registration and fusion; the floor
// is the plain back-projection of its pixels.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "impedraw/canvas/built_in.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/perception/canvas_shape.h"
#include "impedraw/perception/normals.h"
#include "impedraw/simulation/world.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

// The cap of radius 0.3 m that is open towards z, without its rim.
double bowl(const Vector3d& o, const Vector3d& d) {
  const Vector3d w = o - Vector3d(0.60, 0.0, 0.40);
  const double b = w.dot(d), q = b * b - w.squaredNorm() + 0.09;
  if (q < 0.0) return std::numeric_limits<double>::infinity();
  const double t = -b + std::sqrt(q);
  return (o + t * d).z() < 0.16 ? t : std::numeric_limits<double>::infinity();
}

struct Frames {
  std::vector<DepthCamera> cameras = standard_cameras();
  std::vector<DepthImage> images;
  PointCloud cloud;

  Frames() {
    for (DepthCamera& camera : cameras) {
      camera.width = 320;
      camera.height = 240;
      images.push_back(render_depth(camera, bowl, realistic_depth_noise(), images.size()));
    }
    cloud = SurfaceEstimator(fuse(images, cameras, {.voxel = 0.006})).cloud();
  }
};

void BM_frame_back_project(benchmark::State& state) {
  const Frames f;
  for (auto _ : state)
    benchmark::DoNotOptimize(back_project({f.images[0]}, {f.cameras[0]}, {.voxel = 0.0}));
}

void BM_frame_points(benchmark::State& state) {
  const Frames f;
  const OrganisedPoints points;
  std::vector<SeenPoint> seen;
  const Eigen::AlignedBox3d everywhere(Vector3d::Constant(-9.0), Vector3d::Constant(9.0));
  for (auto _ : state) {
    seen.clear();
    points.find(f.images[0], f.cameras[0], everywhere, {}, 0.0, &seen);
    benchmark::DoNotOptimize(seen.data());
  }
}

void BM_frame_all(benchmark::State& state) {
  const Frames f;
  CanvasShape shape(f.cloud, {});
  CanvasFrame frame;
  Pose predicted;
  predicted.p = Vector3d(3e-4, -2e-4, 2e-4);
  std::size_t i = 0;
  for (auto _ : state) {
    frame.depth = &f.images[i];
    frame.camera_model = &f.cameras[i];
    i = (i + 1) % f.cameras.size();
    const ShapeRegistration found = shape.look(frame, predicted);
    if (!found.found) state.SkipWithError("not found");
    shape.fuse(found.X_WK);
  }
}

// The bowl and the arm above it.
struct BowlAndArm {
  Canvas canvas{make_bowl({})};
  World world{std::string(IMPEDRAW_ROOT) + "/models/iiwa14_pen.urdf", nullptr, {}};
  DepthCamera camera = standard_cameras()[0];
  PosedBody body;

  BowlAndArm() {
    JointVector q(7);
    q << 0.0, 0.6, 0.0, -1.6, 0.0, 0.9, 0.0;
    world.set_state(q, JointVector::Zero(7));
    world.copy_body(&body);
    camera.width = 320;
    camera.height = 240;
  }
};

void BM_frame_render(benchmark::State& state) {
  const BowlAndArm s;
  const CastRays cast = [&s](const Vector3d& o, std::span<const Vector3d> d,
                             std::span<double> out) {
    s.canvas.rays(o, d, out);
    s.body.cover(o, d, out, PosedBody::Rays::finite);
  };
  DepthImage image;
  for (auto _ : state) {
    render_depth(s.camera, cast, realistic_depth_noise(), 1, {0, 0, 320, 240}, &image);
    benchmark::DoNotOptimize(image.depth.data());
  }
}

void BM_frame_render_one_by_one(benchmark::State& state) {
  const BowlAndArm s;
  const CastRay cast = [&s](const Vector3d& o, const Vector3d& d) {
    const auto hit = s.canvas.ray(o, d);
    return hit ? std::min(hit->t, s.world.ray_to_arm(o, d))
               : std::numeric_limits<double>::infinity();
  };
  for (auto _ : state)
    benchmark::DoNotOptimize(render_depth(s.camera, cast, realistic_depth_noise(), 1, 1));
}

BENCHMARK(BM_frame_render)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_frame_render_one_by_one)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_frame_back_project)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_frame_points)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_frame_all)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace impedraw
