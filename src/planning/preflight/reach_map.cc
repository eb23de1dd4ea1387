#include "impedraw/planning/preflight/reach_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "impedraw/arm/least_energy_step.h"
#include "impedraw/common/rotations.h"
#include "impedraw/control/joint_speed_shares.h"

namespace impedraw {
namespace {

constexpr double kFarOff = 0.1;  // from a place that is not reached [m]

}  // namespace

ReachMap::ReachMap(const ArmModel& arm, const JointVector& q, const PreflightSettings& settings)
    : arm_(arm),
      q_(q),
      check_(arm, nullptr, q, settings),
      terms_(arm.joints()),
      last_(standing_at(q)) {
  check_.asked.pen = false;
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
  // A place far beyond the reach is not looked for from other postures.
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
                                           const CanvasPoses& canvas, double along, bool is_down) {
  constexpr double kDown = 0.5;  // the last of the way to a stroke [s]
  const StrokeTimes& times = path.strokes()[stroke];
  const double approach = is_down ? times.start : times.approach, end = times.end;
  const double down =
      is_down ? 0.0 : canvas.step * std::ceil(std::min(kDown, approach) / canvas.step);
  const double last = canvas.step * static_cast<double>(canvas.X_WK.size() - 1);
  std::vector<TipReference> places;  // in K
  PathSample at = path.at(approach - down);
  for (double t = approach - down; t <= end || at.phase == Phase::draw || at.phase == Phase::lift;
       at = path.at(t += canvas.step))
    places.push_back(at.reference);
  for (double t = 0.0; t < along; t += canvas.step) places.push_back(places.back());
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
