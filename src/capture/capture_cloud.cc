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
  std::map<std::array<double, 3>, Eigen::Vector3d> sums;
  double all = 0.0, together = 0.0;
  for (std::size_t i = 0; i < file.normals.size(); ++i) {
    if (!file.normals[i].allFinite()) continue;
    const Eigen::Vector3d cube = (file.points[i] / kCube).array().floor();
    sums.try_emplace({cube.x(), cube.y(), cube.z()}, Eigen::Vector3d::Zero()).first->second +=
        file.normals[i];
    all += file.normals[i].norm();
  }
  for (const auto& [key, sum] : sums) together += sum.norm();
  return all > 0.0 && together > kAgree * all;
}

}  // namespace

CaptureCloud cloud_of(const CloudFile& file, const std::string& name,
                      const std::vector<Eigen::Vector3d>& viewpoints,
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
  CaptureCloud result;
  PointCloud& cloud = result.cloud;
  cloud.eyes = viewpoints.empty() ? file.viewpoints : viewpoints;
  const bool said = !cloud.eyes.empty(), each = viewpoints.empty() && !file.seen_from.empty(),
             oriented = are_oriented(file);
  if (!said) cloud.eyes.emplace_back(inside.center() + Eigen::Vector3d::UnitZ());
  int outside = 0, away = 0;
  for (std::size_t i = 0; i < file.points.size(); ++i) {
    const Eigen::Vector3d& p = file.points[i];
    if (!settings.region.contains(p)) {
      ++outside;
      continue;
    }
    const auto merit = [&](const Eigen::Vector3d& eye) {
      const double distance = (eye - p).norm();
      return oriented ? file.normals[i].dot(eye - p) / distance : -distance;
    };
    const auto best =
        std::max_element(cloud.eyes.begin(), cloud.eyes.end(),
                         [&](const auto& a, const auto& b) { return merit(a) < merit(b); });
    const int eye = each ? file.seen_from[i] : static_cast<int>(best - cloud.eyes.begin());
    if (oriented && merit(cloud.eyes[static_cast<std::size_t>(eye)]) < 0.0) {
      ++away;
      continue;
    }
    cloud.points.push_back(p);
    cloud.camera.push_back(eye);
    if (!file.rgb.empty())
      cloud.rgb.insert(cloud.rgb.end(), &file.rgb[3 * i], &file.rgb[3 * i] + 3);
  }
  const Eigen::Vector3d& eye = cloud.eyes.front();
  result.notes = {fmt::format(
      "{}: {} points, seen from ({:.2f}, {:.2f}, {:.2f}) m{}: {} are used, {} lie outside "
      "perception.region, {} face away by their normals; {} have no place",
      name, file.points.size() + file.invalid, eye.x(), eye.y(), eye.z(),
      !said                    ? ", since nothing says whence"
      : cloud.eyes.size() == 1 ? std::string()
                               : fmt::format(" and {} other places", cloud.eyes.size() - 1),
      cloud.points.size(), outside, away, file.invalid)};
  if (cloud.points.empty()) throw InputError(result.notes.front());
  return result;
}

CaptureCloud cloud_of(Capture capture, const CloudSettings& settings, const ArmShapes& arm) {
  CaptureCloud result;
  result.notes = std::move(capture.notes);
  PointCloud& cloud = result.cloud;
  const bool coloured = std::any_of(capture.views.begin(), capture.views.end(),
                                    [](const CapturedView& v) { return !v.rgb.empty(); });
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
          if (!coloured) continue;
          const std::size_t at = 3 * (static_cast<std::size_t>(j) * view.lens.width + i);
          const auto none = {std::uint8_t{128}, std::uint8_t{128}, std::uint8_t{128}};
          if (view.rgb.empty())
            cloud.rgb.insert(cloud.rgb.end(), none);
          else
            cloud.rgb.insert(cloud.rgb.end(), &view.rgb[at], &view.rgb[at] + 3);
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
