#include "impedraw/perception/wall_sides.h"

#include <cmath>
#include <memory>
#include <utility>

#include "impedraw/perception/neighbours.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kAbout = 2.5;      // how far along the wall pixels are counted, in cubes
constexpr double kContrary = -0.5;  // cosine between the normals of two sides
constexpr double kWall = 0.05;      // share of the points; fewer are a sharp edge, an ear's rim
// The additional weight of a pixel on a side that faces up or away from the object's middle.
// Cameras may see the sides of an upright sheet equally well: the first view counts for more by a
// share, so that one side wins all over.
constexpr double kUp = 4.0, kOutwards = 2.0, kEarlier = 0.25;

// The surface that one camera sees, thinned.
struct View {
  std::vector<Vector3d> points, normals;
  std::vector<double> weight;
  std::unique_ptr<const NeighbourTree> tree;  // null: there is none
  std::vector<char> far;                      // on the side that is left out
};

View view_of(const PointCloud& seen, int camera, const Vector3d& middle, double voxel,
             const NormalSettings& settings) {
  PointCloud cloud;
  cloud.eyes = {seen.eyes[static_cast<std::size_t>(camera)]};
  for (std::size_t i = 0; i < seen.points.size(); ++i)
    if (seen.camera[i] == camera) cloud.points.push_back(seen.points[i]);
  cloud.camera.assign(cloud.points.size(), 0);
  cloud = thin(cloud, voxel);
  View view;
  if (cloud.points.size() < static_cast<std::size_t>(settings.k)) return view;
  const SurfaceEstimator surface(std::move(cloud), settings);
  for (std::size_t i = 0; i < surface.cloud().points.size(); ++i) {
    if (surface.at_points()[i].status != SurfaceStatus::ok) continue;
    const Vector3d &p = surface.cloud().points[i], &n = surface.at_points()[i].n_W;
    const Eigen::Vector2d out = (p - middle).head<2>().normalized();
    view.points.push_back(p);
    view.normals.push_back(n);
    view.weight.push_back(surface.cloud().weight[i] * (1.0 + kEarlier / (1 + camera)) *
                          std::exp(kUp * n.z() + kOutwards * n.head<2>().dot(out)));
  }
  view.far.assign(view.points.size(), 0);
  return view;
}

// More pixels saw a surface close to this one from its other side.
bool is_far(const Vector3d& p, const Vector3d& n, const std::vector<View>& views, double voxel) {
  int index[kMostNeighbours];
  double squared[kMostNeighbours], own = 0.0, other = 0.0;
  const double reach = std::hypot(kAbout, kThinWall) * voxel;
  for (const View& view : views) {
    const int found = view.tree ? view.tree->nearest(p, kMostNeighbours, reach, index, squared) : 0;
    for (int j = 0; j < found; ++j) {
      const auto k = static_cast<std::size_t>(index[j]);
      const double off = n.dot(view.points[k] - p), along2 = squared[j] - off * off;
      if (std::abs(off) > kThinWall * voxel || along2 > kAbout * kAbout * voxel * voxel) continue;
      const double cosine = n.dot(view.normals[k]);
      if (cosine < kContrary) other += view.weight[k];
      if (cosine > -kContrary) own += view.weight[k];
    }
  }
  return other > own;
}

}  // namespace

PointCloud without_far_sides(const PointCloud& seen, double voxel, const NormalSettings& settings) {
  if (seen.eyes.size() < 2 || voxel == 0.0) return seen;
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& p : seen.points) middle += p / static_cast<double>(seen.points.size());
  std::vector<View> views;
  for (std::size_t c = 0; c < seen.eyes.size(); ++c)
    views.push_back(view_of(seen, static_cast<int>(c), middle, voxel, settings));
  for (View& view : views)
    if (!view.points.empty()) view.tree = std::make_unique<const NeighbourTree>(view.points);
  for (View& view : views)
    for (std::size_t i = 0; i < view.points.size(); ++i)
      view.far[i] = is_far(view.points[i], view.normals[i], views, voxel);
  PointCloud left;
  left.eyes = seen.eyes;
  for (std::size_t i = 0; i < seen.points.size(); ++i) {
    const View& view = views[static_cast<std::size_t>(seen.camera[i])];
    int nearest;
    double squared;
    if (view.tree && view.tree->nearest(seen.points[i], 1, kAbout * voxel, &nearest, &squared) &&
        view.far[static_cast<std::size_t>(nearest)])
      continue;
    append(seen, i, &left);
  }
  const double kept = static_cast<double>(left.points.size());
  return kept > (1.0 - kWall) * static_cast<double>(seen.points.size()) ? seen : left;
}

}  // namespace impedraw
