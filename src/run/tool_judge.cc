#include "impedraw/run/tool_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <nlohmann/json.hpp>

#include "impedraw/control/heading.h"
#include "impedraw/drawing/polyline.h"
#include "impedraw/ink/ink_lines.h"
#include "impedraw/log/log_step.h"
#include "impedraw/metrics/jet_figures.h"
#include "impedraw/planning/stroke_part.h"

namespace impedraw {
namespace {

// The true depth of a cutter's groove, place by place along the lines.
//
// d = n·(p_C − p_E) at every step in contact, on a line; the groove is as deep as the cutter has
// been within kBin, in any pass. A place of a promised line that nothing cut has the depth 0.
class GrooveJudge : public ToolJudge {
 public:
  static constexpr double kBin = 2e-4;  // [m]

  explicit GrooveJudge(const Experiment& e)
      : lines_(std::max(
            1, static_cast<int>(e.plan.strokes.size() / depths_of(e.scenario.tool).size()))),
        asked_(e.scenario.tool.depth),
        depth_(static_cast<std::size_t>(lines_)) {
    for (const PlacedStroke& stroke : e.plan.strokes) {
      std::vector<double>& line = depth_[static_cast<std::size_t>(stroke.number % lines_)];
      const double end = stroke.start + plane_length(stroke);
      if (line.empty()) line.resize(static_cast<std::size_t>(stroke.start / kBin), LogRow::kNone);
      line.resize(std::max(line.size(), static_cast<std::size_t>(std::ceil(end / kBin))), 0.0);
    }
  }

  void add(const LogRow& row) override {
    if (row.stroke < 0 || !row.contact_point.allFinite() || !std::isfinite(row.stroke_along))
      return;
    std::vector<double>& line = depth_[static_cast<std::size_t>(row.stroke % lines_)];
    const auto bin = static_cast<std::size_t>(std::max(0.0, row.stroke_along) / kBin);
    const Eigen::Vector3d to_surface = row.contact_point_W() - row.tip_position;
    if (bin >= line.size()) return;
    // A log of a reduced rate has no row in some of the places that the cutter passes.
    const bool on = row.stroke == last_stroke_ && bin > last_bin_ && bin <= last_bin_ + 5;
    for (std::size_t b = on ? last_bin_ + 1 : bin; b <= bin; ++b)
      line[b] = std::max(line[b], row.contact_normal_W().dot(to_surface));
    last_stroke_ = row.stroke;
    last_bin_ = bin;
  }

  // depth_error_rms, depth_error_max and depth_mean [mm], under "metrics"; null without a line.
  nlohmann::ordered_json results() const override {
    double count = 0.0, sum = 0.0, square = 0.0, most = 0.0;
    for (const std::vector<double>& line : depth_)
      for (const double depth : line) {
        if (!std::isfinite(depth)) continue;
        count += 1.0;
        sum += depth;
        square += (depth - asked_) * (depth - asked_);
        most = std::max(most, std::abs(depth - asked_));
      }
    nlohmann::ordered_json out;
    for (const char* name : {"depth_error_rms", "depth_error_max", "depth_mean"})
      out["metrics"][name] = nullptr;
    if (count > 0.0)
      out["metrics"] = {{"depth_error_rms", 1e3 * std::sqrt(square / count)},
                        {"depth_error_max", 1e3 * most},
                        {"depth_mean", 1e3 * sum / count}};
    out["depth_asked_mm"] = 1e3 * asked_;
    return out;
  }

  const char* file() const override { return kGrooveFile; }

 private:
  int lines_;                               // of one pass
  double asked_;                            // [m]
  std::vector<std::vector<double>> depth_;  // of each line, at each of its places [m]
  int last_stroke_ = -1;
  std::size_t last_bin_ = 0;
};

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kWindow = 8e-3;  // of the line, about where the plan is [m]
constexpr double kSlides = 1e-6;  // in a step; slower, it is about to stop and turn [m]

struct Line {
  std::vector<Eigen::Vector2d> p;  // in P, without places that stand twice [m]
  std::vector<double> along;       // of each [m]
  std::vector<double> corners;     // along [m]
};

Eigen::Vector2d at(const Line& line, double along) {
  const auto after = std::upper_bound(line.along.begin() + 1, line.along.end() - 1, along);
  const auto i = static_cast<std::size_t>(after - line.along.begin());
  const double share = (along - line.along[i - 1]) / (line.along[i] - line.along[i - 1]);
  return line.p[i - 1] + std::clamp(share, 0.0, 1.0) * (line.p[i] - line.p[i - 1]);
}

// Nearest place of the line to p, among those within `about` of `along`.
double nearest(const Line& line, const Eigen::Vector2d& p, double along, double about) {
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

// Judges a blade by the truth: the errors of its heading, and the smear at its corners.
//
//   yaw_error     ∠(x_E, t) about the true normal, less tool.yaw; t: tangent of the promised line
//                 where the edge's middle is nearest to it, over ± kNear and not beyond a corner.
//                 Its mean square is over the way, so that turns on the spot do not count.
//   corner_smear  the farthest that an end of the edge is from the promised lines, seen along the
//                 drawing axis, within kAbout of a corner. With tool.yaw ≠ 0: the edge's middle.
// While it writes, on a line.
class BladeJudge : public ToolJudge {
 public:
  static constexpr double kNear = 5e-4, kAbout = 3e-3;  // [m]

  explicit BladeJudge(const Experiment& e)
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

  void add(const LogRow& row) override {
    if (row.stroke < 0 || !std::isfinite(row.stroke_along) || !row.contact_normal.allFinite())
      return;
    if (!is_ink(normal_force(row.contact_force, row.contact_normal_W()))) return;
    const Line& line = lines_[static_cast<std::size_t>(row.stroke)];
    if (line.p.size() < 2) return;
    const Eigen::Vector3d n = X_PW_.R * row.contact_normal_W(),
                          x = X_PW_.R * (row.tip_orientation * Eigen::Vector3d::UnitX()),
                          middle = X_PW_ * row.tip_position - trail_ * x;
    const double place = nearest(line, middle.head<2>(), row.stroke_along, kWindow);

    // Corners on either side of the place bound the tangent: the nearest place may lie beyond.
    double least = line.along.front(), most = line.along.back(), corner_at = 1e9;
    for (const double corner : line.corners) {
      if (corner <= row.stroke_along) least = std::max(least, corner);
      if (corner > row.stroke_along) most = std::min(most, corner);
      if (std::abs(corner - place) < std::abs(corner_at - place)) corner_at = corner;
    }
    const double here = std::clamp(place, least, most);
    const double from = std::max(least, here - kNear), to = std::min(most, here + kNear);
    const double moved =
        row.stroke == last_stroke_ ? std::abs(row.stroke_along - last_along_) : 0.0;
    last_stroke_ = row.stroke;
    last_along_ = row.stroke_along;
    if (moved > kSlides && to - from > 1e-5) {
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

  nlohmann::ordered_json results() const override {
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

  const char* file() const override { return kBladeFile; }

 private:
  Pose X_PW_;
  double yaw_, trail_, half_;  // of the edge [rad], [m], [m]
  std::vector<Line> lines_;
  int last_stroke_ = -1;
  double last_along_ = 0.0;
  double way_ = 0.0, square_ = 0.0, most_ = 0.0, smear_ = 0.0;  // [m], [rad² m], [rad], [m]
  int corners_ = 0;
};

// Judges a nozzle by the truth (jet_figures.h).
class JetJudge : public ToolJudge {
 public:
  explicit JetJudge(const Experiment& e)
      : figures_(e.yardstick.canvas, e.scenario.tool.stand_off) {}
  void add(const LogRow& row) override { figures_.add(row); }
  nlohmann::ordered_json results() const override {
    return {{"metrics", figures_.metrics()}, {"stand_off_mm", 1e3 * figures_.stand_off()}};
  }
  const char* file() const override { return kJetFile; }

 private:
  JetFigures figures_;
};

}  // namespace

std::unique_ptr<ToolJudge> tool_judge(const Experiment& e) {
  if (e.scenario.tool.kind == ToolKind::engraver) return std::make_unique<GrooveJudge>(e);
  if (is_led(e.scenario.tool)) return std::make_unique<BladeJudge>(e);
  if (e.scenario.tool.kind == ToolKind::nozzle) return std::make_unique<JetJudge>(e);
  return nullptr;
}

}  // namespace impedraw
