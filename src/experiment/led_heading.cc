#include "impedraw/experiment/led_heading.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/drawing/polyline.h"
#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

// The places at which a stroke is cut that turns the tool further between two corners than the arm
// can [m]: with a range below 360° where its heading leaves the range or comes back into it, else
// where the range is used up.
std::vector<double> turned_too_far(const PlacedStroke& stroke, const ToolHeading& heading,
                                   const Pose& X_WP, double corner_angle) {
  const double range = heading.most - heading.least, middle = 0.5 * (heading.most + heading.least);
  const Eigen::Vector3d x = X_WP.R.transpose() * heading.start_x_W;
  const double zero = std::atan2(x.y(), x.x()) - heading.yaw + middle;
  std::vector<double> cuts, since;  // since the last corner
  double along = stroke.start, turned = 0.0, low = 0.0, high = 0.0;
  bool within_before = true;
  for (std::size_t i = 1; i < stroke.p_P.size(); ++i) {
    const Eigen::Vector2d way = stroke.p_P[i] - stroke.p_P[i - 1];
    const double off = std::remainder(std::atan2(way.y(), way.x()) - zero, 2.0 * std::numbers::pi);
    const bool within = std::abs(off) <= 0.5 * range, last = i + 1 == stroke.p_P.size();
    if (turned != 0.0 && within != within_before) since.push_back(along);
    within_before = within;
    along += way.norm();
    const double turn = last ? 0.0 : turn_at(stroke.p_P, i);
    if (last || std::abs(turn) > corner_angle) {
      if (high - low >= range) cuts.insert(cuts.end(), since.begin(), since.end());
      since.clear();
      turned = low = high = 0.0;
      continue;
    }
    turned += turn;
    low = std::min(low, turned);
    high = std::max(high, turned);
    if (range < 2.0 * std::numbers::pi || high - low < range) continue;
    cuts.push_back(along);
    turned = low = high = 0.0;
  }
  return cuts;
}

// The angle by which the arm can turn the tool about n in one direction, from q [rad].
double turn_range(ArmModel* arm, const JointVector& q_0, double way, double margin) {
  constexpr double kStep = 0.05, kMost = 4.0 * std::numbers::pi, kJump = 0.5;
  const Pose X_WE = arm->tip_pose(q_0);
  const Eigen::Vector3d n = -X_WE.R.col(2);
  IkSettings ik;
  ik.position_tolerance = ik.axis_tolerance = 1e-5;
  ik.max_steps = 40;
  JointVector q = q_0;
  for (double turned = 0.0; turned < kMost; turned += kStep) {
    const Eigen::Vector3d x = turned_about(n, X_WE.R.col(0), way * (turned + kStep));
    const IkResult found = find_posture(*arm, {X_WE.p, -n, x}, q, ik);
    const double room = std::min((found.q - arm->limits().lower).minCoeff(),
                                 (arm->limits().upper - found.q).minCoeff());
    if (!found.reached || room < margin || (found.q - q).cwiseAbs().maxCoeff() > kJump)
      return turned;
    q = found.q;
  }
  return kMost;
}

}  // namespace

std::optional<ToolHeading> heading_of(const Scenario& s, const ArmModel& arm,
                                      const JointVector& q) {
  if (!is_led(s.tool)) return std::nullopt;
  ArmModel model = arm;
  ToolHeading heading;
  heading.yaw = s.tool.yaw_deg * kDegree;
  heading.trail = s.tool.trail;
  heading.lifted = s.tool.swivel == Swivel::lifted;
  heading.start_x_W = model.tip_pose(q).R.col(0);
  const double margin = s.preflight.joint_margin;
  heading.least = std::min(0.0, kHeadingReserve - turn_range(&model, q, -1.0, margin));
  heading.most = std::max(0.0, turn_range(&model, q, 1.0, margin) - kHeadingReserve);
  return heading;
}

std::vector<PlacedStroke> cut_where_turned(std::vector<PlacedStroke> strokes,
                                           const ToolHeading& heading, const Pose& X_WP,
                                           double corner_angle, std::vector<std::string>* notes) {
  const double most = heading.most - heading.least;
  std::vector<PlacedStroke> parts;
  std::string where;
  int cut = 0;
  for (PlacedStroke& stroke : strokes) {
    std::vector<double> cuts{stroke.start};
    for (const double along : turned_too_far(stroke, heading, X_WP, corner_angle))
      cuts.push_back(along);
    const double end = stroke.start + plane_length(stroke);
    if (cuts.size() > 1) where += fmt::format("{}{}", where.empty() ? "" : ", ", stroke.number);
    cut += static_cast<int>(cuts.size()) - 1;
    if (cuts.size() == 1) {
      parts.push_back(std::move(stroke));
      continue;
    }
    const StrokeRuler ruler(stroke);
    for (std::size_t k = 0; k < cuts.size(); ++k)
      parts.push_back(ruler.part(cuts[k], k + 1 < cuts.size() ? cuts[k + 1] : end));
  }
  if (cut > 0)
    notes->push_back(fmt::format(
        "yaw: the arm turns the tool by {:.0f}°, and stroke {} needs more: it is lifted {} time{} "
        "on the way and turned back",
        most / kDegree, where, cut, cut == 1 ? "" : "s"));
  return parts;
}

}  // namespace impedraw
