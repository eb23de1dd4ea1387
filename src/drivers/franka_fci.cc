#include "impedraw/drivers/franka_fci.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "impedraw/arm/urdf_text.h"

namespace impedraw {
namespace {

// At these external torques [Nm] and forces [N], [Nm] the arm stops by a reflex. A pen that presses
// with 5 N at the arm's full reach makes 4 Nm.
constexpr std::array<double, 7> kContactTorque = {20, 20, 18, 18, 16, 14, 12};
constexpr std::array<double, 6> kContactForce = {30, 30, 30, 25, 25, 25};

SessionSettings fci_session_settings(const ArmSettings& settings, const ArmModel& arm,
                                     const JointVector& posture, double period) {
  SessionSettings s = session_settings(settings, arm, posture, kContactTorque);
  s.quiet_time = 0.0;
  s.longest_step = period;  // the arm differences what it got, whatever it missed in between
  return s;
}

// The URDF of the arm as it is sent, in a file for as long as the parser needs it.
class UrdfFile {
 public:
  explicit UrdfFile(const std::string& text)
      : path_(std::filesystem::temp_directory_path() /
              fmt::format("impedraw-arm-{}.urdf", getpid())) {
    std::ofstream(path_) << text;
  }
  ~UrdfFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Without its shapes, which are meshes in files that only the arm has.
std::string without_shapes(std::string urdf) {
  for (const std::string kind : {"visual", "collision"}) {
    for (std::size_t at = 0; (at = urdf.find("<" + kind, at)) != std::string::npos;) {
      const std::string close = "</" + kind + ">";
      const std::size_t end = urdf.find(close, at);
      if (end == std::string::npos) return urdf;
      urdf.erase(at, end + close.size() - at);
    }
  }
  return urdf;
}

// The last link of the arm itself, as Franka's descriptions name it: …link7.
std::string last_link(const std::string& urdf) {
  const std::string end = "link7\"";
  for (std::size_t at = urdf.find(end); at != std::string::npos; at = urdf.find(end, at + 1)) {
    const std::size_t quote = urdf.rfind('"', at);
    if (quote != std::string::npos && urdf.compare(quote - 5, 5, "name=") == 0)
      return urdf.substr(quote + 1, at + end.size() - 2 - quote);
  }
  throw InputError("the arm's own URDF has no link named …link7: no arm of Franka");
}

}  // namespace

void require_same_arm(const std::string& urdf_of_arm, ArmModel model) {
  require_urdf(urdf_of_arm, "of the arm");
  const std::string link = last_link(urdf_of_arm);
  const UrdfFile file(without_shapes(urdf_of_arm));
  ArmModel theirs(file.path(), link);
  if (theirs.joints() != model.joints())
    throw InputError(fmt::format("arm.urdf: the model has {} joints, the arm {}", model.joints(),
                                 theirs.joints()));
  const ArmLimits &own = model.limits(), &real = theirs.limits();
  for (int j = 0; j < model.joints(); ++j) {
    const std::string& name = model.joint_names()[static_cast<std::size_t>(j)];
    if (own.lower[j] < real.lower[j] - 1e-3 || own.upper[j] > real.upper[j] + 1e-3)
      throw InputError(fmt::format(
          "arm.urdf: {} may turn from {:.3f} to {:.3f} rad, the arm's from {:.3f} to {:.3f} rad: "
          "this describes another arm",
          name, own.lower[j], own.upper[j], real.lower[j], real.upper[j]));
    if (own.torque[j] > real.torque[j] + 1e-6)
      throw InputError(
          fmt::format("arm.urdf: {} may use {:.1f} Nm, the arm's {:.1f} Nm: this describes another "
                      "arm",
                      name, own.torque[j], real.torque[j]));
    if (own.speed[j] > real.speed[j] + 1e-3)
      throw InputError(fmt::format(
          "arm.urdf: {} may turn at {:.2f} rad/s, the arm's at {:.2f} rad/s: this describes "
          "another arm",
          name, own.speed[j], real.speed[j]));
  }
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0.1, 0.9);
  std::optional<Pose> X_LE;  // of the tip on the arm's last link
  for (int i = 0; i < 20; ++i) {
    JointVector q(model.joints());
    for (int j = 0; j < model.joints(); ++j)
      q[j] = own.lower[j] + share(random) * (own.upper[j] - own.lower[j]);
    const Pose X = theirs.tip_pose(q).inverse() * model.tip_pose(q);
    if (!X_LE) X_LE = X;
    const double off = (X.p - X_LE->p).norm();
    if (off > 1e-3)
      throw InputError(fmt::format(
          "arm.urdf: its tip moves by {:.1f} mm on the arm's last link when the joints turn: this "
          "describes another arm",
          1e3 * off));
  }
}

FrankaFci::FrankaFci(const ArmSettings& settings, const ArmModel& arm, double period,
                     std::optional<JointVector> start_q)
    : ForeignArm(settings, kFciJoints, period, std::move(start_q)), arm_(arm) {
  if (arm.joints() != kFciJoints)
    throw InputError(
        fmt::format("arm.urdf: the arm has {} joints, Franka's {}", arm.joints(), kFciJoints));
  if (std::abs(period - 1e-3) > 1e-9)
    throw InputError(
        fmt::format("world.dt is {} s; Franka's arm takes a torque every 0.001 s", period));
  check_fci_url(settings.url);
}

FrankaFci::~FrankaFci() { stop(); }

DriverInfo FrankaFci::info() const {
  return {kFciJoints, period_, WrenchReading::none, true, settings_.clock == ArmClock::lock_step,
          true};
}

void FrankaFci::connect() {
  if (link_ && link_->connected()) return;
  link_.reset();
  link_ = std::make_unique<FciLink>(settings_.url);
  await_state();
  require_same_arm();
}

// The newest state; older ones are dropped.
void FrankaFci::await_state() {
  if (link_->receive(kPatience, &last_) > 0) return;
  link_.reset();
  throw std::runtime_error(
      fmt::format("arm.url {}: no state within {:.0f} s", settings_.url, kPatience));
}

void FrankaFci::require_same_arm() {
  const auto answer = link_->request(FciCommand::get_robot_model, {});
  if (answer.empty() || answer[0] != kFciSuccess)
    throw std::runtime_error("the arm does not tell its URDF");
  std::string urdf(answer.begin() + 1, answer.end());
  while (!urdf.empty() && urdf.back() == '\0') urdf.pop_back();
  impedraw::require_same_arm(urdf, arm_);
}

void FrankaFci::observe(double seconds, const Seen& seen) {
  connect();
  const double end = wall_seconds() + seconds;
  FciState state = last_;
  while (wall_seconds() < end) {
    if (!link_->receive_next(0.1, &state)) continue;
    seen(state.arm, wall_seconds());
  }
}

void FrankaFci::start() {
  fault_.clear();
  moving_ = holds_ = answerable_ = reflex_ = false;
  session_.reset();
  connect();
  await_state();
  if (last_.mode != FciMode::idle) {
    const std::string errors = fci_errors(last_.errors);
    throw std::runtime_error(fmt::format(
        "the arm is not ready: its mode is '{}'{}; valid is idle, with the FCI activated and the "
        "brakes open",
        name_of(last_.mode), errors.empty() ? "" : ", after " + errors));
  }
  require_posture(last_.arm.q, arm_.limits(), arm_.joint_names(), start_q_);
  const auto answer = link_->request(FciCommand::set_collision_behavior,
                                     fci_collision_behavior(kContactTorque, kContactForce));
  if (answer.empty() || answer[0] != kFciSuccess)
    throw std::runtime_error("the arm refuses the thresholds of its contact reflexes");
  await_state();
  state_.time = state_.state_time = 0.0;
  state_.q = last_.arm.q;
  state_.v = last_.arm.v;
}

void FrankaFci::begin_motion() {
  motion_ = link_->post(FciCommand::move, fci_torque_move());
  const auto answer = link_->response(motion_, kPatience);
  if (!answer || answer->empty() || (*answer)[0] != kFciMotionStarted) {
    note_fault("the arm did not begin a motion: " +
               (answer && !answer->empty() ? fci_move_status((*answer)[0]) : "no answer"));
    return;
  }
  // The states until then are of the arm at rest, and answering them would be too early.
  const double end = wall_seconds() + kPatience;
  do {
    if (link_->receive(end - wall_seconds(), &last_) == 0) {
      note_fault("no state after the motion began");
      return;
    }
  } while (last_.mode != FciMode::move || !last_.external_controller);
  session_ =
      std::make_unique<ArmSession>(fci_session_settings(settings_, arm_, last_.arm.q, period_));
  moving_ = true;
  first_utime_ = last_.arm.utime;
  answerable_ = session_->receive(last_.arm, wall_seconds());
}

bool FrankaFci::receive(double until) noexcept {
  const int taken = link_->receive(std::max(0.0, until - wall_seconds()), &last_);
  if (taken == 0) {
    if (moving_) {
      session_->tick(wall_seconds());
      note_session_fault();
    }
    return false;
  }
  statuses_ += taken;
  if (!moving_) return true;
  if (last_.mode != FciMode::move) {
    moving_ = false;
    const std::string errors = fci_errors(last_.reflex_reason), state = name_of(session_->state());
    reflex_ = last_.mode == FciMode::reflex;
    const std::string cause =
        reflex_ ? "reflex " + (errors.empty() ? "without a flag that names its cause" : errors)
                : fmt::format("it left the motion: mode '{}'", name_of(last_.mode));
    session_->fail(cause);
    note_fault(fmt::format("{} (state {})", cause, state));
    return true;
  }
  if (session_->receive(last_.arm, wall_seconds())) answerable_ = true;
  note_session_fault();
  return true;
}

void FrankaFci::note_fault(const std::string& cause) noexcept {
  if (fault_.empty()) fault_ = "arm: " + cause;
}

const ArmState& FrankaFci::read() noexcept {
  if (!link_ || !fault_.empty()) return state_;
  if (moving_) {
    const double end = wall_seconds() + settings_.max_silence + 0.01;
    while (fault_.empty() && !answerable_) receive(end);
    if (!fault_.empty()) return state_;  // what the arm says now is not believed
    state_.time = state_.state_time = seconds_between(first_utime_, last_.arm.utime);
  } else {
    receive(wall_seconds());
  }
  state_.q = last_.arm.q;
  state_.v = last_.arm.v;
  state_.step_time = settings_.clock == ArmClock::wall ? last_step_ : 0.0;
  read_at_ = wall_seconds();
  return state_;
}

void FrankaFci::command(const JointVector& tau, const JointVector& gravity) noexcept {
  if (!link_ || !fault_.empty()) return;
  if (!moving_) {
    try {
      begin_motion();
    } catch (const std::exception& error) {
      note_fault(error.what());
    }
    if (!fault_.empty()) return;
    if (holds_) session_->hold();
    read_at_ = wall_seconds();  // what came before is no control step
  }
  wanted_ = tau - gravity;
  send(wanted_, false);
  last_step_ = wall_seconds() - read_at_;
}

void FrankaFci::send(const JointVector& wanted, bool stale) noexcept {
  if (!moving_ || (!answerable_ && !stale)) return;
  answerable_ = false;
  if (!session_->may_send()) return;
  const JointVector& tau = session_->answer(wanted, stale);
  if (!link_->send(last_.message_id, tau, false))
    note_fault("the connection was lost");
  else if (!stale)
    ++answered_;
  note_session_fault();
}

void FrankaFci::hold() noexcept {
  holds_ = true;
  if (session_) session_->hold();
}

// Tells the arm that the torques end: it holds itself then.
void FrankaFci::end_motion() noexcept {
  if (!moving_) return;
  moving_ = false;
  try {
    for (int i = 0; i < 5; ++i) {  // a datagram may be lost
      link_->send(last_.message_id, zero_, true);
      const auto answer = link_->response(motion_, 0.1);
      if (answer) return;
      link_->receive(0.0, &last_);
    }
  } catch (const std::exception&) {
  }
}

void FrankaFci::stop() noexcept {
  if (!link_ || !session_) return;
  wind_down();
  end_motion();
  session_.reset();
}

bool FrankaFci::recover(JointVector* q) noexcept {
  try {
    if (!reflex_ || !link_ || !link_->connected() || fci_collision(last_.reflex_reason))
      return false;
    const auto await = [this](double longest, const auto& is_there) {
      const double end = wall_seconds() + longest;
      do await_state();
      while (!is_there() && wall_seconds() < end);
      return is_there();
    };
    const auto answer = link_->request(FciCommand::automatic_error_recovery, {}, kRecovery);
    if (answer.empty() || answer[0] != kFciSuccess) return false;
    if (!await(kRecovery, [this] { return last_.mode == FciMode::idle; })) return false;
    // A drawing goes on from where the arm has come to rest.
    await(kRest, [this] { return last_.arm.v.cwiseAbs().maxCoeff() < kDampedSpeed; });
    *q = last_.arm.q;
    start_q_ = last_.arm.q;
    reflex_ = false;
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace impedraw
