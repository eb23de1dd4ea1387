#include "impedraw/live/local_access.h"

#include <sys/random.h>

#include <array>
#include <stdexcept>

#include <fmt/format.h>

namespace impedraw {

namespace {

// Takes as long wherever they differ.
bool same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned char differ = 0;
  for (std::size_t i = 0; i < a.size(); ++i) differ |= static_cast<unsigned char>(a[i] ^ b[i]);
  return differ == 0;
}

}  // namespace

LocalAccess::LocalAccess() {
  std::array<unsigned char, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw std::runtime_error("a page's token cannot be made: no random numbers");
  for (const unsigned char b : bytes) token_ += fmt::format("{:02x}", b);
}

std::string LocalAccess::address() const {
  return fmt::format("http://127.0.0.1:{}/?token={}", port_, token_);
}

bool LocalAccess::is_here(std::string_view host) const {
  return host == fmt::format("127.0.0.1:{}", port_) || host == fmt::format("localhost:{}", port_);
}

const char* LocalAccess::refusal(std::string_view host, std::string_view origin, bool needs_origin,
                                 std::string_view token) const {
  constexpr std::string_view kScheme = "http://";
  if (!is_here(host)) return "not the host of this server\n";
  if ((needs_origin || !origin.empty()) &&
      !(origin.starts_with(kScheme) && is_here(origin.substr(kScheme.size()))))
    return "not from this server's page\n";
  if (!same(token, token_)) return "the address lacks the token\n";
  return nullptr;
}

}  // namespace impedraw
