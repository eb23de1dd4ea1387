// The listening socket of a made-up arm, on a free port of the loopback.
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

namespace impedraw {

class LoopbackServer {
 public:
  LoopbackServer() : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    bind(socket_, reinterpret_cast<sockaddr*>(&address), size);
    listen(socket_, 4);
    getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
    address_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  }
  ~LoopbackServer() { close(socket_); }
  LoopbackServer(const LoopbackServer&) = delete;
  LoopbackServer& operator=(const LoopbackServer&) = delete;

  const std::string& address() const { return address_; }         // IP:PORT
  int take() const { return accept(socket_, nullptr, nullptr); }  // < 0 once it was refused
  void refuse() const { shutdown(socket_, SHUT_RDWR); }

 private:
  int socket_;
  std::string address_;
};

}  // namespace impedraw
