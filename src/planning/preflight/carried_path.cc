#include "impedraw/planning/preflight/carried_path.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "impedraw/arm/least_energy_step.h"
#include "impedraw/common/rotations.h"
#include "impedraw/control/joint_speed_shares.h"
#include "impedraw/planning/preflight/posture_check.h"

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr double kCarriedLook = 0.05;  // [s]

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
  Posture last = standing_at(q);
  Vector3d p = arm.tip_pose(q).p, n = -arm.tip_pose(q).R.col(2);
  std::size_t next = 0;  // stroke under way
  while (next < strokes.size() && strokes[next].end < from) ++next;
  bool lifting = false, leaves = true;
  double risen = path.duration();  // from the last stroke [s]
  for (double t = from; t <= risen + carried.along && next < strokes.size(); t += kCarriedLook) {
    PathSample sample = path.at(std::min(t, risen));
    // A stroke ends with its lift.
    bool lifts = sample.phase == Phase::lift && t > strokes[next].end;
    if (lifting && !lifts && next + 1 == strokes.size() && carried.along > 0.0) {
      risen = std::min(risen, t - kCarriedLook);
      sample = path.at(risen);
      lifts = true;
    }
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
      if (anew.reached && by <= check.most_change(moved, turned))
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

}  // namespace impedraw
