// A connection to a Franka arm: TCP for requests, UDP for states and torques (fci_messages.h).
// Single-threaded: responses are read when somebody waits for one.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/drivers/fci_messages.h"

namespace impedraw {

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
