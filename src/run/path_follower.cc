#include "impedraw/run/path_follower.h"

#include <cmath>
#include <utility>

#include "impedraw/arm/least_energy_step.h"

namespace impedraw {
namespace {

ClockSettings clock_settings(const Experiment& e) {
  ClockSettings settings;
  if (e.belief.by_touch()) settings.patience = 2.0 * longest_search(e.control.impedance);
  return settings;
}

}  // namespace

PathFollower::PathFollower(const Experiment& e, const DrivenArm& arm, const Move& move)
    : e_(e),
      arm_(arm),
      move_(move),
      begin_(arm.time()),
      clock_(clock_settings(e), e.control.impedance.timing.dt),
      odometer_(move.path) {
  if (e.belief.perception && !arm.loop().canvas().follows())
    forecast_ = JointForecast(e.belief.arm, move.path, arm.state().q, e.plan.rest_q,
                              e.plan.path_settings.joint_speed_share);
  if (move.touch) move.touch->search->begin_stroke();
}

bool PathFollower::goes_on(long cycles) const {
  const double dt = e_.control.impedance.timing.dt;
  return cycles < std::lround(std::ceil((path().duration() + clock_.lag()) / dt));
}

std::optional<PathSample> PathFollower::sample(bool up, const std::function<bool()>& holds) {
  planned_ = arm_.time() - begin_ - clock_.lag();
  PathSample desired = path().at(planned_);
  while (!up && followed_ < path().strokes().size() && path().strokes()[followed_].end <= planned_)
    ++followed_;
  const bool between = last_phase_ == Phase::lift && desired.phase == Phase::travel;
  if (move_.holds && !up && followed_ > 0 && between && !holds()) return std::nullopt;
  last_phase_ = desired.phase;
  const bool was_down = std::exchange(down_, desired.reference.pen_down);
  if (move_.touch) {
    if (was_down && !down_ && !up) return std::nullopt;
    desired.reference = move_.touch->search->at_touched_height(desired.reference, arm_.out().mode,
                                                               arm_.loop().terms().X_WE.p);
  }
  if (const std::optional<double>& height = e_.scenario.drawing.dry_run)
    desired.reference.p_WD += *height * e_.control.impedance.surface.drawing_axis_W;
  if (!touches(e_.scenario)) desired.reference.pen_down = false;
  desired.reference = clock_.scaled(desired.reference);
  return desired;
}

void PathFollower::advance(const Cycle& cycle, bool held) {
  PenDeviation pen = deviation(cycle);
  pen.paused = held;
  clock_.advance(pen);
}

bool PathFollower::advance_by_touch(const Cycle& cycle, const ControlLoop& loop, bool paused) {
  PenDeviation pen;
  pen.paused = paused;
  if (!move_.touch->search->update(cycle.desired, cycle.out, loop, &pen)) return false;
  clock_.advance(pen);
  return true;
}

// Distance of the pen from the plan's wish.
PenDeviation PathFollower::deviation(const Cycle& cycle) const {
  PenDeviation pen;
  if (!e_.belief.perception) return pen;
  const ImpedanceTorque& out = cycle.out;
  pen.limit = forecast_.limit(planned_);
  pen.joint = cycle.speed_share(e_.belief.arm.limits().speed);
  const bool draws = cycle.desired.stroke >= 0;
  const auto begins = [&] { return path().at(planned_ + clock_.way()).stroke >= 0; };
  // A stroke begins in contact: where the pen has not touched yet, the clock stops before it does.
  pen.waits =
      out.mode == ContactMode::approach ? draws || begins() : !draws && arm_.loop().retreats();
  if (!draws) return pen;
  pen.tilt = smallest_rotation(cycle.arm.X_WE.R.col(2), -out.axis_WD).norm();
  if (out.mode != ContactMode::contact) return pen;
  pen.tip = cycle.behind().norm();
  // A motion that frames confirm is the canvas's own, and no roughness.
  const double unexplained = 1.0 - cycle.confirmed;
  pen.normal_speed = unexplained * (out.n_WD.dot(cycle.velocity_on_canvas()) - out.rise);
  if (e_.control.impedance.wrench == WrenchFeedback::measured && out.push > 0.0)
    pen.force = unexplained * (cycle.normal_force() - out.push) /
                std::max(out.push, e_.control.impedance.normal_force);
  return pen;
}

bool PathFollower::passes_last_stroke(const Cycle& cycle) {
  if (past_ || !cycle.canvas.joined() || cycle.out.mode != ContactMode::free ||
      planned_ <= path().strokes().back().end)
    return false;
  return past_ = true;
}

RunProgress PathFollower::progress(double run_time) const {
  RunProgress progress{run_time,   0, 0, 0.0, 0.0, std::min(1.0, planned_ / path().duration()),
                       move_.again};
  odometer_.read(planned_, &progress);
  if (const std::optional<TouchedStroke>& one = move_.touch) {
    progress.stroke += one->before;
    progress.strokes = one->all;
    progress.share = (one->before + progress.share) / one->all;
  }
  return progress;
}

JointForecast::JointForecast(ArmModel arm, const TipPath& path, const JointVector& start,
                             const JointVector& rest_q, double share) {
  constexpr int kSubsteps = 2;
  constexpr double kSettle = 0.5;        // time in which the redundant joints settle [s]
  constexpr double kFurthestStep = 0.3;  // of a joint; a longer one would leave the path [rad]
  constexpr double kLeast = 0.05;        // rate
  const double dt = kStep / kSubsteps;
  const double relax = 1.0 - std::exp(-dt / kSettle);
  const JointVector speed = arm.limits().speed;
  ArmTerms terms(arm.joints());
  arm.compute(start, JointVector::Zero(start.size()), &terms);
  const JointVector weight = relaxation_weight(terms);
  JointVector q = start;
  std::vector<float> own;
  for (double t = 0.0; t < path.duration(); t += kStep) {
    double fastest = 0.0;
    for (int k = 1; k <= kSubsteps; ++k) {
      const TipReference r = path.at(t + k * dt).reference;
      arm.compute(q, JointVector::Zero(q.size()), &terms);
      const LeastEnergyStep least =
          least_energy_step(terms, tip_displacement(terms.X_WE, r.p_WD, -r.n_WD, r.x_WD),
                            relax * weight.cwiseProduct(rest_q - q), 1e-6);
      // The clock slows the task's part alone.
      const JointVector& task = least.task;
      JointVector step = least.task + least.redundant;
      if (!step.allFinite()) return;
      fastest = std::max(fastest, (task.cwiseAbs().array() / speed.array()).maxCoeff() / dt);
      const double longest = step.cwiseAbs().maxCoeff();
      if (longest > kFurthestStep) step *= kFurthestStep / longest;
      q += step;
    }
    own.push_back(static_cast<float>(std::clamp(share / std::max(fastest, 1e-9), kLeast, 1.0)));
  }
  limits_ = own;
  const auto ahead = static_cast<std::size_t>(kAhead / kStep);
  for (std::size_t i = 0; i < own.size(); ++i)
    limits_[i] = *std::min_element(
        own.begin() + static_cast<std::ptrdiff_t>(i),
        own.begin() + static_cast<std::ptrdiff_t>(std::min(own.size(), i + ahead + 1)));
}

double JointForecast::limit(double t) const noexcept {
  if (limits_.empty() || !(t >= 0.0)) return 1.0;
  const auto i = static_cast<std::size_t>(t / kStep);
  return i < limits_.size() ? limits_[i] : 1.0;
}

}  // namespace impedraw
