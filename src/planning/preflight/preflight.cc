#include "impedraw/planning/preflight/preflight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "impedraw/common/in_parallel.h"
#include "impedraw/common/range_check.h"
#include "impedraw/common/rotations.h"
#include "impedraw/planning/leant.h"
#include "impedraw/planning/preflight/describe_preflight.h"
#include "impedraw/planning/preflight/posture_check.h"
#include "impedraw/planning/preflight/surface_walk.h"
#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

// A part of a stroke with one verdict.
struct Stretch {
  double from = 0, to = 0;
  std::optional<Problem> problem;
  double amount = 0, worst = 0;  // the problem's severity, and its position on the stroke
  Vector3d p_W = Vector3d::Zero();
  std::string text;
};

struct Node {
  double along = 0;
  PenPlacement pen;
  Posture posture;
};

// Moves the arm along the parts of a stroke that the surface permits.
class ArmWalk {
 public:
  // `progress`: called now and then with the place on the stroke.
  ArmWalk(PostureCheck& check, const PreflightSettings& settings, const SurfaceSpan& span,
          const JointVector& last, const std::function<void(double)>& progress)
      : check_(check), settings_(settings), profile_(span, settings.normal_smoothing), last_(last) {
    Node left = node(span.from);
    left.posture = check_.enter(left.pen, last_);
    open(left, span.from);
    const int pieces = static_cast<int>(std::ceil((span.to - span.from) / settings_.step));
    int lost = 0;  // consecutive failed postures
    for (int k = 1; k <= pieces; ++k) {
      if (k % 64 == 0) progress(left.along);
      Node right = node(k < pieces ? span.from + (span.to - span.from) * k / pieces : span.to);
      right.posture = check_.follow(right.pen, left.posture, right.along - left.along);
      lost = right.posture.problem ? lost + 1 : 0;
      // Another posture may succeed where this one fails.
      if (lost % kTryAnew == 1) {
        Posture anew = check_.enter(right.pen, last_);
        if (!anew.problem) right.posture = std::move(anew);
      }
      advance(left, right);
      left = std::move(right);
    }
    if (left.posture.reached) last_ = left.posture.q;
  }

  std::vector<Stretch> stretches;
  PreflightMargins margins;
  const JointVector& last() const { return last_; }  // posture that reached a point

 private:
  static constexpr int kTryAnew = 8;

  Node node(double along) const {
    const SurfaceSample at = profile_.at(along);
    const Pose& X_WP = settings_.X_WP;
    const Vector3d n =
        X_WP.R * (settings_.vertical_pen ? Vector3d::UnitZ() : leant(at.n_P, settings_.lean_deg));
    return {along, {X_WP * at.p_P, -n}, {}};
  }

  // A posture between two others, found from the left one or, if that fails, from the right one.
  Node between(const Node& l, const Node& r) {
    Node middle = node((l.along + r.along) / 2);
    const double half = (r.along - l.along) / 2;
    const Node& first = l.posture.problem ? r : l;
    const Node& second = l.posture.problem ? l : r;
    middle.posture = check_.follow(middle.pen, first.posture, half);
    if (middle.posture.problem && !second.posture.problem) {
      Posture other = check_.follow(middle.pen, second.posture, half);
      if (!other.problem) middle.posture = std::move(other);
    }
    return middle;
  }

  void advance(const Node& l, const Node& r) {
    const bool same = l.posture.problem == r.posture.problem;
    const double length = r.along - l.along;
    const PostureCheck::Change change = PostureCheck::change(l.posture, r.posture);
    const bool jump = same && !l.posture.problem &&
                      change.by > settings_.max_joint_step * length / settings_.step + kLeastJump;
    if (same && !jump) return extend(r);
    if (length > settings_.edge_tolerance) {
      const Node middle = between(l, r);
      advance(l, middle);
      advance(middle, r);
    } else if (jump) {
      add_jump(l, r, change);
    } else {
      const double boundary = l.posture.problem ? r.along : l.along;
      stretches.back().to = boundary;
      open(r, boundary);
    }
  }

  void add_jump(const Node& l, const Node& r, const PostureCheck::Change& change) {
    // If the arm turns too fast over several steps, this counts as one jump.
    const std::size_t n = stretches.size();
    const bool goes_on = n >= 2 && stretches[n - 1].from == stretches[n - 1].to &&
                         stretches[n - 2].problem == Problem::joint_jump;
    if (goes_on)
      stretches.pop_back();
    else
      stretches.push_back({l.along, l.along, Problem::joint_jump, 0, l.along, l.pen.p_WE, {}});
    Stretch& jump = stretches.back();
    jump.to = r.along;
    jump.amount += change.by;
    jump.text = fmt::format("joint {} would turn by {:.2f} rad within {:.1f} mm", change.joint + 1,
                            jump.amount, 1e3 * (jump.to - jump.from));
    open(r, r.along);
  }

  void open(const Node& first, double from) {
    stretches.push_back({from,
                         first.along,
                         first.posture.problem,
                         -std::numeric_limits<double>::infinity(),
                         from,
                         first.pen.p_WE,
                         {}});
    extend(first);
  }

  void extend(const Node& next) {
    Stretch& stretch = stretches.back();
    const Posture& posture = next.posture;
    stretch.to = next.along;
    if (posture.problem) {
      if (posture.amount < stretch.amount) return;
      stretch.amount = posture.amount;
      stretch.worst = next.along;
      stretch.p_W = next.pen.p_WE;
      stretch.text = posture.text;
      return;
    }
    margins.joint = std::min(margins.joint, posture.margins.joint);
    margins.torque_share = std::max(margins.torque_share, posture.margins.torque_share);
    margins.effective_mass = std::max(margins.effective_mass, posture.margins.effective_mass);
    margins.clearance = std::min(margins.clearance, posture.margins.clearance);
  }

  static constexpr double kLeastJump = 0.02;  // postures found from two sides differ a little [rad]

  PostureCheck& check_;
  const PreflightSettings& settings_;
  SurfaceProfile profile_;
  JointVector last_;
};

// Marks drawable parts that are too short between undrawable ones.
void drop_short(std::vector<Stretch>& stretches, double shortest) {
  if (stretches.size() == 1) return;
  for (Stretch& stretch : stretches) {
    const double length = stretch.to - stretch.from;
    if (stretch.problem || length >= shortest) continue;
    stretch.problem = Problem::too_short;
    stretch.text = fmt::format("{:.2f} mm are left, too short to draw", 1e3 * length);
  }
}

// Scraps between undrawable parts go to the part before, or behind: "0.00 mm are left" tells nobody
// anything.
void absorb_scraps(std::vector<Stretch>& stretches) {
  constexpr double kScrap = 5e-4;  // [m]
  for (std::size_t i = stretches.size(); i-- > 0 && stretches.size() > 1;) {
    const Stretch& scrap = stretches[i];
    if (scrap.problem != Problem::too_short || scrap.to - scrap.from >= kScrap) continue;
    if (i > 0 && stretches[i - 1].problem)
      stretches[i - 1].to = scrap.to;
    else if (i + 1 < stretches.size() && stretches[i + 1].problem)
      stretches[i + 1].from = scrap.from;
    else
      continue;
    stretches.erase(stretches.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

}  // namespace

const char* name_of(Problem problem) noexcept {
  static constexpr const char* kNames[] = {
      "off_canvas",    "fold",        "crease",        "too_rough", "too_steep",
      "out_of_reach",  "joint_limit", "near_singular", "torque",    "arm_collision",
      "pen_collision", "joint_jump",  "crawls",        "too_short"};
  static_assert(std::size(kNames) == static_cast<std::size_t>(Problem::too_short) + 1);
  return kNames[static_cast<std::size_t>(problem)];
}

void validate(const PreflightSettings& s) {
  require_ranges("preflight", s);
  require_in_range("preflight.surface_step", s.surface_step, Range::positive(), "m");
  require_in_range("preflight.normal_smoothing", s.normal_smoothing, {0.0, 1.0}, "m");
  require_in_range("preflight.torque_share", s.torque_share, Range::positive(), "");
  require_in_range("preflight.normal_force", s.normal_force, {0.0, 1e4}, "N");
  require_in_range("preflight.friction", s.friction, {0.0, 10.0}, "");
  require_in_range("preflight.space.max_effective_mass", s.space.max_effective_mass,
                   Range::positive(), "kg");
  require_in_range("preflight.space.characteristic_length", s.space.characteristic_length,
                   Range::positive(), "m");
}

Preflight check_strokes(const std::vector<PlacedStroke>& strokes, const SurfaceHeight& surface,
                        const ArmModel& arm, const Canvas* obstacle, const JointVector& start_q,
                        const PreflightSettings& settings,
                        const std::function<void(double)>& progress) {
  validate(settings);
  PostureCheck check(arm, obstacle, start_q, settings);
  Preflight result;
  PreflightMargins& margins = result.margins;
  JointVector last = start_q;
  // The work on a stroke: its length, and that of finding a posture for its first point.
  constexpr double kFirst = 5e-3;  // [m]
  double work = 0, done = 0;
  for (const PlacedStroke& stroke : strokes) work += plane_length(stroke) + kFirst;
  std::vector<std::vector<SurfaceSpan>> spans(strokes.size());
  in_parallel(static_cast<int>(strokes.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    spans[k] = walk_surface(strokes[k], surface, settings);
  });
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    const PlacedStroke& stroke = strokes[i];
    const auto tell = [&](double along) {
      if (progress) progress((done + along - stroke.start) / work);
    };
    tell(stroke.start);
    std::vector<Stretch> stretches;
    for (const SurfaceSpan& span : spans[i]) {
      if (span.problem) {
        stretches.push_back(
            {span.from, span.to, span.problem, 0, span.worst, settings.X_WP * span.p_P, span.text});
        continue;
      }
      margins.slope_deg = std::max(margins.slope_deg, span.slope * 180 / std::numbers::pi);
      if (!settings.arm) {
        stretches.push_back({span.from, span.to, std::nullopt, 0, span.from, Vector3d::Zero(), {}});
        continue;
      }
      const ArmWalk walk(check, settings, span, last, tell);
      last = walk.last();
      stretches.insert(stretches.end(), walk.stretches.begin(), walk.stretches.end());
      margins.joint = std::min(margins.joint, walk.margins.joint);
      margins.torque_share = std::max(margins.torque_share, walk.margins.torque_share);
      margins.effective_mass = std::max(margins.effective_mass, walk.margins.effective_mass);
      margins.clearance = std::min(margins.clearance, walk.margins.clearance);
    }
    done += plane_length(stroke) + kFirst;
    drop_short(stretches, settings.shortest);
    absorb_scraps(stretches);
    std::optional<StrokeRuler> ruler;
    for (Stretch& stretch : stretches) {
      const StrokePart part{stroke.number, stretch.from, stretch.to};
      if (!stretch.problem)
        result.drawable.push_back(part);
      else
        result.findings.push_back({part, *stretch.problem, std::move(stretch.text),
                                   (ruler ? *ruler : ruler.emplace(stroke)).at(stretch.worst).page,
                                   stretch.p_W});
    }
  }
  return result;
}

}  // namespace impedraw
