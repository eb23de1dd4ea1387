#include "impedraw/capture/capture_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "impedraw/capture/clean_view.h"
#include "impedraw/common/errors.h"

namespace impedraw {

namespace {

// Normals of one side of a surface add up within a cube of 1 cm; of both signs they do not.
bool are_oriented(const CloudFile& file) {
  constexpr double kCube = 0.01, kAgree = 0.7;
  std::map<std::array<long, 3>, Eigen::Vector3d> sums;
  double all = 0.0, together = 0.0;
  for (std::size_t i = 0; i < file.normals.size(); ++i) {
    if (!file.normals[i].allFinite() || file.points[i].cwiseAbs().maxCoeff() > 1e3) continue;
    const Eigen::Vector3d cube = (file.points[i] / kCube).array().floor();
    const std::array key{std::lround(cube.x()), std::lround(cube.y()), std::lround(cube.z())};
    sums.try_emplace(key, Eigen::Vector3d::Zero()).first->second += file.normals[i];
    all += file.normals[i].norm();
  }
  for (const auto& [key, sum] : sums) together += sum.norm();
  return all > 0.0 && together > kAgree * all;
}

}  // namespace

CaptureCloud cloud_of(CloudFile file, const std::string& name,
                      const std::optional<Eigen::Vector3d>& viewpoint,
                      const CloudSettings& settings) {
  Eigen::AlignedBox3d inside, everywhere;
  for (const Eigen::Vector3d& p : file.points) {
    everywhere.extend(p);
    if (settings.region.contains(p)) inside.extend(p);
  }
  if (inside.isEmpty())
    throw InputError(fmt::format(
        "{}: none of its {} points lies within perception.region; they fill ({:.2f} to {:.2f}, "
        "{:.2f} to {:.2f}, {:.2f} to {:.2f}) m",
        name, file.points.size(), everywhere.min().x(), everywhere.max().x(), everywhere.min().y(),
        everywhere.max().y(), everywhere.min().z(), everywhere.max().z()));
  const std::optional<Eigen::Vector3d> said = viewpoint ? viewpoint : file.p_WC;
  const Eigen::Vector3d eye = said.value_or(inside.center() + Eigen::Vector3d::UnitZ());
  const bool oriented = are_oriented(file);
  CaptureCloud result;
  PointCloud& cloud = result.cloud;
  cloud.eyes = {eye};
  int outside = 0, away = 0;
  for (std::size_t i = 0; i < file.points.size(); ++i) {
    const Eigen::Vector3d& p = file.points[i];
    if (!settings.region.contains(p)) {
      ++outside;
    } else if (oriented && file.normals[i].dot(eye - p) < 0.0) {
      ++away;
    } else {
      cloud.points.push_back(p);
      cloud.camera.push_back(0);
    }
  }
  result.notes = {fmt::format(
      "{}: {} points, seen from ({:.2f}, {:.2f}, {:.2f}) m{}: {} are used, {} lie outside "
      "perception.region, {} face away by their normals; {} have no place",
      name, file.points.size() + file.invalid, eye.x(), eye.y(), eye.z(),
      said ? "" : " since nothing says whence", cloud.points.size(), outside, away, file.invalid)};
  if (cloud.points.empty()) throw InputError(result.notes.front());
  return result;
}

CaptureCloud cloud_of(Capture capture, const CloudSettings& settings, const ArmShapes& arm) {
  CaptureCloud result;
  result.notes = std::move(capture.notes);
  PointCloud& cloud = result.cloud;
  for (std::size_t v = 0; v < capture.views.size(); ++v) {
    CapturedView& view = capture.views[v];
    const CleanedCounts counts = clean(&view);
    std::vector<Capsule> body;
    if (!view.joints.empty()) body = arm(view.joints);
    cloud.eyes.push_back(view.X_WC.p);
    int outside = 0, of_arm = 0, without_ray = 0, used = 0;
    for (int j = 0; j < view.lens.height; ++j) {
      for (int i = 0; i < view.lens.width; ++i) {
        const double depth = view.depth.at(i, j);
        if (!std::isfinite(depth)) continue;
        const auto direction = view.lens.direction_C(i, j);
        if (!direction) {
          ++without_ray;
          continue;
        }
        const Eigen::Vector3d p = view.X_WC * Eigen::Vector3d(depth * *direction);
        const auto hides = [&](const Capsule& c) { return inside(c, settings.self_padding, p); };
        if (!settings.region.contains(p)) {
          ++outside;
        } else if (std::any_of(body.begin(), body.end(), hides)) {
          ++of_arm;
        } else {
          ++used;
          cloud.points.push_back(p);
          cloud.camera.push_back(static_cast<int>(v));
        }
      }
    }
    result.notes.push_back(fmt::format(
        "{}: {} of {} pixels measured something; {} are used, {} lie outside perception.region, "
        "{} beside edges, {} in specks, {} on the arm{}",
        view.name, counts.measured, view.depth.depth.size(), used, outside, counts.edges,
        counts.specks, of_arm,
        without_ray ? fmt::format(", {} where the distortion has no inverse", without_ray) : ""));
  }
  if (cloud.points.empty()) {
    std::string text = "perception.capture: no view has a point within perception.region";
    for (const std::string& note : result.notes) text += "; " + note;
    throw InputError(text);
  }
  return result;
}

}  // namespace impedraw
