#include "impedraw/drivers/fci_link.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
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

}  // namespace impedraw
