#include "impedraw/experiment/tool_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "impedraw/drawing/polyline.h"

namespace impedraw {

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

void require_foam(const Scenario& s, const SettingErrors& errors) {
  constexpr double kMostPressed = 0.85;  // of the foam's thickness; more of it counts as a wall
  const auto pad = pad_of(s.tool, s.world.tip.friction, s.control.normal_force);
  const double share = pad ? pad->rest / (kMostPressed * pad->thickness) : 0.0;
  if (share <= 1.0) return;
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
