#include "impedraw/drivers/iiwa_lcm.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "impedraw/drivers/tcp.h"

namespace impedraw {
namespace {

// KUKA's data sheets: ranges are those of both arms, torques of the iiwa 14, the stronger one. A
// model that allows more describes another arm.
constexpr std::array<double, kIiwaJoints> kRangeDeg = {170, 120, 170, 120, 170, 120, 175};
constexpr std::array<double, kIiwaJoints> kTorque = {320, 320, 176, 176, 110, 40, 40};  // [Nm]
// drake-iiwa-driver ends a session at these external torques; a tenth less ends ours before [Nm].
constexpr std::array<double, kIiwaJoints> kExternal = {60, 60, 60, 30, 12, 12, 6};
constexpr double kOldestWrench = 1.0;  // before the first status that was answered [s]

void require_iiwa(const ArmModel& arm) {
  if (arm.joints() != kIiwaJoints)
    throw InputError(
        fmt::format("arm.urdf: the arm has {} joints, an iiwa has {}", arm.joints(), kIiwaJoints));
  const ArmLimits& limits = arm.limits();
  for (int j = 0; j < kIiwaJoints; ++j) {
    const double range = kRangeDeg[j] * 3.14159265358979323846 / 180.0 + 1e-3;
    const std::string& name = arm.joint_names()[static_cast<std::size_t>(j)];
    if (!(limits.lower[j] >= -range && limits.upper[j] <= range))
      throw InputError(
          fmt::format("arm.urdf: {} may turn from {:.3f} to {:.3f} rad, an iiwa's joint {} by "
                      "±{:.3f} rad: this "
                      "describes another arm",
                      name, limits.lower[j], limits.upper[j], j + 1, range));
    if (!(limits.torque[j] <= kTorque[j] + 1e-6))
      throw InputError(fmt::format(
          "arm.urdf: {} may use {:.0f} Nm, an iiwa's joint {} at most {:.0f} Nm: this describes "
          "another arm",
          name, limits.torque[j], j + 1, kTorque[j]));
  }
}

constexpr std::uint64_t kStatusType = 0xf16fb804284abca3, kCommandType = 0xddc7c7738c815334,
                        kForceTorqueType = 0x73206439325b65c5;

double get_double(const std::uint8_t** from) {
  return std::bit_cast<double>(get_big_endian(8, from));
}

}  // namespace

IiwaLcm::IiwaLcm(const ArmSettings& settings, const ArmModel& arm, double period,
                 std::optional<JointVector> start_q, bool wrench)
    : ForeignArm(settings, kIiwaJoints, period, std::move(start_q)),
      joint_names_(arm.joint_names()),
      limits_(arm.limits()),
      wants_wrench_(wrench),
      decoded_(kIiwaJoints) {
  require_iiwa(arm);
  check_lcm_url(settings.url);
  session_settings_ = session_settings(
      settings, arm, start_q_ ? *start_q_ : JointVector::Zero(kIiwaJoints), kExternal);
  session_ = std::make_unique<ArmSession>(session_settings_);
}

IiwaLcm::~IiwaLcm() { stop(); }

DriverInfo IiwaLcm::info() const {
  return {kIiwaJoints,
          period_,
          wants_wrench_ ? WrenchReading::tip : WrenchReading::none,
          true,
          settings_.clock == ArmClock::lock_step,
          true};
}

void IiwaLcm::connect() {
  link_ = std::make_unique<LcmLink>(settings_.url);
  link_->subscribe(kIiwaStatusChannel, [this](std::span<const std::uint8_t> bytes) {
    const Decoded result = decode_iiwa_status(bytes, &decoded_);
    if (result == Decoded::ok)
      decoded_any_ = true;
    else if (misread_.empty())
      misread_ = fmt::format("{} carries a message {}", kIiwaStatusChannel, name_of(result));
  });
  if (!wants_wrench_) return;
  link_->subscribe(kTipWrenchChannel, [this](std::span<const std::uint8_t> bytes) {
    const Decoded result = decode_tip_wrench(bytes, &wrench_);
    if (result == Decoded::ok)
      wrench_any_ = true;
    else if (misread_.empty())
      misread_ = fmt::format("{} carries a message {}", kTipWrenchChannel, name_of(result));
  });
}

void IiwaLcm::observe(double seconds, const Seen& seen) {
  connect();
  const double begin = wall_seconds(), end = begin + seconds;
  bool any = false;
  while (wall_seconds() < (any ? end : begin + kPatience)) {
    if (!link_->wait(0.1)) {
      if (!link_->connected()) throw std::runtime_error("the LCM broker closed the connection");
      continue;
    }
    decoded_any_ = false;
    link_->handle();
    if (!misread_.empty()) throw std::runtime_error(misread_);
    if (!decoded_any_) continue;
    any = true;
    seen(decoded_, wall_seconds());
  }
  link_.reset();
  if (!any)
    throw std::runtime_error(fmt::format("arm.url {}: no message on {} within {:.0f} s",
                                         settings_.url, kIiwaStatusChannel, kPatience));
}

void IiwaLcm::start() {
  session_ = std::make_unique<ArmSession>(session_settings_);
  fault_.clear();
  misread_.clear();
  statuses_ = answered_ = 0;
  began_ = answerable_ = wrench_any_ = false;
  connect();
  const double patience = wall_seconds() + kPatience;
  // Until the session may send. The statuses are only looked at: nothing is answered yet.
  while (!receive(wall_seconds() + 0.1)) {
    if (!fault_.empty()) throw std::runtime_error(fault_);
    if (session_->state() == SessionState::waiting && wall_seconds() > patience)
      throw std::runtime_error(fmt::format("arm.url {}: no message on {} within {:.0f} s",
                                           settings_.url, kIiwaStatusChannel, kPatience));
    if (wall_seconds() > patience + 10.0)
      throw std::runtime_error("the arm's clock stands still or runs far too slowly");
  }
  const double step = session_->mean_step();
  if (!(std::abs(step - period_) < 0.2 * period_))
    throw std::runtime_error(
        fmt::format("the arm's statuses are {:.3f} ms apart, the controller's step is {:.3f} ms",
                    1e3 * step, 1e3 * period_));
  require_posture(session_->last().q, limits_, joint_names_, start_q_);
  if (wants_wrench_ && !wrench_any_)
    throw std::runtime_error(
        fmt::format("control.wrench: ground_truth needs the wrench at the tip on {}, and none came",
                    kTipWrenchChannel));
}

bool IiwaLcm::receive(double until) noexcept {
  constexpr int kMostTaken = 1000;  // at once, however fast messages come
  bool fresh = false;
  for (int taken = 0; taken < kMostTaken; ++taken) {
    const double now = wall_seconds();
    // Messages that have arrived are taken first, so that the newest status is answered.
    if (!link_->wait(fresh ? 0.0 : std::max(0.0, until - now))) {
      if (!link_->connected()) session_->fail("the connection to the LCM broker was lost");
      break;
    }
    decoded_any_ = false;
    if (!link_->handle()) {
      session_->fail("the connection to the LCM broker was lost");
      break;
    }
    if (!misread_.empty()) {
      session_->fail(misread_);
      break;
    }
    if (!decoded_any_) continue;
    ++statuses_;
    fresh = session_->receive(decoded_, wall_seconds()) || fresh;
  }
  session_->tick(wall_seconds());
  note_session_fault();
  if (fresh) answerable_ = true;
  return fresh;
}

// A stamp of the future would be fresh for ever. One from before the session is of another clock;
// between them, age tells.
void IiwaLcm::require_wrench_stamp(std::int64_t utime) noexcept {
  const double ahead = seconds_between(utime, wrench_.utime);
  const double since = seconds_between(first_utime_, wrench_.utime);
  if (ahead <= session_settings_.max_gap && since >= -kOldestWrench) return;
  session_->fail(fmt::format(
      "the wrench is stamped {:.3f} s {} the arm's clock: {} must tell that clock's time",
      std::abs(ahead), ahead > 0.0 ? "ahead of" : "behind", kTipWrenchChannel));
  note_session_fault();
}

const ArmState& IiwaLcm::read() noexcept {
  if (!link_ || !fault_.empty()) return state_;
  if (began_ || !answerable_) {
    const double end = wall_seconds() + settings_.max_silence + 0.01;
    while (fault_.empty() && !receive(end)) {
    }
  } else {
    receive(wall_seconds());  // only what has arrived since start()
  }
  if (!fault_.empty()) return state_;  // what the arm says now is not believed
  const ArmStatus& last = session_->last();
  if (!began_) {
    began_ = true;
    first_utime_ = last.utime;
  }
  state_.time = state_.state_time = seconds_between(first_utime_, last.utime);
  state_.q = last.q;
  state_.v = last.v;
  state_.step_time = settings_.clock == ArmClock::wall ? last_step_ : 0.0;
  if (wants_wrench_) {
    require_wrench_stamp(last.utime);
    state_.wrench = wrench_.wrench;
    // The delay that the set-up knows of is no age (driver.h).
    state_.wrench_time = seconds_between(first_utime_, wrench_.utime) + settings_.wrench_delay;
  }
  read_at_ = wall_seconds();
  return state_;
}

void IiwaLcm::command(const JointVector& tau, const JointVector& gravity) noexcept {
  if (!link_ || !fault_.empty()) return;
  if (!session_->sent_any()) {
    // The loop has opened its log since it read the state. Clock and ramp begin now, with zero in
    // answer to the newest status: otherwise the plan would be ahead of an arm that rests.
    receive(wall_seconds());
    first_utime_ = session_->last().utime;
    if (!fault_.empty()) return;
    read_at_ = wall_seconds();  // what came before is no control step
  }
  wanted_ = tau - gravity;
  send(wanted_, false);
  last_step_ = wall_seconds() - read_at_;
}

void IiwaLcm::send(const JointVector& wanted, bool stale) noexcept {
  if (!answerable_ && !stale) return;
  answerable_ = false;
  if (!session_->may_send()) return;
  const JointVector& tau = session_->answer(wanted, stale);
  std::array<std::uint8_t, kIiwaCommandSize> bytes;
  encode_iiwa_command(session_->last().utime, tau, bytes);
  if (!link_->publish(kIiwaCommandChannel, bytes))
    session_->fail("the connection to the LCM broker was lost");
  else if (!stale)
    ++answered_;
  note_session_fault();
}

void IiwaLcm::hold() noexcept { session_->hold(); }

void IiwaLcm::stop() noexcept {
  if (!link_) return;
  wind_down();
  link_.reset();
}

const char* name_of(Decoded result) {
  static constexpr const char* kNames[] = {"ok", "of another type", "of the wrong size",
                                           "of an arm that has not seven joints"};
  return kNames[static_cast<std::size_t>(result)];
}

void encode_iiwa_command(std::int64_t utime, const JointVector& torque,
                         std::span<std::uint8_t, kIiwaCommandSize> bytes) noexcept {
  std::uint8_t* to = bytes.data();
  put_big_endian(kCommandType, 8, &to);
  put_big_endian(static_cast<std::uint64_t>(utime), 8, &to);
  put_big_endian(0, 4, &to);
  put_big_endian(kIiwaJoints, 4, &to);
  for (int j = 0; j < kIiwaJoints; ++j)
    put_big_endian(std::bit_cast<std::uint64_t>(torque[j]), 8, &to);
}

Decoded decode_iiwa_status(std::span<const std::uint8_t> bytes, ArmStatus* status) noexcept {
  const std::uint8_t* from = bytes.data();
  if (bytes.size() < 20) return Decoded::wrong_size;
  if (get_big_endian(8, &from) != kStatusType) return Decoded::other_type;
  const auto utime = static_cast<std::int64_t>(get_big_endian(8, &from));
  if (get_big_endian(4, &from) != kIiwaJoints) return Decoded::wrong_joints;
  if (bytes.size() != 20 + 7 * 8 * kIiwaJoints) return Decoded::wrong_size;
  status->utime = utime;
  for (int j = 0; j < kIiwaJoints; ++j) status->q[j] = get_double(&from);
  for (int j = 0; j < kIiwaJoints; ++j) status->v[j] = get_double(&from);
  from += 4 * 8 * kIiwaJoints;  // commanded, interpolated, measured and commanded torque
  for (int j = 0; j < kIiwaJoints; ++j) status->external[j] = get_double(&from);
  return Decoded::ok;
}

Decoded decode_tip_wrench(std::span<const std::uint8_t> bytes, TipWrench* wrench) noexcept {
  const std::uint8_t* from = bytes.data();
  if (bytes.size() < 8) return Decoded::wrong_size;
  if (get_big_endian(8, &from) != kForceTorqueType) return Decoded::other_type;
  if (bytes.size() != 16 + 6 * 8) return Decoded::wrong_size;
  wrench->utime = static_cast<std::int64_t>(get_big_endian(8, &from));
  for (int i = 0; i < 6; ++i) wrench->wrench[i] = get_double(&from);
  return Decoded::ok;
}

}  // namespace impedraw
