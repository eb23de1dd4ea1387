// check_transitions of preflight.h: the ways between strokes, and strokes as the arm comes to them.
#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "impedraw/common/rotations.h"
#include "impedraw/planning/preflight/posture_check.h"
#include "impedraw/planning/preflight/preflight.h"
#include "impedraw/planning/stroke_ruler.h"

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

// Near the end of its range a joint comes, where a lift folds the arm, and the law turns it back.
PreflightSettings on_ways(PreflightSettings settings) {
  settings.joint_margin *= kEased;
  return settings;
}

// Along the strokes themselves check_strokes has looked already, but with postures that may have
// been found anew at their beginnings. Here they follow from the ways, as they do in the run.
PreflightSettings eased(PreflightSettings settings) {
  settings.joint_margin *= kEased;
  settings.clearance *= kEased;
  settings.space.max_effective_mass /= kEased;
  return settings;
}

// The findings of a path: of each motion through the air the worst of each problem, and of each
// stroke the parts that the arm loses.
class PathFindings {
 public:
  explicit PathFindings(const std::vector<PlacedStroke>& strokes) : strokes_(strokes) {}

  // The stroke that the motion at hand leads to, or off the one before it.
  std::size_t next() const { return next_; }
  void begin_motion() {
    ++next_;
    begins_ = findings_.size();
    lift_barred_ = false;
  }
  void set_lift(bool lift) { lift_ = lift; }

  void add_on_way(Problem problem, double amount, const std::string& text, const Vector3d& p) {
    // After a lift that fails the rest of the motion would be another one.
    if (lift_barred_ && !lift_) return;
    lift_barred_ = lift_;
    std::size_t i = begins_;
    while (i < findings_.size() && findings_[i].problem != problem) ++i;
    if (i < findings_.size() && amounts_[i] >= amount) return;
    if (i == findings_.size()) findings_.emplace_back(), amounts_.emplace_back();
    const bool back = next_ >= strokes_.size();
    const PlacedStroke& stroke = back ? strokes_.back() : strokes_[lift_ ? next_ - 1 : next_];
    const char* where = lift_ ? "on the way off it" : back ? "on the way back" : "on the way there";
    findings_[i] = {{stroke.number, stroke.start, stroke.start + plane_length(stroke)},
                    problem,
                    fmt::format("{}: {}", where, text),
                    stroke.page.front(),
                    p,
                    lift_ || back ? WayEnd::last : WayEnd::first};
    amounts_[i] = amount;
  }

  // One look at a stroke. What is lost from one look to the next is one finding.
  void add_along(double along, const Posture& posture, const Vector3d& p) {
    if (posture.problem && lost_along_) {
      findings_.back().part.to = along;
    } else if (posture.problem) {
      const PlacedStroke& stroke = strokes_[std::min(next_, strokes_.size() - 1)];
      findings_.push_back({{stroke.number, along, along},
                           *posture.problem,
                           "from the way there: " + posture.text,
                           place_on(stroke, along).page,
                           p});
      amounts_.push_back(posture.amount);
    }
    lost_along_ = posture.problem.has_value();
  }
  void leave_stroke() { lost_along_ = false; }

  std::vector<Finding> take() { return std::move(findings_); }

 private:
  const std::vector<PlacedStroke>& strokes_;
  std::vector<Finding> findings_;
  std::vector<double> amounts_;        // severities of the findings
  std::size_t next_ = 0, begins_ = 0;  // stroke that the motion leads to; its first finding
  bool lift_ = false;         // still lifting off the previous stroke, which is then at fault
  bool lift_barred_ = false;  // the lift of this motion has failed
  bool lost_along_ = false;   // the last finding is of the stroke at hand, and goes on
};

// Takes the arm along a path, from posture to posture.
class PathWalk {
 public:
  PathWalk(const TipPath& path, const std::vector<PlacedStroke>& strokes, const ArmModel& arm,
           const Canvas* obstacle, const JointVector& start_q, const PreflightSettings& settings)
      : path_(path),
        obstacle_(obstacle),
        start_q_(start_q),
        check_(arm, obstacle, start_q, on_ways(settings)),
        along_strokes_(arm, obstacle, start_q, eased(settings)),
        findings_(strokes) {
    check_.asked.torque = along_strokes_.asked.torque = false;
  }

  void look(double t) {
    const PathSample sample = path_.at(t);
    const TipReference& now = sample.reference;
    const bool way = sample.phase != Phase::draw, change = way != was_way_;
    was_way_ = way;
    const double moved = (now.p_WD - asked_.p_WD).norm(),
                 turned = angle_between(now.n_WD, asked_.n_WD) +
                          (now.led() ? angle_between(now.x_WD, asked_.x_WD) : 0.0);
    if (last_ && !change && moved < kStep && turned < kTurn) return;
    const std::vector<StrokeTimes>& strokes = path_.strokes();
    while (findings_.next() < strokes.size() && strokes[findings_.next()].end <= t)
      findings_.begin_motion();
    findings_.set_lift(sample.phase == Phase::lift && findings_.next() > 0);
    const PenPlacement pen = pen_at(sample);
    PostureCheck& here = sample.stroke < 0 ? check_ : along_strokes_;
    Posture posture =
        last_ ? here.follow(pen, *last_, moved, t - asked_t_) : check_.begin(pen, start_q_);
    if (sample.stroke >= 0)
      findings_.add_along(sample.along, posture, now.p_WD);
    else
      findings_.leave_stroke();
    // If the arm loses the path during a motion, only that motion is reported. The next stroke
    // starts from a new posture.
    if (last_ && !posture.reached && (last_->reached || (change && !way))) {
      Posture anew = check_.enter(pen, start_q_);
      if (anew.reached) posture = std::move(anew);
    }
    if (way) judge(posture, moved, turned, now.p_WD);
    last_ = std::move(posture);
    asked_t_ = t;
    asked_ = now;
  }

  std::vector<Finding> take() { return findings_.take(); }

 private:
  PenPlacement pen_at(const PathSample& sample) {
    const TipReference& now = sample.reference;
    const auto below = obstacle_ ? obstacle_->closest(now.p_WD, kTipFree + 0.02) : std::nullopt;
    check_.asked.pen = !(below && below->distance < kTipFree);
    // A path may run beneath the surface: a set-point that presses, a coarse cloud.
    const bool beneath = sample.stroke >= 0 && below && below->distance < 0.0;
    return {beneath ? below->p_W : now.p_WD, -now.n_WD, now.x_WD};
  }

  // A motion through the air, from the last posture to this one: its joint speeds and its ends.
  void judge(const Posture& posture, double moved, double turned, const Vector3d& p) {
    if (last_ && posture.reached && last_->reached) {
      const PostureCheck::Change by = PostureCheck::change(*last_, posture);
      if (by.by > check_.most_change(moved, turned))
        findings_.add_on_way(Problem::joint_jump, by.by,
                             fmt::format("joint {} would turn by {:.2f} rad within {:.0f} mm",
                                         by.joint + 1, by.by, 1e3 * moved),
                             p);
    }
    if (posture.problem) findings_.add_on_way(*posture.problem, posture.amount, posture.text, p);
  }

  const TipPath& path_;
  const Canvas* obstacle_;
  const JointVector& start_q_;
  PostureCheck check_, along_strokes_;
  PathFindings findings_;
  std::optional<Posture> last_;
  TipReference asked_;  // at the last look that was taken
  double asked_t_ = 0.0;
  bool was_way_ = false;
};

}  // namespace

std::vector<Finding> check_transitions(const TipPath& path,
                                       const std::vector<PlacedStroke>& strokes,
                                       const ArmModel& arm, const Canvas* obstacle,
                                       const JointVector& start_q,
                                       const PreflightSettings& settings,
                                       const std::function<void(double)>& progress) {
  if (strokes.empty() || path.duration() == 0) return {};
  PathWalk walk(path, strokes, arm, obstacle, start_q, settings);
  long looks = 0;
  for (double t = 0; t < path.duration(); t += kLook) {
    if (progress && looks++ % 1024 == 0) progress(t / path.duration());
    walk.look(t);
  }
  walk.look(path.duration());
  return walk.take();
}

}  // namespace impedraw
