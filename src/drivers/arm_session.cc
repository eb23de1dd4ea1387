#include "impedraw/drivers/arm_session.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace impedraw {
namespace {

constexpr std::array<const char*, 8> kStateNames = {"waiting", "quiet", "start", "run",
                                                    "hold",    "fault", "stop",  "ended"};

}  // namespace

const char* name_of(SessionState state) { return kStateNames[static_cast<std::size_t>(state)]; }

ArmSession::ArmSession(const SessionSettings& settings)
    : settings_(settings),
      last_(static_cast<int>(settings.torque_limit.size())),
      motion_(settings.rated_speed, settings.torque_limit),
      sent_(JointVector::Zero(settings.torque_limit.size())) {
  const auto positive = [&](const JointVector& x) {
    return x.size() == sent_.size() && (x.array() > 0.0).all();
  };
  if (sent_.size() == 0 || !positive(settings.torque_limit) || !positive(settings.speed_limit) ||
      !positive(settings.rated_speed) || !positive(settings.external_limit) || !settings.damping)
    throw std::invalid_argument("a session's limits are positive, one for each joint");
}

void ArmSession::apply(Event event) noexcept {
  using S = SessionState;
  struct Row {
    S from;
    Event event;
    S to;
  };
  static constexpr Row rows[] = {
      {S::waiting, Event::status, S::quiet}, {S::waiting, Event::stop, S::ended},
      {S::waiting, Event::fail, S::ended},   {S::quiet, Event::quiet_over, S::start},
      {S::quiet, Event::stop, S::ended},     {S::quiet, Event::fail, S::ended},
      {S::start, Event::ramped, S::run},     {S::start, Event::hold, S::hold},
      {S::start, Event::stop, S::stop},      {S::start, Event::fail, S::fault},
      {S::run, Event::hold, S::hold},        {S::run, Event::stop, S::stop},
      {S::run, Event::fail, S::fault},       {S::hold, Event::run, S::start},
      {S::hold, Event::stop, S::stop},       {S::hold, Event::fail, S::fault},
      {S::fault, Event::at_rest, S::ended},  {S::stop, Event::at_rest, S::ended},
  };
  for (const Row& row : rows) {
    if (row.from != state_ || row.event != event) continue;
    state_ = row.to;
    entered_ = last_.utime;
    damped_ = 0.0;
    // Nothing was ever sent: there is nothing to take back, and the arm would take a first command
    // as the beginning of a session.
    if ((state_ == S::stop || state_ == S::fault) && !sent_any_) state_ = S::ended;
    return;
  }
}

bool ArmSession::may_send() const noexcept {
  return state_ != SessionState::waiting && state_ != SessionState::quiet &&
         state_ != SessionState::ended;
}

bool ArmSession::receive(const ArmStatus& status, double now) noexcept {
  if (state_ == SessionState::ended) return false;
  if (state_ == SessionState::waiting) {
    first_arrival_ = now;
    first_utime_ = status.utime;
  } else if (status.utime <= last_.utime) {
    if (++old_ > kMostOld)
      fail(status.utime == last_.utime
               ? std::string("the arm's clock stands still")
               : fmt::format("the arm's clock went back by {:.3f} s and stayed there",
                             seconds_between(status.utime, last_.utime)));
    return false;
  }
  old_ = 0;
  ++received_;
  const double step = seconds_between(last_.utime, status.utime);
  const bool first = state_ == SessionState::waiting;
  last_.utime = status.utime;
  last_arrival_ = now;
  last_.q = status.q;
  last_.v = status.v;
  last_.external = status.external;
  const double longest = may_send() ? settings_.max_gap : kLongestJump;
  if (first) {
    apply(Event::status);
  } else if (step > longest) {
    fail(
        fmt::format("the arm's clock jumped by {:.3f} s; at most {:.3f} s may lie between two "
                    "statuses",
                    step, longest));
  } else {
    if (usual_ == 0.0 || step < usual_) usual_ = step;
    missed_ += std::lround(step / usual_) - 1;
  }
  check(status, first ? 0.0 : step);
  const double quiet = seconds_between(first_utime_, status.utime);
  if (state_ == SessionState::quiet && quiet >= settings_.quiet_time &&
      now - first_arrival_ >= settings_.quiet_time)
    apply(Event::quiet_over);
  return may_send();
}

double ArmSession::mean_step() const noexcept {
  return seconds_between(first_utime_, last_.utime) /
         (received_ > 1 ? static_cast<double>(received_ - 1) : std::nan(""));
}

void ArmSession::check(const ArmStatus& status, double step) noexcept {
  if (!status.q.allFinite() || !status.v.allFinite() || !status.external.allFinite())
    return fail("the arm's status has numbers that are not finite");
  if (motion_.update(status.q, &status.v, sent_, status.external, step,
                     settings_.inertia.size() > 0 ? &settings_.inertia : nullptr))
    fail(motion_.cause());
  Eigen::Index j = 0;
  (status.v.array().abs() / settings_.speed_limit.array()).maxCoeff(&j);
  if (std::abs(status.v[j]) > settings_.speed_limit[j])
    return fail(fmt::format("joint {} turns at {:.2f} rad/s, more than {:.2f} rad/s{}", j + 1,
                            std::abs(status.v[j]), settings_.speed_limit[j],
                            std::abs(motion_.confirmed(status.v)[j]) < 0.5 * std::abs(status.v[j])
                                ? ", which its positions contradict"
                                : ""));
  (status.external.array().abs() / settings_.external_limit.array()).maxCoeff(&j);
  if (std::abs(status.external[j]) > settings_.external_limit[j])
    fail(fmt::format("an external torque of {:.1f} Nm acts on joint {}, more than {:.1f} Nm",
                     std::abs(status.external[j]), j + 1, settings_.external_limit[j]));
}

void ArmSession::tick(double now) noexcept {
  if (state_ == SessionState::waiting || state_ == SessionState::ended) return;
  if (now - last_arrival_ > settings_.max_silence)
    fail(fmt::format("no status of the arm for {:.3f} s", now - last_arrival_));
}

void ArmSession::hold() noexcept { apply(Event::hold); }
void ArmSession::run() noexcept { apply(Event::run); }
void ArmSession::stop() noexcept { apply(Event::stop); }

void ArmSession::fail(const std::string& cause) noexcept {
  if (cause_.empty()) cause_ = cause.empty() ? "a fault without a name" : cause;
  apply(Event::fail);
}

const JointVector& ArmSession::answer(const JointVector& wanted, bool stale) noexcept {
  if (!may_send()) return sent_;
  const double since = answered_ == 0 ? 0.0 : seconds_between(answered_, last_.utime);
  const double dt = stale ? 1e-3 : std::clamp(since, 0.0, settings_.longest_step);
  answered_ = last_.utime;
  if (!sent_any_) entered_ = last_.utime;  // the ramp begins with the first command

  const bool asked = state_ == SessionState::start || state_ == SessionState::run;
  if (asked && !(wanted.size() == sent_.size() && wanted.allFinite()))
    fail("the controller's torque is not finite");
  double share = 1.0;
  if (state_ == SessionState::start) {
    share = seconds_between(entered_, last_.utime) / settings_.ramp_time;
    if (share >= 1.0) apply(Event::ramped);
    share = std::min(share, 1.0);
  }
  const bool ending = state_ == SessionState::fault || state_ == SessionState::stop;
  if (ending) {
    damped_ += stale ? 1e-3 : std::max(dt, 1e-6);
    const bool calm = motion_.confirmed(last_.v).cwiseAbs().maxCoeff() < kDampedSpeed;
    damping_over_ = damping_over_ || stale || calm || damped_ > settings_.damp_time ||
                    !last_.q.allFinite() || !last_.v.allFinite();
  }
  JointVector damping = JointVector::Zero(sent_.size());
  if (ending && !damping_over_) damping = settings_.damping(last_.q, motion_.confirmed(last_.v));
  const bool follow = state_ == SessionState::start || state_ == SessionState::run;
  for (Eigen::Index j = 0; j < sent_.size(); ++j) {
    double tau = follow ? share * wanted[j] : damping[j];
    const double limit = settings_.torque_limit[j], most = settings_.torque_rate * dt;
    tau = std::clamp(tau, -limit, limit);
    sent_[j] = std::clamp(tau, sent_[j] - most, sent_[j] + most);
  }
  sent_any_ = true;
  if (ending && damping_over_ && sent_.isZero(0.0)) apply(Event::at_rest);
  return sent_;
}

SessionSettings session_settings(const ArmSettings& settings, ArmModel arm,
                                 const JointVector& posture, std::span<const double> external) {
  constexpr double kExternalShare = 0.9, kSpeedShare = 1.2;
  SessionSettings s;
  s.torque_limit = arm.limits().torque;
  s.speed_limit = kSpeedShare * arm.limits().speed;
  s.rated_speed = arm.limits().speed;
  s.external_limit = kExternalShare *
                     JointVector(Eigen::Map<const Eigen::VectorXd>(external.data(), arm.joints()));
  ArmTerms terms(arm.joints());
  arm.compute(posture, JointVector::Zero(arm.joints()), &terms);
  s.inertia = terms.M;
  s.damping = [arm, terms](const JointVector& q, const JointVector& v) mutable {
    arm.compute(q, v, &terms);
    return damping_torque(terms.M, v);
  };
  s.max_silence = settings.max_silence;
  return s;
}

void ForeignArm::wind_down() noexcept {
  session_->stop();
  constexpr double kLongest = 2.0;  // [s]
  const double end = wall_seconds() + kLongest;
  const double patience = settings_.clock == ArmClock::wall ? 0.005 : settings_.max_silence;
  bool silent = false;
  while (reachable() && session_->may_send() && wall_seconds() < end) {
    if (answerable_)
      send(zero_, false);
    else if (silent)
      send(zero_, true);
    silent = reachable() && session_->may_send() &&
             !receive(wall_seconds() + (silent ? 0.001 : patience));
  }
}

void ForeignArm::note_session_fault() noexcept {
  if (fault_.empty() && !session_->cause().empty())
    fault_ = fmt::format("arm: {} (state {})", session_->cause(), name_of(session_->state()));
}

void require_posture(const JointVector& q, const ArmLimits& limits,
                     const std::vector<std::string>& joint_names,
                     const std::optional<JointVector>& start_q) {
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const std::string& name = joint_names[static_cast<std::size_t>(j)];
    if (!(q[j] >= limits.lower[j] && q[j] <= limits.upper[j]))
      throw std::runtime_error(fmt::format(
          "{} stands at {:.3f} rad, beyond the {:.3f} to {:.3f} rad of arm.urdf: another arm, or "
          "another zero",
          name, q[j], limits.lower[j], limits.upper[j]));
    if (start_q && std::abs(q[j] - (*start_q)[j]) > ForeignArm::kStartTolerance)
      throw std::runtime_error(fmt::format(
          "{} stands at {:.3f} rad, the drawing starts at {:.3f} rad (within {:.2f} rad); "
          "./impedraw plan --json says where: start_q",
          name, q[j], (*start_q)[j], ForeignArm::kStartTolerance));
  }
}

}  // namespace impedraw
