#include "impedraw/drivers/lcm_link.h"

#include <arpa/inet.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "impedraw/common/errors.h"

namespace impedraw {

namespace {

constexpr const char* kLibrary = "liblcm.so.1";

sockaddr_in address_of(const std::string& url) {
  constexpr std::string_view scheme = "tcpq://";
  sockaddr_in address{};
  address.sin_family = AF_INET;
  const std::size_t colon = url.rfind(':');
  if (url.starts_with(scheme) && colon != std::string::npos && colon > scheme.size()) {
    const std::string host = url.substr(scheme.size(), colon - scheme.size()),
                      port = url.substr(colon + 1);
    const bool digits =
        !port.empty() && port.size() <= 5 && port.find_first_not_of("0123456789") == port.npos;
    const int number = digits ? std::stoi(port) : 0;
    if (number >= 1 && number <= 65535 &&
        inet_pton(AF_INET, host.c_str(), &address.sin_addr) == 1) {
      address.sin_port = htons(static_cast<std::uint16_t>(number));
      return address;
    }
  }
  throw InputError(fmt::format(
      "arm.url is '{}'; valid is tcpq://A.B.C.D:PORT, as in tcpq://127.0.0.1:7701", url));
}

// liblcm prints why it could not connect. It is told from here, in one line.
class SilentStderr {
 public:
  SilentStderr() : kept_(fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3)) {
    std::fflush(stderr);
    const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (kept_ >= 0 && null >= 0) dup2(null, STDERR_FILENO);
    if (null >= 0) close(null);
  }
  ~SilentStderr() {
    if (kept_ < 0) return;
    dup2(kept_, STDERR_FILENO);
    close(kept_);
  }

 private:
  int kept_;
};

// Whether anybody listens there, within a second: liblcm's own try has no limit.
void require_listener(const std::string& url, const sockaddr_in& address) {
  const int probe = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  int error = probe < 0 ? errno : 0;
  if (probe >= 0) {
    if (connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      error = errno;
    if (error == EINPROGRESS) {
      pollfd waiting{probe, POLLOUT, 0};
      socklen_t size = sizeof error;
      if (poll(&waiting, 1, 1000) != 1)
        error = ETIMEDOUT;
      else
        getsockopt(probe, SOL_SOCKET, SO_ERROR, &error, &size);
    }
    close(probe);
  }
  if (error != 0)
    throw std::runtime_error(
        fmt::format("arm.url {}: no LCM broker answers ({})", url, std::strerror(error)));
}

}  // namespace

void check_lcm_url(const std::string& url) { address_of(url); }

// The part of lcm/lcm.h that is used, as liblcm.so.1 has it. Opaque types are void.
struct LcmLink::Library {
  struct Received {
    void* data;
    std::uint32_t size;
    std::int64_t arrival;
    void* lcm;
  };
  using Callback = void (*)(const Received*, const char* channel, void* user);

  void* (*create)(const char* url);
  void (*destroy)(void*);
  int (*fileno)(void*);
  int (*handle)(void*);
  int (*publish)(void*, const char* channel, const void* data, unsigned size);
  void* (*subscribe)(void*, const char* channel, Callback, void* user);

  Library() {
    void* library = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
    if (!library)
      throw std::runtime_error(fmt::format(
          "arms over LCM need {}, which is not installed: apt-get install liblcm1, or call it as "
          "./impedraw, which installs it",
          kLibrary));
    const auto find = [&](const char* name, auto* to) {
      *to = reinterpret_cast<std::remove_pointer_t<decltype(to)>>(dlsym(library, name));
      if (!*to) throw std::runtime_error(fmt::format("{} has no function {}", kLibrary, name));
    };
    find("lcm_create", &create);
    find("lcm_destroy", &destroy);
    find("lcm_get_fileno", &fileno);
    find("lcm_handle", &handle);
    find("lcm_publish", &publish);
    find("lcm_subscribe", &subscribe);
  }
};

struct LcmLink::Subscription {
  Handler handler;
  static void receive(const Library::Received* message, const char*, void* user) {
    static_cast<Subscription*>(user)->handler(
        {static_cast<const std::uint8_t*>(message->data), message->size});
  }
};

struct LcmLink::State {
  Library library;
  void* lcm = nullptr;
  std::vector<std::unique_ptr<Subscription>> subscriptions;
  bool lost = false;

  // The broker has closed or reset the connection.
  bool peer_left() const noexcept {
    pollfd peer{library.fileno(lcm), POLLRDHUP, 0};
    return poll(&peer, 1, 0) == 1;
  }

  ~State() {
    if (!lcm) return;
    const int socket = library.fileno(lcm);
    // lcm_destroy() takes back the subscriptions, for which it would connect again after a loss:
    // then the handle is left as it is.
    lost = lost || socket < 0 || peer_left();
    if (!lost)
      library.destroy(lcm);
    else if (socket >= 0)
      close(socket);
  }
};

LcmLink::LcmLink(const std::string& url) {
  const sockaddr_in address = address_of(url);
  state_ = std::make_unique<State>();
  require_listener(url, address);
  {
    const SilentStderr silent;
    state_->lcm = state_->library.create(url.c_str());
  }
  if (!state_->lcm || state_->library.fileno(state_->lcm) < 0)
    throw std::runtime_error(fmt::format("arm.url {}: what listens there is no LCM broker", url));
  const int socket = state_->library.fileno(state_->lcm), on = 1;
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  const timeval patience{0, static_cast<suseconds_t>(1e6 * kSocketPatience)};
  setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
}

LcmLink::~LcmLink() = default;

void LcmLink::subscribe(const std::string& channel, Handler handler) {
  state_->subscriptions.push_back(std::make_unique<Subscription>(Subscription{std::move(handler)}));
  state_->library.subscribe(state_->lcm, channel.c_str(), Subscription::receive,
                            state_->subscriptions.back().get());
}

bool LcmLink::connected() const noexcept {
  return !state_->lost && state_->library.fileno(state_->lcm) >= 0;
}

bool LcmLink::wait(double seconds) noexcept {
  if (!connected()) return false;
  pollfd waiting{state_->library.fileno(state_->lcm), POLLIN, 0};
  const auto whole = static_cast<time_t>(std::max(0.0, seconds));
  const timespec limit{whole, static_cast<long>(1e9 * (std::max(0.0, seconds) - whole))};
  return ppoll(&waiting, 1, &limit, nullptr) == 1;
}

bool LcmLink::handle() noexcept {
  if (!connected()) return false;
  // Of a connection that broke, liblcm would tell on stderr.
  if (state_->peer_left() || state_->library.handle(state_->lcm) != 0) state_->lost = true;
  return connected();
}

bool LcmLink::publish(const char* channel, std::span<const std::uint8_t> bytes) noexcept {
  if (!connected()) return false;
  if (state_->peer_left() || state_->library.publish(state_->lcm, channel, bytes.data(),
                                                     static_cast<unsigned>(bytes.size())) != 0)
    state_->lost = true;
  return connected();
}

}  // namespace impedraw
