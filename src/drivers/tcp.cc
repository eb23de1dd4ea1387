#include "impedraw/drivers/tcp.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>

namespace impedraw {
namespace {

bool ready(int descriptor, short event, double seconds) noexcept {
  pollfd waiting{descriptor, event, 0};
  const double left = std::max(0.0, seconds), whole = std::floor(left);
  const timespec limit{static_cast<time_t>(whole), static_cast<long>(1e9 * (left - whole))};
  return ppoll(&waiting, 1, &limit, nullptr) == 1;
}

}  // namespace

std::optional<sockaddr_in> ipv4_address(const std::string& text, int usual_port) {
  const std::size_t colon = text.find(':');
  int number = usual_port;
  if (colon != std::string::npos) {
    const std::string port = text.substr(colon + 1);
    if (port.empty() || port.size() > 5 || port.find_first_not_of("0123456789") != port.npos)
      return std::nullopt;
    number = std::stoi(port);
  }
  sockaddr_in address{};
  address.sin_family = AF_INET;
  if (number < 1 || number > 65535 ||
      inet_pton(AF_INET, text.substr(0, colon).c_str(), &address.sin_addr) != 1)
    return std::nullopt;
  address.sin_port = htons(static_cast<std::uint16_t>(number));
  return address;
}

int connect_tcp(const sockaddr_in& address, double patience, int* error) noexcept {
  const int descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  *error = descriptor < 0 ? errno : 0;
  if (descriptor < 0) return -1;
  if (connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    *error = errno;
  if (*error == EINPROGRESS) {
    socklen_t size = sizeof *error;
    if (!writable(descriptor, patience))
      *error = ETIMEDOUT;
    else
      getsockopt(descriptor, SOL_SOCKET, SO_ERROR, error, &size);
  }
  if (*error != 0) {
    close(descriptor);
    return -1;
  }
  const int on = 1;
  setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  return descriptor;
}

bool readable(int descriptor, double seconds) noexcept {
  return ready(descriptor, POLLIN, seconds);
}

bool writable(int descriptor, double seconds) noexcept {
  return ready(descriptor, POLLOUT, seconds);
}

}  // namespace impedraw
