// A server of pages on 127.0.0.1, in Boost.Beast's terms.
//
//   LocalServer ── accepts ──> LocalVisit ── reads a request, checks it (LocalAccess) ──> handler
//
// Whoever lacks the token, the Host or the Origin gets 403, a request that is too long 431 or 413.
// All runs in the thread that runs the io_context.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

namespace impedraw {

// Who may ask a server on 127.0.0.1: pages of this machine that know its token.
//
// Any page that a browser shows can send requests here, and some can make a name resolve to
// 127.0.0.1. So the Host must be this server, an Origin its page (RFC 6455, 10.2), and the token,
// 128 random bits, that of the address.

class LocalAccess {
 public:
  LocalAccess();  // throws std::runtime_error if the system has no random numbers

  void listens_on(int port) { port_ = port; }
  int port() const { return port_; }
  std::string address() const;  // with the token

  // The reason that a request is refused; null: it may go on. An origin must be there if
  // `needs_origin`, as for a WebSocket.
  const char* refusal(std::string_view host, std::string_view origin, bool needs_origin,
                      std::string_view token) const;

 private:
  bool is_here(std::string_view host) const;

  std::string token_;
  int port_ = 0;
};

class LocalVisit;

struct LocalPages {
  std::function<void(LocalVisit&)> handler;  // calls answer() or take()
  std::size_t most_body = 0;                 // of a request [bytes]
  std::chrono::milliseconds request_time{5000};
  LocalAccess access{};
  std::size_t visits = 0;
};

// A connection until its request is answered, or taken over.
class LocalVisit : public std::enable_shared_from_this<LocalVisit> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;
  using Status = boost::beast::http::status;

  LocalVisit(boost::asio::ip::tcp::socket socket, std::shared_ptr<LocalPages> pages);
  ~LocalVisit();

  void read();
  const Request& request() const { return parser_.get(); }
  std::string_view path() const;                              // "/data"
  std::string_view parameter(const std::string& name) const;  // behind the '?'; empty: none
  bool is_upgrade() const;                                    // asks for a WebSocket
  // No other page may frame, read or keep the answer.
  void answer(Status status, std::string body, const char* type = "text/plain");
  boost::beast::tcp_stream take();  // the connection, without a time limit

 private:
  boost::beast::tcp_stream stream_;
  std::shared_ptr<LocalPages> pages_;
  boost::beast::flat_buffer buffer_;
  boost::beast::http::request_parser<boost::beast::http::string_body> parser_;
  boost::beast::http::response<boost::beast::http::string_body> response_;
};

class LocalServer {
 public:
  // Listens. port: 0: a free one. Throws InputError if it cannot be had.
  LocalServer(boost::asio::io_context& io, int port, LocalPages pages);

  const LocalAccess& access() const { return pages_->access; }
  void accept();  // answers from now on

 private:
  std::shared_ptr<LocalPages> pages_;  // visits outlive the server
  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer retry_;
};

}  // namespace impedraw
