// A viewer of bare sockets, which can also do what a browser would not.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

namespace impedraw {

struct Frame {
  int opcode = 0;  // RFC 6455: 1 text, 2 binary, 8 close, 9 ping; −1: the connection is gone
  std::string payload;
};

class SocketClient {
 public:
  // receive_buffer: of the kernel [bytes]; 0: as it likes.
  explicit SocketClient(int port, int receive_buffer = 0) {
    fd_ = socket(AF_INET, SOCK_STREAM, 0);
    if (receive_buffer > 0)
      setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = connect(fd_, reinterpret_cast<sockaddr*>(&to), sizeof to) == 0;
  }
  ~SocketClient() { close(fd_); }
  SocketClient(const SocketClient&) = delete;
  SocketClient& operator=(const SocketClient&) = delete;

  void send_bytes(const std::string& bytes) const {
    for (std::size_t at = 0; at < bytes.size();) {
      const ssize_t n = ::send(fd_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
      if (n <= 0) return;
      at += static_cast<std::size_t>(n);
    }
  }

  // The answer to a plain request, up to the end of the connection.
  std::string get(const std::string& target, const std::string& host,
                  const std::string& more_headers = {}) {
    send_bytes("GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" + more_headers + "\r\n");
    std::string all;
    while (receive(std::chrono::seconds(10))) {
    }
    all.swap(received_);
    return all;
  }

  // The status of the answer to a request for a WebSocket; 101: it is one.
  int upgrade(const std::string& target, const std::string& host, const std::string& origin) {
    send_bytes("GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" +
               (origin.empty() ? "" : "Origin: " + origin + "\r\n") +
               "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
               "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n");
    std::size_t end;
    while ((end = received_.find("\r\n\r\n")) == std::string::npos)
      if (!receive(std::chrono::seconds(10))) return 0;
    const int status = std::stoi(received_.substr(9, 3));
    received_.erase(0, end + 4);
    return status;
  }

  // A message of a viewer: masked, as they must be.
  void send_text(const std::string& text) const {
    std::string frame = "\x81";
    if (text.size() < 126) {
      frame += static_cast<char>(0x80 | text.size());
    } else {
      frame += static_cast<char>(0x80 | 127);
      for (int shift = 56; shift >= 0; shift -= 8)
        frame += static_cast<char>((static_cast<std::uint64_t>(text.size()) >> shift) & 0xff);
    }
    send_bytes(frame + std::string(4, '\0') + text);  // a mask of zeros changes nothing
  }

  // The next message; none within `patience`.
  std::optional<Frame> next(std::chrono::milliseconds patience = std::chrono::seconds(10)) {
    const auto end = std::chrono::steady_clock::now() + patience;
    for (;;) {
      if (received_.size() >= 2) {
        std::size_t head = 2;
        std::uint64_t size = static_cast<unsigned char>(received_[1]) & 0x7f;
        if (size >= 126) head = size == 126 ? 4 : 10;
        if (received_.size() >= head) {
          if (head > 2) {
            size = 0;
            for (std::size_t i = 2; i < head; ++i)
              size = size << 8 | static_cast<unsigned char>(received_[i]);
          }
          if (received_.size() >= head + size) {
            Frame frame{received_[0] & 0x0f, received_.substr(head, size)};
            received_.erase(0, head + size);
            if (frame.opcode == 9) {  // a ping is answered
              send_bytes(std::string("\x8a\x80\0\0\0\0", 6));
              continue;
            }
            return frame;
          }
        }
      }
      gone_ = false;
      const auto left =
          std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
      if (!receive(std::max(left, std::chrono::milliseconds(0))))
        return gone_ ? std::optional(Frame{-1, {}}) : std::nullopt;
    }
  }

  bool connected() const { return connected_; }

 private:
  bool receive(std::chrono::milliseconds patience) {
    pollfd wait{fd_, POLLIN, 0};
    if (poll(&wait, 1, static_cast<int>(patience.count())) <= 0) return false;
    char bytes[1 << 16];
    const ssize_t n = recv(fd_, bytes, sizeof bytes, 0);
    gone_ = n <= 0;
    if (n > 0) received_.append(bytes, static_cast<std::size_t>(n));
    return n > 0;
  }

  int fd_ = -1;
  bool connected_ = false, gone_ = false;
  std::string received_;
};

// The rows of a binary message of rows; empty if it is none.
inline std::vector<float> rows_of(const Frame& frame) {
  if (frame.opcode != 2 || frame.payload.size() < 8 || frame.payload[0] != 0) return {};
  std::vector<float> rows((frame.payload.size() - 8) / sizeof(float));
  std::memcpy(rows.data(), frame.payload.data() + 8, rows.size() * sizeof(float));
  return rows;
}

}  // namespace impedraw
