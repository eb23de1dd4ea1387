#include "impedraw/experiment/blade_plan.h"

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
constexpr double kMostSmear = 2e-4;  // of an edge's ends beside the line [m]
constexpr double kLook = 5e-3;       // between places on the surface [m]

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
                                           const ToolHeading& heading, double corner_angle,
                                           std::vector<std::string>* notes) {
  const double most = heading.most - heading.least;
  std::vector<PlacedStroke> parts;
  std::string where;
  int cut = 0;
  for (PlacedStroke& stroke : strokes) {
    std::vector<double> cuts{stroke.start};
    double along = stroke.start, turned = 0.0, low = 0.0, high = 0.0;
    for (std::size_t i = 1; i + 1 < stroke.p_P.size(); ++i) {
      along += (stroke.p_P[i] - stroke.p_P[i - 1]).norm();
      const double turn = turn_at(stroke.p_P, i);
      const bool corner = std::abs(turn) > corner_angle;
      turned = corner ? 0.0 : turned + turn;
      low = corner ? 0.0 : std::min(low, turned);
      high = corner ? 0.0 : std::max(high, turned);
      if (high - low < most) continue;
      cuts.push_back(along);
      turned = low = high = 0.0;
    }
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

void require_fit(const Scenario& s, const Plan& plan, const SurfaceHeight& surface,
                 const SettingErrors& errors) {
  if (!is_led(s.tool)) return;
  const PadSettings face = *face_of(s);
  const bool edge = face.face == PadFace::edge;
  const double r = face.radius;
  const auto refuse = [&](const std::string& text) {
    errors.raise({"tool.radius", "control.normal_force", "tool.kind"},
                 fmt::format("tool.radius: {} of {:.2f} mm {}", edge ? "an edge" : "a roller",
                             2e3 * r, text));
  };
  const double corner = plan.path_settings.corner_angle_deg * kDegree;
  for (const PlacedStroke& stroke : plan.strokes) {
    double since = 0.0;
    for (std::size_t i = 1; i < stroke.p_P.size(); ++i) {
      since += (stroke.p_P[i] - stroke.p_P[i - 1]).norm();
      if (i + 1 < stroke.p_P.size() && std::abs(turn_at(stroke.p_P, i)) <= corner) continue;
      if (edge && s.tool.yaw_deg == 0.0 && since < 2.0 * r && stroke.p_P.size() > 2)
        refuse(fmt::format(
            "is longer than what lies between two corners of stroke {}, {:.2f} mm at page ({:.1f}, "
            "{:.1f}) mm; valid is a larger drawing, or an edge up to that",
            stroke.number, 1e3 * since, stroke.page[i].x(), stroke.page[i].y()));
      since = 0.0;
    }
  }
  SurfaceHeight::Sample last;
  const Pose X_PW = plan.path_settings.X_WP.inverse();
  Eigen::Vector3d looked = Eigen::Vector3d::Constant(1e9);
  for (double t = 0.0; t < plan.path.duration(); t += 5e-3) {
    const PathSample sample = plan.path.at(t);
    const TipReference& at = sample.reference;
    const double speed =
        std::abs(at.v_WD.dot(turned_about(at.n_WD, at.x_WD, -plan.path_settings.heading->yaw)));
    if (sample.stroke < 0 || speed < 1e-3) continue;
    const double bend = std::abs(at.yaw_rate) / speed, beside = 0.5 * r * r * bend;
    const auto page = place_on(plan.strokes[static_cast<std::size_t>(sample.stroke)], sample.along);
    const std::string place = fmt::format("stroke {}, at page ({:.1f}, {:.1f}) mm", sample.stroke,
                                          page.page.x(), page.page.y());
    if (edge && s.tool.yaw_deg == 0.0 && beside > kMostSmear)
      refuse(fmt::format(
          "stands {:.2f} mm beside the line where that bends with a radius of {:.1f} mm: {}; valid "
          "is an edge up to {:.2f} mm",
          1e3 * beside, 1e3 / bend, place, 2e3 * std::sqrt(2.0 * kMostSmear / bend)));
    if ((at.p_WD - looked).norm() < kLook) continue;
    looked = at.p_WD;
    const Eigen::Vector3d p = X_PW * at.p_WD, n = X_PW.R * at.n_WD, x = X_PW.R * at.x_WD;
    const Eigen::Vector3d out = edge ? x : Eigen::Vector3d(n.cross(x));
    const auto middle = surface(p.x(), p.y(), last);
    for (const double way : {-1.0, 1.0}) {
      const Eigen::Vector3d q = p + way * r * out;
      const auto there = surface(q.x(), q.y(), last);
      if (!middle || !there) continue;
      const double gap = n.dot(there->p_P - middle->p_P);
      if (std::abs(gap) > face.rest)
        refuse(
            fmt::format("touches the curved surface with a part of it only, {:.2f} mm above the "
                        "rest where it is pressed in by {:.2f} mm: {}; valid is a shorter one, "
                        "or more control.normal_force",
                        1e3 * std::abs(gap), 1e3 * face.rest, place));
    }
  }
}

}  // namespace impedraw
