#include "impedraw/drivers/fci_link.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "impedraw/drivers/tcp.h"
#include "impedraw/terminal/clock.h"

namespace impedraw {
namespace {

sockaddr_in fci_address(const std::string& url) {
  constexpr std::string_view scheme = "fci://";
  if (url.starts_with(scheme))
    if (const auto address = ipv4_address(url.substr(scheme.size()), kFciPort)) return *address;
  throw InputError(fmt::format(
      "arm.url is '{}'; with arm.driver franka valid is fci://A.B.C.D or fci://A.B.C.D:PORT, as in "
      "fci://172.16.0.2",
      url));
}

static_assert(std::endian::native == std::endian::little, "the FCI's numbers are little-endian");

template <typename T>
void put(std::vector<std::uint8_t>* to, T value) {
  const auto bytes = std::bit_cast<std::array<std::uint8_t, sizeof(T)>>(value);
  to->insert(to->end(), bytes.begin(), bytes.end());
}

template <typename T>
T number_at(const std::uint8_t* bytes, std::size_t at) noexcept {
  T value;
  std::memcpy(&value, bytes + at, sizeof value);
  return value;
}

// Offsets of the state's fields: message_id, 126 floats of poses and loads, then the joints'.
constexpr std::size_t kPositionAt = 596, kVelocityAt = 652, kExternalAt = 840, kMotionMode = 1288,
                      kControllerMode = kMotionMode + 1, kErrorsAt = kControllerMode + 1,
                      kReflexReasonAt = kErrorsAt + 41, kRobotMode = kReflexReasonAt + 41,
                      kSuccessRate = kRobotMode + 1;
static_assert(kSuccessRate + 4 == kFciStateSize);
constexpr std::size_t kTorqueAt = 8 + 8 * (7 + 7 + 16 + 6 + 2) + 2;
static_assert(kTorqueAt + 8 * kFciJoints + 1 == kFciCommandSize);

// In the order of the wire.
constexpr std::array<const char*, 41> kErrorNames = {
    "joint_position_limits_violation",
    "cartesian_position_limits_violation",
    "self_collision_avoidance_violation",
    "joint_velocity_violation",
    "cartesian_velocity_violation",
    "force_control_safety_violation",
    "joint_reflex",
    "cartesian_reflex",
    "max_goal_pose_deviation_violation",
    "max_path_pose_deviation_violation",
    "cartesian_velocity_profile_safety_violation",
    "joint_position_motion_generator_start_pose_invalid",
    "joint_motion_generator_position_limits_violation",
    "joint_motion_generator_velocity_limits_violation",
    "joint_motion_generator_velocity_discontinuity",
    "joint_motion_generator_acceleration_discontinuity",
    "cartesian_position_motion_generator_start_pose_invalid",
    "cartesian_motion_generator_elbow_limit_violation",
    "cartesian_motion_generator_velocity_limits_violation",
    "cartesian_motion_generator_velocity_discontinuity",
    "cartesian_motion_generator_acceleration_discontinuity",
    "cartesian_motion_generator_elbow_sign_inconsistent",
    "cartesian_motion_generator_start_elbow_invalid",
    "force_controller_desired_force_tolerance_violation",
    "start_elbow_sign_inconsistent",
    "communication_constraints_violation",
    "power_limit_violation",
    "cartesian_motion_generator_joint_position_limits_violation",
    "cartesian_motion_generator_joint_velocity_limits_violation",
    "cartesian_motion_generator_joint_velocity_discontinuity",
    "cartesian_motion_generator_joint_acceleration_discontinuity",
    "cartesian_position_motion_generator_invalid_frame",
    "controller_torque_discontinuity",
    "joint_p2p_insufficient_torque_for_planning",
    "tau_j_range_violation",
    "instability_detected",
    "joint_move_in_wrong_direction",
    "cartesian_spline_motion_generator_violation",
    "joint_via_motion_generator_planning_joint_limit_violation",
    "base_acceleration_initialization_timeout",
    "base_acceleration_invalid_reading"};

}  // namespace

void check_fci_url(const std::string& url) { fci_address(url); }

FciLink::FciLink(const std::string& url) : url_(url) {
  const sockaddr_in address = fci_address(url);
  host_ = address.sin_addr.s_addr;
  int error = 0;
  tcp_ = connect_tcp(address, kPatience, &error);
  const auto give_up = [this](const std::string& why) {
    close_all();
    throw std::runtime_error(fmt::format("arm.url {}: {}", url_, why));
  };
  if (tcp_ < 0) give_up(fmt::format("no arm answers ({})", std::strerror(error)));
  // States come to the address from which the arm is reached, and to no other.
  sockaddr_in own{};
  socklen_t size = sizeof own;
  getsockname(tcp_, reinterpret_cast<sockaddr*>(&own), &size);
  own.sin_port = 0;
  udp_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (udp_ < 0 || bind(udp_, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0)
    give_up(fmt::format("no UDP port for the arm's states ({})", std::strerror(errno)));
  getsockname(udp_, reinterpret_cast<sockaddr*>(&own), &size);
  const auto answer = request(FciCommand::connect, fci_connect(ntohs(own.sin_port)));
  const int version = answer.size() >= 3 ? answer[1] | answer[2] << 8 : 0;
  if (answer.empty() || answer[0] != kFciSuccess || version != kFciVersion)
    give_up(
        fmt::format("the arm speaks FCI version {}, this program {} (FR3 with a system of 5.7 or "
                    "later)",
                    version, kFciVersion));
}

FciLink::~FciLink() { close_all(); }

void FciLink::close_all() noexcept {
  for (int* descriptor : {&tcp_, &udp_}) {
    if (*descriptor >= 0) close(*descriptor);
    *descriptor = -1;
  }
}

std::uint32_t FciLink::post(FciCommand command, const std::vector<std::uint8_t>& payload) {
  const std::uint32_t id = next_id_++;
  const std::vector<std::uint8_t> bytes = encode_fci_request(command, id, payload);
  // Requests are small: they fit the socket's buffer, or the connection is lost.
  if (tcp_ < 0 || ::send(tcp_, bytes.data(), bytes.size(), MSG_NOSIGNAL) !=
                      static_cast<ssize_t>(bytes.size())) {
    close_all();
    throw std::runtime_error(fmt::format("arm.url {}: the connection was lost", url_));
  }
  return id;
}

std::optional<std::vector<std::uint8_t>> FciLink::response(std::uint32_t id, double patience) {
  read_responses(patience, id);
  const auto found = responses_.find(id);
  if (found == responses_.end()) return std::nullopt;
  std::vector<std::uint8_t> payload = std::move(found->second);
  responses_.erase(found);
  return payload;
}

std::vector<std::uint8_t> FciLink::request(FciCommand command,
                                           const std::vector<std::uint8_t>& payload,
                                           double patience) {
  auto answer = response(post(command, payload), patience);
  if (!answer)
    throw std::runtime_error(
        fmt::format("arm.url {}: no answer to request {} within {:.0f} s: no arm with Franka's "
                    "control interface, or another program drives it",
                    url_, static_cast<unsigned>(command), patience));
  return *answer;
}

void FciLink::read_responses(double patience, std::uint32_t id) {
  const auto begin = Clock::now();
  std::array<std::uint8_t, 65536> some;
  while (!responses_.contains(id)) {
    if (tcp_ < 0)
      throw std::runtime_error(fmt::format("arm.url {}: the connection was lost", url_));
    const double left = patience - seconds_since(begin);
    if (left < 0.0 || !readable(tcp_, left)) return;
    const ssize_t n = recv(tcp_, some.data(), some.size(), 0);
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) {
      close_all();
      continue;
    }
    if (n > 0) received_.insert(received_.end(), some.begin(), some.begin() + n);
    while (received_.size() >= kFciHeaderSize) {
      const FciHeader header =
          decode_fci_header(std::span<const std::uint8_t, kFciHeaderSize>(received_.data(), 12));
      if (header.size < kFciHeaderSize || header.size > kFciLargest) {
        close_all();
        throw std::runtime_error(fmt::format(
            "arm.url {}: what answers there is no arm with Franka's control interface", url_));
      }
      if (header.id >= next_id_ || responses_.size() >= kMostWaiting) {
        close_all();
        throw std::runtime_error(fmt::format(
            "arm.url {}: it sends answers that nobody asked for (to request {})", url_, header.id));
      }
      if (received_.size() < header.size) break;
      responses_.emplace(header.id, std::vector<std::uint8_t>(received_.begin() + kFciHeaderSize,
                                                              received_.begin() + header.size));
      received_.erase(received_.begin(), received_.begin() + header.size);
    }
  }
}

int FciLink::receive(double seconds, FciState* state) noexcept {
  int taken = 0;
  while (taken < kMostTaken && receive_next(taken == 0 ? seconds : 0.0, state)) ++taken;
  return taken;
}

bool FciLink::receive_next(double seconds, FciState* state) noexcept {
  const auto begin = Clock::now();
  std::array<std::uint8_t, kFciStateSize + 1> bytes;
  while (udp_ >= 0 && readable(udp_, seconds - seconds_since(begin))) {
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t n =
        recvfrom(udp_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    if (n < 0 || (!peer_known_ && from.sin_addr.s_addr != host_)) continue;
    if (!decode_fci_state({bytes.data(), static_cast<std::size_t>(n)}, state)) continue;
    // Torques go where the states come from; the first state says where.
    if (!peer_known_)
      peer_known_ = connect(udp_, reinterpret_cast<const sockaddr*>(&from), sizeof from) == 0;
    return true;
  }
  return false;
}

bool FciLink::send(std::uint64_t message_id, const JointVector& torque, bool finished) noexcept {
  if (udp_ < 0 || !peer_known_) return false;
  std::array<std::uint8_t, kFciCommandSize> bytes;
  encode_fci_torque(message_id, torque, finished, bytes);
  return ::send(udp_, bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
         static_cast<ssize_t>(bytes.size());
}

std::vector<std::uint8_t> encode_fci_request(FciCommand command, std::uint32_t id,
                                             std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> bytes;
  put(&bytes, static_cast<std::uint32_t>(command));
  put(&bytes, id);
  put(&bytes, static_cast<std::uint32_t>(kFciHeaderSize + payload.size()));
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  return bytes;
}

FciHeader decode_fci_header(std::span<const std::uint8_t, kFciHeaderSize> bytes) noexcept {
  return {number_at<std::uint32_t>(bytes.data(), 0), number_at<std::uint32_t>(bytes.data(), 4),
          number_at<std::uint32_t>(bytes.data(), 8)};
}

std::vector<std::uint8_t> fci_connect(std::uint16_t udp_port) {
  std::vector<std::uint8_t> bytes;
  put(&bytes, kFciVersion);
  put(&bytes, udp_port);
  return bytes;
}

std::vector<std::uint8_t> fci_torque_move() {
  constexpr std::uint32_t kExternalController = 2, kNoGenerator = 4;
  std::vector<std::uint8_t> bytes;
  put(&bytes, kExternalController);
  put(&bytes, kNoGenerator);
  // Largest deviations from path and goal, of a motion generator: as libfranka sends them.
  for (const double most : {0.01, 3.12, 6.28, 0.01, 3.12, 6.28}) put(&bytes, most);
  return bytes;
}

std::vector<std::uint8_t> fci_collision_behavior(const std::array<double, 7>& torque,
                                                 const std::array<double, 6>& force) {
  std::vector<std::uint8_t> bytes;
  // Lower and upper thresholds, while accelerating and at constant speed.
  for (int i = 0; i < 4; ++i)
    for (const double x : torque) put(&bytes, x);
  for (int i = 0; i < 4; ++i)
    for (const double x : force) put(&bytes, x);
  return bytes;
}

std::string fci_move_status(std::uint8_t status) {
  constexpr std::array<const char*, 12> names = {
      "success",
      "motion started",
      "preempted",
      "preempted by a safety function",
      "rejected: a safety function is active",
      "rejected: not possible in this state (a reflex to recover from, brakes, guiding)",
      "rejected: the arm stands at a singular pose",
      "rejected: invalid argument",
      "aborted by a reflex",
      "aborted by an emergency stop",
      "aborted by an input error",
      "aborted"};
  return status < names.size() ? names[status] : fmt::format("status {}", status);
}

const char* name_of(FciMode mode) {
  constexpr std::array<const char*, 7> names = {"other",  "idle",         "move",      "guiding",
                                                "reflex", "user stopped", "recovering"};
  const auto i = static_cast<std::size_t>(mode);
  return i < names.size() ? names[i] : "unknown";
}

bool decode_fci_state(std::span<const std::uint8_t> bytes, FciState* state) noexcept {
  if (bytes.size() != kFciStateSize) return false;
  const std::uint8_t* b = bytes.data();
  state->message_id = number_at<std::uint64_t>(b, 0);
  constexpr std::uint64_t kMost = std::numeric_limits<std::int64_t>::max() / 1000;
  state->arm.utime = static_cast<std::int64_t>(1000 * std::min(state->message_id, kMost));
  for (std::size_t j = 0; j < kFciJoints; ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    state->arm.q[i] = number_at<float>(b, kPositionAt + 4 * j);
    state->arm.v[i] = number_at<float>(b, kVelocityAt + 4 * j);
    state->arm.external[i] = number_at<float>(b, kExternalAt + 4 * j);
  }
  state->external_controller = b[kControllerMode] == 2;
  std::copy_n(b + kErrorsAt, state->errors.size(), state->errors.begin());
  std::copy_n(b + kReflexReasonAt, state->reflex_reason.size(), state->reflex_reason.begin());
  state->mode = static_cast<FciMode>(b[kRobotMode]);
  state->success_rate = number_at<float>(b, kSuccessRate);
  return true;
}

void encode_fci_torque(std::uint64_t message_id, const JointVector& torque, bool finished,
                       std::span<std::uint8_t, kFciCommandSize> bytes) noexcept {
  std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});
  std::memcpy(bytes.data(), &message_id, sizeof message_id);
  std::memcpy(bytes.data() + kTorqueAt, torque.data(), 8 * kFciJoints);
  bytes[kFciCommandSize - 1] = finished ? 1 : 0;
}

std::string fci_errors(const std::array<std::uint8_t, 41>& flags) {
  std::string text;
  for (std::size_t i = 0; i < flags.size(); ++i)
    if (flags[i]) text += (text.empty() ? "" : ", ") + std::string(kErrorNames[i]);
  return text;
}

bool fci_collision(const std::array<std::uint8_t, 41>& flags) noexcept {
  // self_collision_avoidance, force_control_safety, joint_reflex, cartesian_reflex
  return flags[2] || flags[5] || flags[6] || flags[7];
}

}  // namespace impedraw
