// check_transitions of preflight.h.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "impedraw/common/angle.h"
#include "impedraw/planning/preflight/posture_check.h"
#include "impedraw/planning/preflight/preflight.h"

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr double kLook = 0.01;  // [s]; the tip moves far less than kStep in it
constexpr double kStep = 0.01;  // [m]
constexpr double kTurn = 0.1;   // of the pen [rad]
// a tip nearer to the canvas than this, or below it, touches it [m]
constexpr double kTipFree = 1e-3;
// of the margins that check_strokes asks for, kept where the same place is looked at again
constexpr double kEased = 0.6;

// Along the strokes themselves check_strokes has looked already, but with postures that may have
// been found anew at their beginnings. Here they follow from the ways, as they do in the run.
PreflightSettings eased(PreflightSettings settings) {
  settings.joint_margin *= kEased;
  settings.clearance *= kEased;
  settings.space.max_effective_mass /= kEased;
  return settings;
}

}  // namespace

std::vector<Finding> check_transitions(const TipPath& path,
                                       const std::vector<PlacedStroke>& strokes,
                                       const ArmModel& arm, const Canvas* obstacle,
                                       const JointVector& start_q,
                                       const PreflightSettings& settings,
                                       const std::function<void(double)>& progress) {
  std::vector<Finding> findings;
  if (strokes.empty() || path.duration() == 0) return findings;
  // Near the end of its range a joint comes, where a lift folds the arm, and the law turns it back.
  PreflightSettings on_ways = settings;
  on_ways.joint_margin *= kEased;
  PostureCheck check(arm, obstacle, start_q, on_ways);
  check.asked.torque = false;
  PostureCheck along_strokes(arm, obstacle, start_q, eased(settings));
  along_strokes.asked.torque = false;

  std::vector<double> amounts;  // severities of the findings
  std::size_t way_begins = 0;   // index of the current motion's first finding
  std::size_t next = 0;         // stroke that the motion leads to
  bool lift = false;            // still lifting off the previous stroke
  // The previous stroke is then at fault. Without it, the rest of the motion would be different.
  bool lift_barred = false;
  const auto report = [&](Problem problem, double amount, const std::string& text,
                          const Vector3d& p) {
    if (lift_barred && !lift) return;
    lift_barred = lift;
    std::size_t i = way_begins;
    while (i < findings.size() && findings[i].problem != problem) ++i;
    if (i < findings.size() && amounts[i] >= amount) return;
    if (i == findings.size()) findings.emplace_back(), amounts.emplace_back();
    const bool back = next >= strokes.size();
    const PlacedStroke& stroke = back ? strokes.back() : strokes[lift ? next - 1 : next];
    findings[i] = {{stroke.number, stroke.start, stroke.start + plane_length(stroke)},
                   problem,
                   fmt::format("{}: {}",
                               lift   ? "on the way off it"
                               : back ? "on the way back"
                                      : "on the way there",
                               text),
                   stroke.page.front(),
                   p,
                   lift || back ? WayEnd::last : WayEnd::first};
    amounts[i] = amount;
  };

  bool lost_along = false;  // the last finding is of the stroke at hand, and goes on
  const auto report_along = [&](const PathSample& sample, const Posture& posture,
                                const Vector3d& p) {
    if (lost_along) {
      findings.back().part.to = sample.along;
      return;
    }
    lost_along = true;
    const PlacedStroke& stroke = strokes[std::min(next, strokes.size() - 1)];
    findings.push_back({{stroke.number, sample.along, sample.along},
                        *posture.problem,
                        "from the way there: " + posture.text,
                        place_on(stroke, sample.along).page,
                        p});
    amounts.push_back(posture.amount);
  };

  std::optional<Posture> last;
  Vector3d asked_p = Vector3d::Zero(), asked_n = Vector3d::UnitZ(), asked_x = Vector3d::UnitX();
  double asked_t = 0.0;
  bool was_way = false;
  const auto ask = [&](double t) {
    const PathSample sample = path.at(t);
    const Vector3d p = sample.reference.p_WD, n = sample.reference.n_WD, x = sample.reference.x_WD;
    const bool way = sample.phase != Phase::draw;
    const bool change = way != was_way;
    was_way = way;
    const double moved = (p - asked_p).norm(),
                 turned = angle_between(n, asked_n) +
                          (sample.reference.led() ? angle_between(x, asked_x) : 0.0);
    if (last && !change && moved < kStep && turned < kTurn) return;
    while (next < path.strokes().size() && path.strokes()[next].end <= t) {
      ++next;
      way_begins = findings.size();
      lift_barred = false;
    }
    lift = sample.phase == Phase::lift && next > 0;
    const auto below = obstacle ? obstacle->closest(p, kTipFree + 0.02) : std::nullopt;
    check.asked.pen = !(below && below->distance < kTipFree);
    // A path may run beneath the surface: a set-point that presses, a coarse cloud.
    const bool beneath = sample.stroke >= 0 && below && below->distance < 0.0;
    const PenPlacement pen{beneath ? below->p_W : p, -n, x};
    PostureCheck& here = sample.stroke < 0 ? check : along_strokes;
    Posture posture =
        last ? here.follow(pen, *last, moved, t - asked_t) : check.begin(pen, start_q);
    if (sample.stroke >= 0 && posture.problem)
      report_along(sample, posture, p);
    else
      lost_along = false;
    // If the arm loses the path during a motion, only that motion is reported. The next stroke
    // starts from a new posture.
    if (last && !posture.reached && (last->reached || (change && !way))) {
      Posture anew = check.enter(pen, start_q);
      if (anew.reached) posture = std::move(anew);
    }
    if (last && posture.reached && last->reached) {
      const PostureCheck::Change by = PostureCheck::change(*last, posture);
      // A turn of the pen can move a wrist joint several times as far.
      const bool jumped = by.by > settings.max_joint_step + 3 * turned +
                                      moved / settings.step * settings.max_joint_step / 2;
      if (jumped && way)
        report(Problem::joint_jump, by.by,
               fmt::format("joint {} would turn by {:.2f} rad within {:.0f} mm", by.joint + 1,
                           by.by, 1e3 * moved),
               p);
    }
    if (way && posture.problem) report(*posture.problem, posture.amount, posture.text, p);
    last = std::move(posture);
    asked_t = t;
    asked_p = p;
    asked_n = n;
    asked_x = x;
  };
  long looks = 0;
  for (double t = 0; t < path.duration(); t += kLook) {
    if (progress && looks++ % 1024 == 0) progress(t / path.duration());
    ask(t);
  }
  ask(path.duration());
  return findings;
}

}  // namespace impedraw
