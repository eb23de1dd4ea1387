// A connection to a Franka arm: TCP for requests, UDP for states and torques.
// Single-threaded: responses are read when somebody waits for one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "impedraw/drivers/arm_session.h"

namespace impedraw {

// The messages of Franka's control interface (FCI) in protocol version 10, which an FR3 speaks to
// libfranka 0.14 and later: packed, little-endian. Checked against bytes of franka-sim
// (tests/drivers) and against its server (tests/foreign/franka).
//
//   TCP, both ways   { uint32 command, command_id, size; … }, size with these twelve bytes. A
//                    response begins with a status (uint8); Move has two, kMotionStarted first.
//   UDP, from arm    the robot's state, 1377 bytes, once a millisecond; numbers are floats
//   UDP, to arm      { uint64 message_id; double q_c[7], dq_c[7], O_T_EE_c[16], O_dP_EE_c[6],
//                    elbow_c[2]; uint8 valid_elbow, finished; double tau_J_d[7]; uint8 finished }

inline constexpr int kFciJoints = 7;
inline constexpr std::uint16_t kFciVersion = 10;
inline constexpr std::uint16_t kFciPort = 1337;

enum class FciCommand : std::uint32_t {
  connect = 0,
  move = 1,
  stop_move = 2,
  set_collision_behavior = 3,
  automatic_error_recovery = 10,
  get_robot_model = 11,
};

struct FciHeader {
  std::uint32_t command = 0, id = 0, size = 0;
};
inline constexpr std::size_t kFciHeaderSize = 12;
inline constexpr std::size_t kFciLargest = 4u << 20;  // of a response; the model is the largest

std::vector<std::uint8_t> encode_fci_request(FciCommand command, std::uint32_t id,
                                             std::span<const std::uint8_t> payload);
FciHeader decode_fci_header(std::span<const std::uint8_t, kFciHeaderSize> bytes) noexcept;

std::vector<std::uint8_t> fci_connect(std::uint16_t udp_port);
std::vector<std::uint8_t> fci_torque_move();  // no motion generator, external controller
// Contacts and collisions of joints [Nm] and of the tool, [N] and [Nm].
std::vector<std::uint8_t> fci_collision_behavior(const std::array<double, 7>& torque,
                                                 const std::array<double, 6>& force);

inline constexpr std::uint8_t kFciSuccess = 0, kFciMotionStarted = 1;
std::string fci_move_status(std::uint8_t status);

enum class FciMode : std::uint8_t {
  other = 0,
  idle = 1,
  move = 2,
  guiding = 3,
  reflex = 4,
  user_stopped = 5,
  recovering = 6,
};
const char* name_of(FciMode mode);

struct FciState {
  std::uint64_t message_id = 0;  // counts milliseconds
  ArmStatus arm{kFciJoints};     // utime: 1000 message_id
  FciMode mode = FciMode::other;
  bool external_controller = false;
  std::array<std::uint8_t, 41> errors{}, reflex_reason{};
  double success_rate = 0.0;  // of the last 100 commands
};
inline constexpr std::size_t kFciStateSize = 1377;
// False, and `state` as it was, if the size is another.
bool decode_fci_state(std::span<const std::uint8_t> bytes, FciState* state) noexcept;

inline constexpr std::size_t kFciCommandSize = 371;
void encode_fci_torque(std::uint64_t message_id, const JointVector& torque, bool finished,
                       std::span<std::uint8_t, kFciCommandSize> bytes) noexcept;

// The names of the flags that are set, as libfranka has them, joined by commas; empty: none.
std::string fci_errors(const std::array<std::uint8_t, 41>& flags);
// True if a flag says that something was touched: only a person may go on after it.
bool fci_collision(const std::array<std::uint8_t, 41>& flags) noexcept;

// Throws InputError unless the text is fci://A.B.C.D or fci://A.B.C.D:PORT.
void check_fci_url(const std::string& url);

class FciLink {
 public:
  static constexpr double kPatience = 2.0;  // for the connection and for a response [s]
  // Answers that wait for somebody who asks; more, or one to no request, end the connection: what
  // is kept has a bound. And states that receive() takes at once, however fast they come.
  static constexpr std::size_t kMostWaiting = 8;
  static constexpr int kMostTaken = 1000;

  // Connects and agrees on the version. Throws InputError for another url, std::runtime_error if
  // nobody answers there or speaks another version.
  explicit FciLink(const std::string& url);
  ~FciLink();
  FciLink(const FciLink&) = delete;
  FciLink& operator=(const FciLink&) = delete;

  // Sends a request and waits for its response: the payload, the status first. Throws
  // std::runtime_error if none comes within `patience` or the connection is lost.
  std::vector<std::uint8_t> request(FciCommand command, const std::vector<std::uint8_t>& payload,
                                    double patience = kPatience);
  std::uint32_t post(FciCommand command, const std::vector<std::uint8_t>& payload);
  // Waits for a response to a posted request; none after `patience`.
  std::optional<std::vector<std::uint8_t>> response(std::uint32_t id, double patience);

  // The following do not throw.
  // Waits at most `seconds` for a state, then takes what has arrived: `state` becomes the newest.
  // Returns the number of states taken.
  int receive(double seconds, FciState* state) noexcept;
  // The next state, which need not be the newest.
  bool receive_next(double seconds, FciState* state) noexcept;
  bool send(std::uint64_t message_id, const JointVector& torque, bool finished) noexcept;
  bool connected() const noexcept { return tcp_ >= 0; }

 private:
  void read_responses(double patience, std::uint32_t id);
  void close_all() noexcept;

  std::string url_;
  std::uint32_t host_ = 0;  // as in_addr has it
  int tcp_ = -1, udp_ = -1;
  bool peer_known_ = false;
  std::uint32_t next_id_ = 0;
  std::vector<std::uint8_t> received_;
  // By id, in the order of arrival: Move has two.
  std::multimap<std::uint32_t, std::vector<std::uint8_t>> responses_;
};

}  // namespace impedraw
