#include "impedraw/experiment/place_wish.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include <fmt/format.h>

#include "impedraw/common/text_fields.h"
#include "impedraw/experiment/plan.h"
#include "impedraw/planning/leant.h"
#include "impedraw/planning/preflight/posture_check.h"

namespace impedraw {

using Eigen::Vector3d;

namespace {

constexpr double kNear = 2.0;  // cost of the object's whole extent away from where it is wanted
constexpr double kCalmIfNear = 0.3;  // weight of a calm surface then

}  // namespace

std::function<double(const Vector3d&)> distance_of(const std::string& near,
                                                   const std::vector<Vector3d>& points) {
  static const std::map<std::string, Vector3d> sides = {{"front", Vector3d::UnitX()},
                                                        {"back", -Vector3d::UnitX()},
                                                        {"left", Vector3d::UnitY()},
                                                        {"right", -Vector3d::UnitY()},
                                                        {"top", Vector3d::UnitZ()}};
  if (near.empty()) return {};
  if (const auto side = sides.find(near); side != sides.end()) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Vector3d& p : points) {
      low = std::min(low, side->second.dot(p));
      high = std::max(high, side->second.dot(p));
    }
    return [d = side->second, high, extent = std::max(high - low, 1e-3)](const Vector3d& p) {
      return (high - d.dot(p)) / extent;
    };
  }
  const std::vector<std::string_view> fields = fields_of(near);
  std::vector<double> x;
  for (const std::string_view field : fields)
    if (const auto number = number_in(field); number && std::abs(*number) <= 10.0)
      x.push_back(*number);
  if (x.size() != 3 || fields.size() != 3)
    throw InputError(fmt::format(
        "--near: '{}' is no place; valid are front, back, left, right, top, or x,y,z in m", near));
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(p);
  return [at = Vector3d(x[0], x[1], x[2]), extent = std::max(box.diagonal().norm() / 2, 1e-3)](
             const Vector3d& p) { return (p - at).norm() / extent; };
}

std::function<double(const SurfaceSample&)> unreachable(const Belief& belief, const Pose& X_WP,
                                                        const PreflightSettings& settings,
                                                        const Vector3d& up) {
  const auto check =
      std::make_shared<PostureCheck>(belief.arm, belief.obstacle.get(), belief.start_q, settings);
  return [check, X_WP, up, start_q = belief.start_q, upright = settings.vertical_pen,
          lean = settings.lean_deg](const SurfaceSample& at) {
    constexpr double kEasy = 0.4, kStrained = 0.05;  // joint margin [rad]; cost of none
    const Vector3d n = upright ? Vector3d(Vector3d::UnitZ()) : leant(at.n_P, lean);
    const Posture posture = check->enter({X_WP * at.p_P, -(X_WP.R * n)}, start_q);
    if (!posture.reached || posture.problem) return 1.0;
    if (!up.isZero()) {
      const Posture raised = check->follow({X_WP * at.p_P + up, -(X_WP.R * n)}, posture, up.norm());
      if (!raised.reached || raised.problem) return 1.0;
    }
    return kStrained * (1.0 - std::clamp(posture.margins.joint / kEasy, 0.0, 1.0));
  };
}

std::vector<Vector3d> known_points(const Belief& belief, const Pose& X_WP) {
  std::vector<Vector3d> points =
      belief.planning ? belief.planning->cloud().points : belief.obstacle->mesh().vertices;
  for (Vector3d& p : points) p = X_WP.inverse() * p;
  return points;
}

PlaceSearchSettings search_settings(const Scenario& s, const Belief& belief, const Pose& X_WP,
                                    const std::string& near) {
  PlaceSearchSettings settings;
  std::vector<Vector3d> points_W;
  for (const Vector3d& p : known_points(belief, X_WP)) {
    settings.box.extend(p.head<2>());
    points_W.push_back(X_WP * p);
  }
  settings.max_slope_deg = s.preflight.max_slope_deg;
  settings.unreachable = unreachable(
      belief, X_WP, preflight_settings(s, X_WP, belief.perception != nullptr, belief.start_q));
  if (const auto distance = distance_of(near, points_W)) {
    settings.calm = kCalmIfNear;
    settings.near = [distance, X_WP](const Vector3d& p_P) { return kNear * distance(X_WP * p_P); };
  }
  if (belief.perception)
    settings.rough = [&belief, X_WP, most = s.preflight.roughest](const Vector3d& p_P) {
      return belief.perception->roughness(X_WP * p_P).misfit / most;
    };
  return settings;
}

}  // namespace impedraw
