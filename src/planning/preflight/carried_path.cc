#include "impedraw/planning/preflight/carried_path.h"

#include <cmath>

#include <fmt/format.h>

#include "impedraw/arm/least_energy_step.h"
#include "impedraw/common/rotations.h"
#include "impedraw/planning/preflight/posture_check.h"

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr double kCarriedLook = 0.05;  // [s]

void say(Problem problem, double short_by, const std::string& text, bool on_way,
         CarriedFault* fault) {
  fault->how = text;
  switch (problem) {
    case Problem::out_of_reach:
      fault->what = on_way ? "is out of the arm's reach" : "leaves the arm's reach";
      if (short_by >= 5e-3) fault->how = fmt::format("{:.2f} m short", short_by);
      break;
    case Problem::joint_limit:
      fault->what = "brings a joint to its limit";
      break;
    case Problem::near_singular:
      fault->what = "brings the arm near a singular posture";
      break;
    case Problem::torque:
      fault->what = "needs too much torque";
      break;
    case Problem::joint_jump:
      fault->what = "cannot be followed without a jump of the joints";
      break;
    default:
      fault->what = "makes the arm touch the canvas or the table";
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
  bool lifting = false;
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
      if (share > 1.0) {
        // Near the end of the reach joints are fast, too: then that is what is told.
        fault = CarriedFault{next, time, 0.0, "needs too fast a joint",
                             fmt::format("joint {} at {:.2f} rad/s, allowed {:.2f} rad/s",
                                         joint + 1, share * speed[joint], speed[joint])};
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
    if (posture.problem)
      report(*posture.problem, posture.reached ? 0.0 : (arm.tip_pose(posture.q).p - p).norm(),
             posture.text);
    last = std::move(posture);
  }
  if (fault && fault->what.empty()) say(problem, fault->short_by, text, on_way, &*fault);
  return fault;
}

StrokePlaces places_of(const TipPath& path, std::size_t stroke, int count) {
  const StrokeTimes& times = path.strokes()[stroke];
  StrokePlaces places;
  places.duration = times.end - times.approach;
  for (int i = 0; i < count; ++i) {
    const double t = count > 1 ? places.duration * i / (count - 1) : 0.0;
    const TipReference at = path.at(times.approach + t).reference;
    places.time.push_back(t);
    places.p_K.push_back(at.p_WD);
    places.n_K.push_back(at.n_WD);
  }
  return places;
}

std::vector<ReachWindow> reach_windows(const StrokePlaces& stroke, const CanvasCourse& canvas,
                                       ArmModel arm, const JointVector& q,
                                       const PreflightSettings& settings, double begin, double end,
                                       double step) {
  PostureCheck check(arm, nullptr, q, settings);
  check.asked.pen = false;
  const auto times = static_cast<std::size_t>(std::ceil((end - begin) / step)) + 1;
  const auto last_time = static_cast<double>(times - 1);
  std::vector<std::vector<bool>> reached(stroke.time.size(), std::vector<bool>(times));
  for (std::size_t i = 0; i < stroke.time.size(); ++i) {
    // From the last posture that was in order: one out of reach seldom leads back.
    constexpr std::size_t kAnew = 5;
    std::optional<Posture> good;
    Vector3d p = Vector3d::Zero();
    for (std::size_t j = 0; j < times; ++j) {
      const Pose X_WK = canvas(begin + step * static_cast<double>(j));
      const PenPlacement pen{X_WK * stroke.p_K[i], -(X_WK.R * stroke.n_K[i])};
      std::optional<Posture> posture;
      if (good) posture = check.follow(pen, *good, (pen.p_WE - p).norm());
      if ((!posture || posture->problem) && j % kAnew == 0) posture = check.enter(pen, q);
      reached[i][j] = posture && !posture->problem;
      if (!reached[i][j]) continue;
      p = pen.p_WE;
      good = std::move(posture);
    }
  }
  // Begun at the j-th time all places are in reach as the pen comes by.
  std::vector<ReachWindow> windows;
  bool open = false;
  for (std::size_t j = 0; j < times; ++j) {
    bool good = true;
    for (std::size_t i = 0; good && i < stroke.time.size(); ++i) {
      const double at = static_cast<double>(j) + stroke.time[i] / step;
      good = at <= last_time && reached[i][static_cast<std::size_t>(std::floor(at))] &&
             reached[i][static_cast<std::size_t>(std::ceil(at))];
    }
    const double time = begin + step * static_cast<double>(j);
    if (good && !open) windows.push_back({time, time});
    if (good) windows.back().until = time + stroke.duration;
    open = good;
  }
  return windows;
}

}  // namespace impedraw
