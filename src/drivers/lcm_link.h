// A connection to an LCM broker over TCP (liblcm's tcpq). liblcm is loaded on connect(), so that
// the program needs it only where it drives such an arm. Never LCM's default, multicast.
//
// What liblcm 1.3 does otherwise, and this does not:
//   - waiting on a lost connection aborts the process: the descriptor is checked before each wait;
//   - a publish, a wait and even lcm_destroy() reconnect by themselves: after a loss nothing of it
//     is called again;
//   - it writes a message in five pieces: TCP_NODELAY is set, or each one costs 40 ms;
//   - half a message blocks for ever: the socket gets a time limit of kSocketPatience;
//   - it tells of trouble on stderr: kept silent while connecting, and a lost peer is noticed
//     before a publish.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace impedraw {

class LcmLink {
 public:
  static constexpr double kSocketPatience = 0.1;  // [s]

  // Called from handle(). The bytes live until it returns.
  using Handler = std::function<void(std::span<const std::uint8_t>)>;

  // url: tcpq://A.B.C.D:PORT. Throws InputError for another one, std::runtime_error if liblcm is
  // not installed or no broker listens.
  explicit LcmLink(const std::string& url);
  ~LcmLink();
  LcmLink(const LcmLink&) = delete;
  LcmLink& operator=(const LcmLink&) = delete;

  void subscribe(const std::string& channel, Handler handler);

  // The following do not throw. False once the connection is lost.
  bool connected() const noexcept;
  // Waits for a message, at most `seconds`; true if one may be handled.
  bool wait(double seconds) noexcept;
  // Handles one message. Call only after wait() was true.
  bool handle() noexcept;
  bool publish(const char* channel, std::span<const std::uint8_t> bytes) noexcept;

 private:
  struct Library;
  struct Subscription;
  struct State;
  std::unique_ptr<State> state_;
};

// Throws InputError unless the text is tcpq://A.B.C.D:PORT.
void check_lcm_url(const std::string& url);

}  // namespace impedraw
