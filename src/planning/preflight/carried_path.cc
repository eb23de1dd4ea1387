#include "impedraw/planning/preflight/carried_path.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "impedraw/arm/least_energy_step.h"
#include "impedraw/common/rotations.h"
#include "impedraw/control/joint_speed_shares.h"

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr double kCarriedLook = 0.05;  // [s]
constexpr double kFarOff = 0.1;        // from a place that is not reached [m]

const char* what_of(Problem problem, bool on_way) {
  switch (problem) {
    case Problem::out_of_reach:
      return on_way ? "is out of the arm's reach" : "leaves the arm's reach";
    case Problem::joint_limit:
      return "brings a joint to its limit";
    case Problem::near_singular:
      return "brings the arm near a singular posture";
    case Problem::torque:
      return "needs too much torque";
    case Problem::joint_jump:
      return "cannot be followed without a jump of the joints";
    default:
      return "makes the arm touch the canvas or the table";
  }
}

}  // namespace

std::optional<CarriedFault> check_carried(const CarriedPath& carried, ArmModel arm,
                                          const Canvas* obstacle, const JointVector& q,
                                          const PreflightSettings& settings, double from,
                                          double until) {
  const TipPath& path = *carried.path;
  const std::vector<StrokeTimes>& strokes = path.strokes();
  PostureCheck check(arm, obstacle, q, settings);
  check.asked.pen = false;  // against the canvas it is the same as on one that stands
  const JointVector speed = arm.limits().speed;
  ArmTerms terms(arm.joints());

  std::optional<CarriedFault> fault;
  Problem problem{};
  std::string text;
  bool on_way = false;
  Posture last;
  last.q = q;
  last.reached = true;
  last.drift = JointVector::Zero(q.size());
  Vector3d p = arm.tip_pose(q).p, n = -arm.tip_pose(q).R.col(2);
  std::size_t next = 0;  // stroke under way
  while (next < strokes.size() && strokes[next].end < from) ++next;
  bool lifting = false, leaves = true;
  for (double t = from; t <= path.duration() && next < strokes.size(); t += kCarriedLook) {
    const PathSample sample = path.at(t);
    // A stroke ends with its lift.
    const bool lifts = sample.phase == Phase::lift && t > strokes[next].end;
    if (lifting && !lifts) {
      if (fault) break;
      if (++next == strokes.size()) break;
    }
    lifting = lifts;
    if (!fault && sample.phase == Phase::travel && t > until) break;
    const double time = carried.begin + t;
    const Pose X_WK = carried.canvas(time);
    TipReference wanted = sample.reference;
    if (carried.in_world) {
      wanted = carried.in_world(wanted, time);
    } else {
      wanted.p_WD = X_WK * wanted.p_WD;
      wanted.n_WD = X_WK.R * wanted.n_WD;
    }
    check.move_canvas(X_WK);
    check.asked.torque = sample.reference.pen_down;
    const double moved = (wanted.p_WD - p).norm(), turned = angle_between(wanted.n_WD, n);
    p = wanted.p_WD;
    n = wanted.n_WD;
    const PenPlacement pen{p, -n};
    const auto report = [&](Problem what, double short_by, const std::string& how) {
      if (!fault) {
        fault = {next, time, short_by, {}, {}};
        problem = what;
        text = how;
        on_way = sample.phase == Phase::travel;
      } else if (short_by > fault->short_by) {
        fault->short_by = short_by;
        if (what == Problem::out_of_reach) problem = what, text = how, fault->what.clear();
      }
    };

    // Joint speeds from the last posture, where there was one.
    if (!fault && t > from) {
      arm.compute(last.q, JointVector::Zero(last.q.size()), &terms);
      const JointVector task = least_energy_step(terms, tip_displacement(terms.X_WE, p, -n),
                                                 JointVector::Zero(last.q.size()), 1e-6)
                                   .task;
      int joint = 0;
      const double share =
          (task.cwiseAbs().array() / (kCarriedLook * speed.array())).maxCoeff(&joint);
      if (share > JointSpeedShares::kLaw) {
        // Near the end of the reach joints are fast, too: then that is what is told.
        fault =
            CarriedFault{next, time, 0.0, "needs too fast a joint",
                         fmt::format("joint {} at {:.2f} rad/s, allowed {:.2f} rad/s", joint + 1,
                                     share * speed[joint], JointSpeedShares::kLaw * speed[joint])};
      }
    }
    Posture posture = check.follow(pen, last, moved);
    if (!posture.reached && !fault) {
      Posture anew = check.enter(pen, last.q);
      const double by = PostureCheck::change(last, anew).by;
      const double most = settings.max_joint_step + 3.0 * turned +
                          moved / settings.step * settings.max_joint_step / 2.0;
      if (anew.reached && by <= most)
        posture = std::move(anew);
      else if (anew.reached)
        report(Problem::joint_jump, 0.0, {});
    }
    // The arm may stand in a posture that no path may lead to, and is led out of it.
    leaves = leaves && posture.problem && posture.reached && sample.phase == Phase::travel;
    if (posture.problem && !leaves)
      report(*posture.problem, posture.reached ? 0.0 : (arm.tip_pose(posture.q).p - p).norm(),
             posture.text);
    last = std::move(posture);
  }
  if (fault && fault->what.empty()) {
    fault->what = what_of(problem, on_way);
    fault->how = problem == Problem::out_of_reach && fault->short_by >= 5e-3
                     ? fmt::format("{:.2f} m short", fault->short_by)
                     : text;
  }
  return fault;
}

ReachMap::ReachMap(const ArmModel& arm, const JointVector& q, const PreflightSettings& settings)
    : arm_(arm), q_(q), check_(arm, nullptr, q, settings), terms_(arm.joints()) {
  check_.asked.pen = false;
  last_.q = q;
  last_.reached = true;
  last_.drift = JointVector::Zero(q.size());
}

const Eigen::MatrixXd& ReachMap::cell(const PenPlacement& pen) {
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i) {
    key = key << 16 | (static_cast<std::uint64_t>(std::llround(pen.p_WE[i] / kCell)) & 0xffff);
    key = key << 5 | (static_cast<std::uint64_t>(std::llround(pen.z_WE[i] / kTurn)) & 0x1f);
  }
  const auto [found, is_new] = cells_.try_emplace(key);
  Eigen::MatrixXd& by_tip = found->second;
  if (!is_new) return by_tip;
  Posture posture = check_.follow(pen, last_, (pen.p_WE - arm_.tip_pose(last_.q).p).norm());
  // What lies far beyond the reach is not looked for from other postures.
  if (!posture.reached && posture.amount > kFarOff) return by_tip;
  if (posture.problem) posture = check_.enter(pen, q_);
  if (posture.problem) return by_tip;
  const JointVector none = JointVector::Zero(arm_.joints());
  arm_.compute(posture.q, none, &terms_);
  by_tip.resize(arm_.joints(), 6);
  for (int i = 0; i < 6; ++i)
    by_tip.col(i) = least_energy_step(terms_, Vector6::Unit(i), none, 1e-6)
                        .task.cwiseQuotient(arm_.limits().speed);
  last_ = std::move(posture);
  return by_tip;
}

// By the motion of least kinetic energy.
bool ReachMap::reaches(const PenPlacement& from, const PenPlacement& to, double time) {
  const Eigen::MatrixXd& by_tip = cell(from);
  if (by_tip.size() == 0) return false;
  Vector6 dx;
  dx << to.p_WE - from.p_WE, smallest_rotation(from.z_WE, to.z_WE);
  return (by_tip * dx).cwiseAbs().maxCoeff() <= JointSpeedShares::kClockYields * time;
}

std::vector<ReachWindow> ReachMap::windows(const TipPath& path, std::size_t stroke,
                                           const CanvasPoses& canvas) {
  constexpr double kDown = 0.5;  // the last of the way to a stroke [s]
  const auto& [number, approach, start, end, length] = path.strokes()[stroke];
  const double down = canvas.step * std::ceil(std::min(kDown, approach) / canvas.step);
  const double last = canvas.step * static_cast<double>(canvas.X_WK.size() - 1);
  std::vector<TipReference> places;  // in K
  PathSample at = path.at(approach - down);
  for (double t = approach - down; t <= end || at.phase == Phase::draw || at.phase == Phase::lift;
       at = path.at(t += canvas.step))
    places.push_back(at.reference);
  const auto pen_at = [&](std::size_t place, std::size_t time) {
    const Pose& X_WK = canvas.X_WK[std::min(time, canvas.X_WK.size() - 1)];
    return PenPlacement{X_WK * places[place].p_WD, -(X_WK.R * places[place].n_WD)};
  };
  std::vector<ReachWindow> windows;
  bool open = false;
  for (std::size_t j = 0;; ++j) {
    const double from = canvas.step * static_cast<double>(j) + down, until = from + end - approach;
    if (until > last) return windows;
    bool good = true;
    PenPlacement here = pen_at(0, j);
    for (std::size_t i = 1; good && i < places.size(); ++i) {
      const PenPlacement next = pen_at(i, j + i);
      good = reaches(here, next, canvas.step);
      here = next;
    }
    if (good && !open) windows.push_back({canvas.begin + from, 0.0});
    if (good) windows.back().until = canvas.begin + until;
    open = good;
  }
}

}  // namespace impedraw
