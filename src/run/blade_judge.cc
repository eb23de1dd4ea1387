#include "impedraw/run/blade_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <nlohmann/json.hpp>

#include "impedraw/control/heading.h"
#include "impedraw/drawing/polyline.h"
#include "impedraw/ink/ink_lines.h"
#include "impedraw/log/log_step.h"
#include "impedraw/run/groove.h"

namespace impedraw {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kWindow = 8e-3;  // of the line, about where the plan is [m]
constexpr double kMoves = 1e-6;   // in a step; slower, it is about to stop and turn [m]

}  // namespace

std::unique_ptr<ToolJudge> tool_judge(const Experiment& e) {
  if (e.scenario.tool.kind == ToolKind::engraver) return std::make_unique<GrooveJudge>(e);
  if (is_led(e.scenario.tool)) return std::make_unique<BladeJudge>(e);
  return nullptr;
}

BladeJudge::BladeJudge(const Experiment& e)
    : X_PW_(e.artwork.X_WP.inverse()),
      yaw_(e.scenario.tool.yaw_deg * kDegree),
      trail_(e.scenario.tool.trail),
      half_(face_of(e.scenario)->radius) {
  const double corner = e.plan.path_settings.corner_angle_deg * kDegree;
  for (const PlacedStroke& stroke : e.plan.strokes) {
    Line& line = lines_.emplace_back();
    double along = stroke.start;
    for (const Eigen::Vector2d& p : stroke.p_P) {
      const double step = line.p.empty() ? 0.0 : (p - line.p.back()).norm();
      if (!line.p.empty() && step < 1e-7) continue;
      along += step;
      line.p.push_back(p);
      line.along.push_back(along);
    }
    for (const std::size_t i : corners(line.p, corner)) line.corners.push_back(line.along[i]);
    corners_ += static_cast<int>(line.corners.size());
  }
}

Eigen::Vector2d BladeJudge::at(const Line& line, double along) {
  const auto after = std::upper_bound(line.along.begin() + 1, line.along.end() - 1, along);
  const auto i = static_cast<std::size_t>(after - line.along.begin());
  const double share = (along - line.along[i - 1]) / (line.along[i] - line.along[i - 1]);
  return line.p[i - 1] + std::clamp(share, 0.0, 1.0) * (line.p[i] - line.p[i - 1]);
}

double BladeJudge::nearest(const Line& line, const Eigen::Vector2d& p, double along, double about) {
  double best = along, least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < line.p.size(); ++i) {
    if (line.along[i] < along - about || line.along[i - 1] > along + about) continue;
    const Eigen::Vector2d way = line.p[i] - line.p[i - 1];
    const double share = std::clamp((p - line.p[i - 1]).dot(way) / way.squaredNorm(), 0.0, 1.0);
    const double off = (p - line.p[i - 1] - share * way).squaredNorm();
    if (off < least) least = off, best = line.along[i - 1] + share * way.norm();
  }
  return best;
}

void BladeJudge::add(const LogRow& row) {
  if (row.stroke < 0 || !std::isfinite(row.stroke_along) || !row.contact_normal.allFinite()) return;
  if (!is_ink(normal_force(row.contact_force, row.contact_normal_W()))) return;
  const Line& line = lines_[static_cast<std::size_t>(row.stroke)];
  if (line.p.size() < 2) return;
  const Eigen::Vector3d n = X_PW_.R * row.contact_normal_W(),
                        x = X_PW_.R * (row.tip_orientation * Eigen::Vector3d::UnitX()),
                        middle = X_PW_ * row.tip_position - trail_ * x;
  const double place = nearest(line, middle.head<2>(), row.stroke_along, kWindow);

  // Corners on either side of the plan's place bound the tangent: the nearest place may lie beyond.
  double least = line.along.front(), most = line.along.back(), corner_at = 1e9;
  for (const double corner : line.corners) {
    if (corner <= row.stroke_along) least = std::max(least, corner);
    if (corner > row.stroke_along) most = std::min(most, corner);
    if (std::abs(corner - place) < std::abs(corner_at - place)) corner_at = corner;
  }
  const double here = std::clamp(place, least, most);
  const double from = std::max(least, here - kNear), to = std::min(most, here + kNear);
  const double moved = row.stroke == last_stroke_ ? std::abs(row.stroke_along - last_along_) : 0.0;
  last_stroke_ = row.stroke;
  last_along_ = row.stroke_along;
  if (moved > kMoves && to - from > 1e-5) {
    const Eigen::Vector2d way = at(line, to) - at(line, from);
    // Lifted along z onto the tangent plane.
    const Eigen::Vector3d t(way.x(), way.y(), -n.head<2>().dot(way) / n.z());
    const double off = yaw_between(t, x, n) - yaw_;
    const double error = std::remainder(off, 2.0 * std::numbers::pi);
    way_ += moved;
    square_ += error * error * moved;
    most_ = std::max(most_, std::abs(error));
  }
  if (std::abs(corner_at - place) > kAbout) return;
  for (const double end : {-1.0, 1.0}) {
    const Eigen::Vector2d p = (middle + (yaw_ == 0.0 ? end * half_ : 0.0) * x).head<2>();
    double off = std::numeric_limits<double>::infinity();
    for (const Line& other : lines_) {
      if (other.p.size() < 2) continue;
      const double about = &other == &line ? kWindow : 1e9;
      off = std::min(off, (p - at(other, nearest(other, p, place, about))).norm());
    }
    smear_ = std::max(smear_, off);
  }
}

nlohmann::ordered_json BladeJudge::results() const {
  nlohmann::ordered_json out;
  for (const char* name : {"yaw_error_rms", "yaw_error_max", "corner_smear"})
    out["metrics"][name] = nullptr;
  if (way_ > 0.0) {
    out["metrics"]["yaw_error_rms"] = std::sqrt(square_ / way_) / kDegree;
    out["metrics"]["yaw_error_max"] = most_ / kDegree;
  }
  if (corners_ > 0) out["metrics"]["corner_smear"] = 1e3 * smear_;
  out["edge_mm"] = 2e3 * half_;
  out["corners"] = corners_;
  return out;
}

}  // namespace impedraw
