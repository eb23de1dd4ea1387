// A client of an LCM broker over TCP: LCM's tcpq transport, and never its default, multicast.
//
// All numbers are 32-bit and big-endian. The client sends kHello and a version, the broker answers
// with a magic number and a version of its own. Then each side sends frames:
//   1, size, channel, size, bytes    a message
//   2, size, pattern                 a subscription, from the client: a regular expression that a
//                                    channel's whole name must match
//
// liblcm is not used (docs/decisions/0031): it prints what goes wrong to stderr, connects again by
// itself, blocks on half a message and allocates memory for each one. Nothing here does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace impedraw {

class LcmLink {
 public:
  static constexpr double kPatience = 1.0;        // for the connection and the broker's answer [s]
  static constexpr double kSendPatience = 0.1;    // for a broker that reads too slowly [s]
  static constexpr std::size_t kLargest = 65536;  // bytes of a frame; a longer one ends it

  // Called from handle(). The bytes live until it returns.
  using Handler = std::function<void(std::span<const std::uint8_t>)>;

  // url: tcpq://A.B.C.D:PORT. Throws InputError for another one, std::runtime_error if no broker
  // answers there.
  explicit LcmLink(const std::string& url);
  ~LcmLink();
  LcmLink(const LcmLink&) = delete;
  LcmLink& operator=(const LcmLink&) = delete;

  // channel: letters, digits and underscores. Call before the first wait().
  void subscribe(const std::string& channel, Handler handler);

  // The following do not throw and allocate nothing. False once the connection is lost; it is never
  // made again.
  bool connected() const noexcept { return socket_ >= 0; }
  // Waits for a whole message, at most `seconds`; true if one may be handled.
  bool wait(double seconds) noexcept;
  // Handles one message. Call only after wait() was true.
  bool handle() noexcept;
  bool publish(std::string_view channel, std::span<const std::uint8_t> bytes) noexcept;

 private:
  struct Subscription {
    std::string channel;
    Handler handler;
  };
  struct Frame {
    std::string_view channel;
    std::span<const std::uint8_t> bytes;
    std::size_t size = 0;  // of all of it; 0: not there yet
  };
  Frame next_frame() noexcept;
  void receive() noexcept;
  bool send(std::span<const std::uint8_t> bytes) noexcept;
  void lose() noexcept;

  int socket_ = -1;
  std::vector<std::uint8_t> received_;  // kLargest bytes, of which begin_ to end_ are unread
  std::size_t begin_ = 0, end_ = 0;
  std::vector<std::uint8_t> outgoing_;
  std::vector<Subscription> subscriptions_;
};

// Throws InputError unless the text is tcpq://A.B.C.D:PORT.
void check_lcm_url(const std::string& url);

}  // namespace impedraw
