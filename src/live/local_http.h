// What servers of pages on 127.0.0.1 have in common, in Boost.Beast's terms.
#pragma once

#include <string>
#include <utility>

#include <fmt/format.h>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include "impedraw/common/errors.h"

namespace impedraw {

// Listens on 127.0.0.1 and returns the port. port: 0: a free one. Throws InputError if it cannot be
// had.
inline int listen_locally(boost::asio::ip::tcp::acceptor* acceptor, int port) {
  namespace asio = boost::asio;
  boost::beast::error_code error;
  const asio::ip::tcp::endpoint here(asio::ip::address_v4::loopback(),
                                     static_cast<unsigned short>(port));
  acceptor->open(here.protocol(), error);
  if (!error) acceptor->set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor->bind(here, error);
  if (!error) acceptor->listen(16, error);
  if (error)
    throw InputError(
        fmt::format("--port {}: cannot be listened to on 127.0.0.1: {}", port, error.message()));
  return acceptor->local_endpoint().port();
}

// An answer that no other page may frame, read or keep.
inline boost::beast::http::response<boost::beast::http::string_body> local_answer(
    boost::beast::http::status status, std::string body, const char* type) {
  namespace http = boost::beast::http;
  http::response<http::string_body> answer;
  answer.result(status);
  answer.version(11);
  answer.set(http::field::content_type, type);
  answer.set(http::field::cache_control, "no-store");
  answer.set("Referrer-Policy", "no-referrer");
  answer.set("X-Content-Type-Options", "nosniff");
  answer.set("X-Frame-Options", "DENY");
  answer.set("Cross-Origin-Resource-Policy", "same-origin");
  answer.keep_alive(false);
  answer.body() = std::move(body);
  answer.prepare_payload();
  return answer;
}

}  // namespace impedraw
