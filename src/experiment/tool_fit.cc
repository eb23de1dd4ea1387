#include "impedraw/experiment/tool_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/drawing/polyline.h"
#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

// The places at which a stroke is cut whose heading, between two corners, is not all within the
// arm's range, whichever turn leads there [m]: with a range below 360° where its heading leaves the
// range or comes back into it, else where no turn is left that leads on.
std::vector<double> turned_too_far(const PlacedStroke& stroke, const ToolHeading& heading,
                                   double reserve, const Pose& X_WP, double corner_angle) {
  const double range = heading.most - heading.least, middle = 0.5 * (heading.most + heading.least);
  const Eigen::Vector3d x = X_WP.R.transpose() * heading.start_x_W;
  const double zero = std::atan2(x.y(), x.x()) - heading.yaw + middle;
  constexpr double kRound = 2.0 * std::numbers::pi;
  std::vector<double> cuts, since;  // since the last corner
  double along = stroke.start, turned = 0.0, low = 0.0, high = 0.0, first = 0.0;
  bool within_before = true;
  const double most = 0.5 * range + (range < kRound ? reserve : 0.0);
  const auto fits = [&] {
    const double least = first + low, up = kRound * std::ceil((-most - least) / kRound);
    return first + high + up <= most;
  };
  for (std::size_t i = 1; i < stroke.p_P.size(); ++i) {
    const Eigen::Vector2d way = stroke.p_P[i] - stroke.p_P[i - 1];
    const double off = std::remainder(std::atan2(way.y(), way.x()) - zero, kRound);
    if (low == 0.0 && high == 0.0) first = off - turned;
    const bool within = std::abs(off) <= 0.5 * range, last = i + 1 == stroke.p_P.size();
    if (turned != 0.0 && within != within_before) since.push_back(along);
    within_before = within;
    along += way.norm();
    const double turn = last ? 0.0 : turn_at(stroke.p_P, i);
    if (last || std::abs(turn) > corner_angle) {
      if (!fits()) cuts.insert(cuts.end(), since.begin(), since.end());
      since.clear();
      turned = low = high = 0.0;
      continue;
    }
    turned += turn;
    low = std::min(low, turned);
    high = std::max(high, turned);
    if (range < kRound || fits()) continue;
    cuts.push_back(along);
    turned = low = high = 0.0;
  }
  return cuts;
}

// The angle by which the arm can turn the tool about n in one direction, from q [rad].
double turn_range(ArmModel* arm, const JointVector& q_0, double way, double margin) {
  constexpr double kYawStep = 0.05, kMost = 4.0 * std::numbers::pi, kYawJump = 0.5;
  const Pose X_WE = arm->tip_pose(q_0);
  const Eigen::Vector3d n = -X_WE.R.col(2);
  IkSettings ik;
  ik.position_tolerance = ik.axis_tolerance = 1e-5;
  ik.max_steps = 40;
  JointVector q = q_0;
  for (double turned = 0.0; turned < kMost; turned += kYawStep) {
    const Eigen::Vector3d x = turned_about(n, X_WE.R.col(0), way * (turned + kYawStep));
    const IkResult found = find_posture(*arm, {X_WE.p, -n, x}, q, ik);
    const double room = std::min((found.q - arm->limits().lower).minCoeff(),
                                 (arm->limits().upper - found.q).minCoeff());
    if (!found.reached || room < margin || (found.q - q).cwiseAbs().maxCoeff() > kYawJump)
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
                                           const ToolHeading& heading, double reserve,
                                           const Pose& X_WP, double corner_angle,
                                           std::vector<std::string>* notes) {
  const double most = heading.most - heading.least;
  std::vector<PlacedStroke> parts;
  std::string where;
  int cut = 0;
  for (PlacedStroke& stroke : strokes) {
    std::vector<double> cuts{stroke.start};
    for (const double along : turned_too_far(stroke, heading, reserve, X_WP, corner_angle))
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
    notes->push_back(
        fmt::format("yaw: the arm turns the tool by {:.0f}°, and stroke {} leads beyond: it is "
                    "lifted {} time{} "
                    "on the way and turned back",
                    most / kDegree, where, cut, cut == 1 ? "" : "s"));
  return parts;
}

namespace {

constexpr double kMostSmear = 2e-4;  // of an edge's ends beside the line [m]
constexpr double kLook = 5e-3;       // between places on the surface [m]

// A pad on a surface that bends by more than its foam gives: it touches about its middle alone, or
// with its rim alone. A paraboloid that falls by s to the rim presses a foam, which a plane would
// press in by δ, in by δ + s/2 at the middle, or, where the rim does not touch (s > 2 δ), by
// √(2 δ s). Where it rises by s, middle and rim change places.
void require_rim(const Scenario& s, const Plan& plan, const SurfaceHeight& surface,
                 const SettingErrors& errors) {
  const std::optional<PadSettings> pad = face_of(s);
  if (!pad) return;
  const Pose X_PW = plan.path_settings.X_WP.inverse();
  SurfaceHeight::Sample last;
  Eigen::Vector3d looked = Eigen::Vector3d::Constant(1e9);
  for (double t = 0.0; t < plan.path.duration(); t += 5e-3) {
    const PathSample sample = plan.path.at(t);
    if (sample.stroke < 0 || (sample.reference.p_WD - looked).norm() < kLook) continue;
    looked = sample.reference.p_WD;
    const Eigen::Vector3d p = X_PW * looked, n = X_PW.R * sample.reference.n_WD,
                          x = n.unitOrthogonal();
    const auto middle = surface(p.x(), p.y(), last);
    double falls = std::numeric_limits<double>::infinity(), rises = falls;
    for (int k = 0; middle && k < 8; ++k) {
      const Eigen::Vector3d q = p + pad->radius * turned_about(n, x, k * std::numbers::pi / 4.0);
      const auto there = surface(q.x(), q.y(), last);
      if (!there) continue;
      falls = std::min(falls, n.dot(middle->p_P - there->p_P));
      rises = std::min(rises, n.dot(there->p_P - middle->p_P));
    }
    const double bend = std::max(falls, rises);
    if (!std::isfinite(bend) || bend <= 2.0 * pad->rest) continue;
    const bool ball = falls > rises;
    const double pressed = std::sqrt(2.0 * pad->rest * bend);
    const auto place =
        place_on(plan.strokes[static_cast<std::size_t>(sample.stroke)], sample.along);
    errors.raise(
        {"tool.radius", "control.normal_force", "tool.kind"},
        fmt::format("tool.radius: a pad of {:.1f} mm touches {} alone, its {} stays {:.2f} mm off "
                    "the surface where the {} presses the foam in by {:.2f} mm: stroke {}, at page "
                    "({:.1f}, {:.1f}) mm; valid is a smaller pad, softer foam or more force",
                    2e3 * pad->radius, ball ? "about its middle" : "with its rim",
                    ball ? "rim" : "middle", 1e3 * (bend - pressed), ball ? "middle" : "rim",
                    1e3 * pressed, sample.stroke, place.page.x(), place.page.y()));
  }
}

}  // namespace

void require_own_settings(const ToolSettings& tool, const Places& places) {
  using enum ToolKind;
  struct Kind {
    ToolKind kind;
    const char* name;
    std::vector<std::string> settings;
  };
  static const std::vector<Kind> kKinds = {
      {pen, "pen", {}},
      {pad, "pad", {"radius", "foam_stiffness", "joints", "pivot"}},
      {engraver, "engraver", {"depth", "half_angle", "passes", "hardness"}},
      {blade, "blade", {"radius", "half_angle", "hardness", "yaw", "trail", "swivel"}},
      {roller, "roller", {"radius", "foam_stiffness", "hardness", "yaw", "trail", "swivel"}},
      {nozzle, "nozzle", {"radius", "stand_off"}}};
  const Kind& own = *std::ranges::find(kKinds, tool.kind, &Kind::kind);
  const auto has = [](const Kind& kind, const std::string& setting) {
    return std::ranges::count(kind.settings, setting) > 0;
  };
  const auto file_of = [&](const std::string& setting) {
    const std::string place = places.of("tool." + setting);
    return place.starts_with("--") ? "--set" : place.substr(0, place.rfind(':'));
  };
  std::vector<std::string> foreign;
  for (const Kind& other : kKinds)
    for (const std::string& setting : other.settings)
      if (!has(own, setting) && std::ranges::count(foreign, setting) == 0)
        foreign.push_back(setting);
  const auto given_in = [&](const std::string& file) {
    std::vector<std::string> given;
    for (const std::string& setting : foreign)
      if (file_of(setting) == file) given.push_back(setting);
    return given;
  };
  std::vector<std::string> given = given_in("--set");
  if (given.empty()) given = given_in(file_of("kind"));
  // A file that gives all of them was written by a run.
  if (given.empty() || (file_of(given.front()) != "--set" && given.size() == foreign.size()))
    return;
  const std::string& wrong = given.front();
  std::vector<std::string> owners;
  for (const Kind& kind : kKinds)
    if (has(kind, wrong)) owners.emplace_back(kind.name);
  const std::string instead =
      own.settings.empty() ? ""
                           : fmt::format("one of tool.{}, or ", fmt::join(own.settings, ", tool."));
  SettingErrors(places).raise(
      {"tool." + wrong},
      fmt::format("tool.{} is given, and tool.kind is {}, which has none; valid is {}tool.kind: {}",
                  wrong, own.name, instead, fmt::join(owners, ", ")));
}

namespace {

// Friction μ F at the lever L from the joints' centre to the surface moves the middle of the
// pressure by μ L, which lifts the face's rim from r/4 on. With half as much again the pad still
// treats evenly; with twice as much it slides on its edge.
void require_level(const PadSettings& pad, double friction, const SettingErrors& errors) {
  constexpr double kMostLean = 1.5;
  const double lever = pad.lever(), most = kMostLean * pad.radius / (4.0 * friction);
  if (pad.joints == 0 || std::abs(lever) <= most) return;
  const double end = 1e4 * (pad.pivot - lever + std::copysign(most, lever));
  errors.raise(
      {"tool.pivot", "tool.joints", "tool.radius"},
      fmt::format("tool.pivot: a pad of {:.1f} mm with joints {:.1f} mm {} the surface slides on "
                  "its edge, by control.friction {:.3g}; valid is tool.pivot {} {:.4f} m, "
                  "tool.joints: 0, or a larger pad",
                  2e3 * pad.radius, 1e3 * std::abs(lever), lever > 0.0 ? "above" : "below",
                  friction, lever > 0.0 ? "up to" : "from",
                  1e-4 * (lever > 0.0 ? std::floor(end) : std::ceil(end))));
}

}  // namespace

void require_foam(const Scenario& s, const SettingErrors& errors) {
  constexpr double kMostPressed = 0.85;  // of the foam's thickness; more of it counts as a wall
  const auto pad = pad_of(s.tool, s.world.tip.friction, s.control.normal_force);
  if (!pad) return;
  const double share = pad->rest / (kMostPressed * pad->thickness);
  if (share <= 1.0) return require_level(*pad, s.control.friction.coefficient, errors);
  errors.raise(
      {"tool.radius", "tool.foam_stiffness", "control.normal_force", "tool.kind"},
      fmt::format("tool.radius: {:.3g} N press the foam of a pad of {:.1f} mm in by {:.1f} "
                  "mm, and it is {:.0f} mm thick; valid is control.normal_force up to "
                  "{:.2g} N, tool.foam_stiffness from {:.2g} N/m³, or a pad from {:.1f} mm",
                  s.control.normal_force, 2e3 * pad->radius, 1e3 * pad->rest, 1e3 * pad->thickness,
                  s.control.normal_force / share, pad->stiffness * share,
                  2e3 * pad->radius * std::sqrt(share)));
}

void require_fit(const Scenario& s, const Plan& plan, const SurfaceHeight& surface,
                 const SettingErrors& errors) {
  if (s.path.lean_deg > 0.0 && s.tool.kind != ToolKind::pen)
    errors.raise({"path.lean", "tool.kind"},
                 fmt::format("path.lean is {}°, but of tool.kind a pen alone leans; valid is 0",
                             s.path.lean_deg));
  require_foam(s, errors);
  if (!is_led(s.tool)) return require_rim(s, plan, surface, errors);
  const PadSettings face = *face_of(s);
  const bool edge = face.face == PadFace::edge;
  const double r = face.radius;
  const auto refuse = [&](const std::string& text) {
    errors.raise({"tool.radius", "control.normal_force", "tool.kind"},
                 fmt::format("tool.radius: {} of {:.2f} mm {}", edge ? "an edge" : "a roller",
                             2e3 * r, text));
  };
  // Before it swivels at a corner, half of the edge stands beyond that.
  const double corner = plan.path_settings.corner_angle_deg * std::numbers::pi / 180.0;
  for (const PlacedStroke& stroke : plan.strokes)
    for (std::size_t i = 1; i + 1 < stroke.p_P.size(); ++i) {
      const double turn = std::abs(turn_at(stroke.p_P, i)),
                   beside = r * std::sin(std::min(turn, 0.5 * std::numbers::pi));
      if (!edge || s.tool.yaw_deg != 0.0 || turn <= corner || beside <= kMostSmear) continue;
      refuse(
          fmt::format("stands {:.2f} mm beside the corner of stroke {} at page ({:.1f}, {:.1f}) "
                      "mm before it swivels; valid is an edge up to {:.2f} mm",
                      1e3 * beside, stroke.number, stroke.page[i].x(), stroke.page[i].y(),
                      2e3 * r * kMostSmear / beside));
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
