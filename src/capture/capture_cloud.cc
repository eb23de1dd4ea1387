#include "impedraw/capture/capture_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "impedraw/capture/clean_view.h"
#include "impedraw/common/errors.h"
#include "impedraw/perception/normals.h"

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

namespace {

// The points of a view in W within a region.
struct ViewPoints {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::size_t> pixel;
  int outside = 0, of_arm = 0, without_ray = 0;
};

// Pixels that hang together with pixels of the arm are the arm's as far as two paddings off: a
// stereo camera's halo, and an arm that stands beside where the camera's calibration puts it.
ViewPoints points_of(const CapturedView& view, const Eigen::AlignedBox3d& region,
                     const std::vector<Capsule>& arm, double padding) {
  enum Pixel : char { none, seen, near_arm, of_arm };
  const int width = view.lens.width, height = view.lens.height;
  ViewPoints found;
  std::vector<Pixel> pixels(static_cast<std::size_t>(width) * height, none);
  std::vector<Eigen::Vector3d> places(pixels.size());
  std::vector<std::size_t> arms;  // pixels whose neighbours are yet to be looked at
  for (std::size_t k = 0; k < pixels.size(); ++k) {
    const int i = static_cast<int>(k) % width, j = static_cast<int>(k) / width;
    const double depth = view.depth.at(i, j);
    if (!std::isfinite(depth)) continue;
    const auto direction = view.lens.direction_C(i, j);
    if (!direction) {
      ++found.without_ray;
      continue;
    }
    places[k] = view.X_WC * Eigen::Vector3d(depth * *direction);
    const auto within = [&](double distance) {
      return std::any_of(arm.begin(), arm.end(),
                         [&](const Capsule& c) { return inside(c, distance, places[k]); });
    };
    if (!region.contains(places[k])) {
      ++found.outside;
    } else if (within(padding)) {
      pixels[k] = of_arm;
      arms.push_back(k);
    } else {
      pixels[k] = within(2.0 * padding) ? near_arm : seen;
    }
  }
  for (std::size_t at = 0; at < arms.size(); ++at) {
    const int i = static_cast<int>(arms[at]) % width, j = static_cast<int>(arms[at]) / width;
    for (const auto& [x, y] : {std::pair{i - 1, j}, {i + 1, j}, {i, j - 1}, {i, j + 1}}) {
      if (x < 0 || y < 0 || x >= width || y >= height) continue;
      const std::size_t k = static_cast<std::size_t>(y) * width + x;
      if (pixels[k] != near_arm || (places[k] - places[arms[at]]).norm() > padding) continue;
      pixels[k] = of_arm;
      arms.push_back(k);
    }
  }
  found.of_arm = static_cast<int>(arms.size());
  for (std::size_t k = 0; k < pixels.size(); ++k) {
    if (pixels[k] != seen && pixels[k] != near_arm) continue;
    found.points.push_back(places[k]);
    found.pixel.push_back(k);
  }
  return found;
}

// Samples of a view's surface: points of its thinned cloud, put onto the surface that is fitted to
// their neighbours. What stands beside the region, as a table cut off by it, helps, too.
ViewSamples samples_of(const CapturedView& view, const CloudSettings& settings,
                       const std::vector<Capsule>& arm) {
  constexpr double kBeside = 0.05, kVoxel = 0.004;  // [m]
  constexpr std::size_t kMost = 6000;
  constexpr double kLeastDeviation = 2e-5;  // [m]
  ViewSamples samples{view.name, view.X_WC.p, {}};
  Eigen::AlignedBox3d region = settings.region;
  region.min().array() -= kBeside;
  region.max().array() += kBeside;
  PointCloud cloud;
  cloud.points = points_of(view, region, arm, settings.self_padding).points;
  cloud.camera.assign(cloud.points.size(), 0);
  cloud.eyes = {view.X_WC.p};
  cloud = thin(cloud, std::max(kVoxel, settings.voxel));
  NormalSettings normals;
  normals.k = noise_at_1m(view) > 5e-4 ? 80 : 40;
  if (cloud.points.size() < static_cast<std::size_t>(normals.k)) return samples;
  const SurfaceEstimator surface(std::move(cloud), normals);
  const std::vector<Eigen::Vector3d>& points = surface.cloud().points;
  const std::size_t stride = points.size() / kMost + 1;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const SurfaceEstimate at = surface.estimate(points[i]);
    if (at.status != SurfaceStatus::ok) continue;
    const double deviation = surface.roughness(points[i]).residual / std::sqrt(normals.k / 4.0);
    samples.samples.push_back(
        {points[i] - at.distance * at.n_W, at.n_W, std::max(kLeastDeviation, deviation)});
  }
  return samples;
}

// Puts the views onto each other.
void align(Capture* capture, const CloudSettings& settings,
           const std::vector<std::vector<Capsule>>& arms, CaptureCloud* result) {
  std::vector<ViewSamples> samples;
  for (std::size_t v = 0; v < capture->views.size(); ++v)
    samples.push_back(samples_of(capture->views[v], settings, arms[v]));
  result->alignment = align_views(samples);
  const ViewAlignment& found = result->alignment;
  for (std::size_t v = 0; v < capture->views.size(); ++v) {
    CapturedView& view = capture->views[v];
    const AlignedView& aligned = found.views[v];
    view.X_WC = aligned.T * view.X_WC;
    if (aligned.matches == 0) {
      result->notes.push_back(view.name +
                              ": overlaps with no other view; it stays where it is calibrated");
      continue;
    }
    std::string open;
    for (const OpenDirection& d : aligned.open) open += (open.empty() ? "" : ", ") + d.text();
    result->notes.push_back(
        fmt::format("{}: moved onto the other views by {:.2f} mm and {:.3f}° of its camera{}",
                    view.name, 1e3 * aligned.shift, aligned.turn_deg,
                    open.empty() ? "" : "; as calibrated where the shape tells nothing: " + open));
  }
  if (found.rms > 0.0)
    result->notes.push_back(
        fmt::format("the views are {:.2f} mm RMS apart along the normals, {:.2f} mm before they "
                    "were put onto each other",
                    1e3 * found.rms, 1e3 * found.rms_before));
}

// Throws InputError for a camera that the points enclose: there is hardly a direction from it
// without one.
void refuse_enclosed(const Capture& capture, const PointCloud& cloud) {
  constexpr int kSides = 8, kCells = 6 * kSides * kSides;
  constexpr double kEnclosed = 0.6, kNear = 2.0;  // [m]
  for (const CapturedView& view : capture.views) {
    std::vector<char> seen(kCells);
    for (const Eigen::Vector3d& p : cloud.points) {
      const Eigen::Vector3d d = p - view.X_WC.p;
      if (d.norm() > kNear) continue;
      int axis = 0;
      const double most = d.cwiseAbs().maxCoeff(&axis);
      if (most == 0.0) continue;
      const auto cell = [&](int k) {
        const double x = 0.5 + 0.5 * d[(axis + k) % 3] / most;
        return std::clamp(static_cast<int>(x * kSides), 0, kSides - 1);
      };
      const int at = ((2 * axis + (d[axis] > 0 ? 1 : 0)) * kSides + cell(1)) * kSides + cell(2);
      seen[static_cast<std::size_t>(at)] = 1;
    }
    if (std::count(seen.begin(), seen.end(), 1) > kEnclosed * kCells)
      throw InputError(fmt::format(
          "{}: its camera lies inside of what the views show, at ({:.2f}, {:.2f}, {:.2f}) m",
          view.name, view.X_WC.p.x(), view.X_WC.p.y(), view.X_WC.p.z()));
  }
}

}  // namespace

CaptureCloud cloud_of(Capture capture, const CloudSettings& settings, const ArmShapes& arm,
                      bool aligned) {
  CaptureCloud result;
  result.notes = std::move(capture.notes);
  PointCloud& cloud = result.cloud;
  const bool coloured = std::any_of(capture.views.begin(), capture.views.end(),
                                    [](const CapturedView& v) { return !v.rgb.empty(); });
  std::vector<CleanedCounts> counts;
  std::vector<std::vector<Capsule>> arms;
  for (CapturedView& view : capture.views) {
    counts.push_back(clean(&view));
    smooth_quanta(view.quantum, &view.depth);
    arms.push_back(view.joints.empty() ? std::vector<Capsule>{} : arm(view.joints));
  }
  if (aligned && capture.views.size() > 1) align(&capture, settings, arms, &result);
  for (std::size_t v = 0; v < capture.views.size(); ++v) {
    const CapturedView& view = capture.views[v];
    const ViewPoints found = points_of(view, settings.region, arms[v], settings.self_padding);
    cloud.eyes.push_back(view.X_WC.p);
    result.views.push_back(view.name);
    cloud.points.insert(cloud.points.end(), found.points.begin(), found.points.end());
    cloud.camera.insert(cloud.camera.end(), found.points.size(), static_cast<int>(v));
    for (std::size_t k = 0; coloured && k < found.pixel.size(); ++k)
      for (std::size_t c = 0; c < 3; ++c)
        cloud.rgb.push_back(view.rgb.empty() ? std::uint8_t{128}
                                             : view.rgb[3 * found.pixel[k] + c]);
    result.notes.push_back(fmt::format(
        "{}: {} of {} pixels measured something; {} are used, {} lie outside perception.region, "
        "{} beside edges, {} in specks, {} on the arm{}",
        view.name, counts[v].measured, view.depth.depth.size(), found.points.size(), found.outside,
        counts[v].edges, counts[v].specks, found.of_arm,
        found.without_ray
            ? fmt::format(", {} where the distortion has no inverse", found.without_ray)
            : ""));
  }
  if (cloud.points.empty()) {
    std::string text = "perception.capture: no view has a point within perception.region";
    for (const std::string& note : result.notes) text += "; " + note;
    throw InputError(text);
  }
  refuse_enclosed(capture, cloud);
  return result;
}

}  // namespace impedraw
