#include "impedraw/drivers/lcm_link.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/drivers/tcp.h"
#include "impedraw/terminal/clock.h"

namespace impedraw {
namespace {

constexpr std::uint32_t kHello = 0x287617fb, kAnswer = 0x287617fa, kVersion = 0x0100;
constexpr std::uint32_t kMessage = 1, kSubscription = 2;
constexpr std::size_t kNumber = 4;  // bytes

void put_number(std::vector<std::uint8_t>* to, std::size_t value) {
  to->resize(to->size() + kNumber);
  std::uint8_t* at = to->data() + to->size() - kNumber;
  put_big_endian(value, kNumber, &at);
}

template <typename Bytes>
void put_sized(std::vector<std::uint8_t>* to, const Bytes& bytes) {
  put_number(to, bytes.size());
  to->insert(to->end(), bytes.begin(), bytes.end());
}

std::size_t number_at(const std::uint8_t* bytes) noexcept {
  return get_big_endian(kNumber, &bytes);
}

sockaddr_in address_of(const std::string& url) {
  constexpr std::string_view scheme = "tcpq://";
  if (url.starts_with(scheme))
    if (const auto address = ipv4_address(url.substr(scheme.size()))) return *address;
  throw InputError(fmt::format(
      "arm.url is '{}'; valid is tcpq://A.B.C.D:PORT, as in tcpq://127.0.0.1:7701", url));
}

}  // namespace

void check_lcm_url(const std::string& url) { address_of(url); }

LcmLink::LcmLink(const std::string& url) {
  const sockaddr_in address = address_of(url);
  received_.resize(kLargest);
  outgoing_.reserve(kLargest);
  int error = 0;
  socket_ = connect_tcp(address, kPatience, &error);
  if (socket_ < 0)
    throw std::runtime_error(
        fmt::format("arm.url {}: no LCM broker answers ({})", url, std::strerror(error)));
  put_number(&outgoing_, kHello);
  put_number(&outgoing_, kVersion);
  send(outgoing_);
  const auto begin = Clock::now();
  while (connected() && end_ < 2 * kNumber && readable(socket_, kPatience - seconds_since(begin)))
    receive();
  if (!connected() || end_ < 2 * kNumber || number_at(received_.data()) != kAnswer) {
    lose();
    throw std::runtime_error(fmt::format("arm.url {}: what listens there is no LCM broker", url));
  }
  begin_ = 2 * kNumber;
}

LcmLink::~LcmLink() { lose(); }

void LcmLink::lose() noexcept {
  if (socket_ >= 0) close(socket_);
  socket_ = -1;
}

void LcmLink::subscribe(const std::string& channel, Handler handler) {
  outgoing_.clear();
  put_number(&outgoing_, kSubscription);
  put_sized(&outgoing_, channel);
  subscriptions_.push_back({channel, std::move(handler)});
  send(outgoing_);
}

void LcmLink::receive() noexcept {
  // Unread bytes move to the front once the end is reached: a frame always fits.
  if (end_ == received_.size()) {
    std::copy(received_.begin() + static_cast<std::ptrdiff_t>(begin_), received_.end(),
              received_.begin());
    end_ -= begin_;
    begin_ = 0;
  }
  const ssize_t n = recv(socket_, received_.data() + end_, received_.size() - end_, 0);
  if (n > 0)
    end_ += static_cast<std::size_t>(n);
  else if (n == 0 || (errno != EAGAIN && errno != EINTR))
    lose();
}

LcmLink::Frame LcmLink::next_frame() noexcept {
  const std::uint8_t* at = received_.data() + begin_;
  const std::size_t there = end_ - begin_;
  // Takes the size that stands at `size` and what follows it. False if it has not all come.
  std::size_t size = 2 * kNumber;
  const auto follows = [&](std::size_t* length) {
    if (there < size) return false;
    *length = number_at(at + size - kNumber);
    if (size + *length > kLargest || number_at(at) != kMessage) {
      lose();
      return false;
    }
    size += *length;
    return there >= size;
  };
  std::size_t name = 0, length = 0;
  if (!follows(&name)) return {};
  const std::string_view channel(reinterpret_cast<const char*>(at + size - name), name);
  size += kNumber;
  if (!follows(&length)) return {};
  return {channel, {at + size - length, length}, size};
}

bool LcmLink::wait(double seconds) noexcept {
  const auto begin = Clock::now();
  while (connected()) {
    if (next_frame().size > 0) return true;
    if (!connected() || !readable(socket_, seconds - seconds_since(begin))) return false;
    receive();
  }
  return false;
}

bool LcmLink::handle() noexcept {
  const Frame frame = next_frame();
  for (const Subscription& subscription : subscriptions_)
    if (subscription.channel == frame.channel) subscription.handler(frame.bytes);
  begin_ += frame.size;
  if (begin_ == end_) begin_ = end_ = 0;
  return connected();
}

bool LcmLink::publish(std::string_view channel, std::span<const std::uint8_t> bytes) noexcept {
  if (3 * kNumber + channel.size() + bytes.size() > kLargest) return false;
  outgoing_.clear();
  put_number(&outgoing_, kMessage);
  put_sized(&outgoing_, channel);
  put_sized(&outgoing_, bytes);
  return send(outgoing_);
}

bool LcmLink::send(std::span<const std::uint8_t> bytes) noexcept {
  const auto begin = Clock::now();
  while (connected() && !bytes.empty()) {
    const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n > 0)
      bytes = bytes.subspan(static_cast<std::size_t>(n));
    else if ((errno != EAGAIN && errno != EINTR) ||
             !writable(socket_, kSendPatience - seconds_since(begin)))
      lose();
  }
  return connected();
}

}  // namespace impedraw
