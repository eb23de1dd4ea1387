// Perception of one frame of one camera, 320 × 240 px of the standard bowl with 1 mm of noise at
// 1 m: its points and normals alone, and all of it, with registration and fusion. The floor is the
// plain back-projection of its pixels.
#include <cmath>
#include <limits>
#include <vector>

#include <benchmark/benchmark.h>

#include "impedraw/perception/canvas_shape.h"
#include "impedraw/perception/normals.h"

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

BENCHMARK(BM_frame_back_project)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_frame_points)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_frame_all)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace impedraw
