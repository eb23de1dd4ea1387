// Who may ask a server on 127.0.0.1: pages of this machine that know its token.
//
// Any page that a browser shows can send requests here, and some can make a name resolve to
// 127.0.0.1. So the Host must be this server, an Origin its page (RFC 6455, 10.2), and the token,
// 128 random bits, that of the address.
#pragma once

#include <string>
#include <string_view>

namespace impedraw {

class LocalAccess {
 public:
  LocalAccess();  // throws std::runtime_error if the system has no random numbers

  void listens_on(int port) { port_ = port; }
  int port() const { return port_; }
  std::string address() const;  // with the token

  // Why a request is refused; null: it may go on. An origin must be there if `needs_origin`, as for
  // a WebSocket.
  const char* refusal(std::string_view host, std::string_view origin, bool needs_origin,
                      std::string_view token) const;

 private:
  bool is_here(std::string_view host) const;

  std::string token_;
  int port_ = 0;
};

}  // namespace impedraw
