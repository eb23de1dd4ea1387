#include "impedraw/live/local_http.h"

#include <array>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <sys/random.h>
#include <boost/beast/websocket/rfc6455.hpp>

#include "impedraw/common/errors.h"

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

namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using Error = boost::beast::error_code;

constexpr std::size_t kMostHeader = 8192;  // [bytes]
constexpr std::size_t kMostVisits = 24;    // at a time

std::string_view view_of(boost::beast::string_view text) { return {text.data(), text.size()}; }

}  // namespace

LocalVisit::LocalVisit(asio::ip::tcp::socket socket, std::shared_ptr<LocalPages> pages)
    : stream_(std::move(socket)),
      pages_(std::move(pages)),
      buffer_(2 * kMostHeader + pages_->most_body) {
  ++pages_->visits;
}

LocalVisit::~LocalVisit() { --pages_->visits; }

void LocalVisit::read() {
  parser_.header_limit(kMostHeader);
  parser_.body_limit(pages_->most_body);
  stream_.expires_after(pages_->request_time);
  http::async_read(
      stream_, buffer_, parser_, [self = shared_from_this()](Error error, std::size_t) {
        if (error == http::error::header_limit)
          return self->answer(Status::request_header_fields_too_large, "too long\n");
        if (error == http::error::body_limit)
          return self->answer(Status::payload_too_large, "too long\n");
        if (error) return;
        const Request& request = self->request();
        const char* refusal = self->pages_->access.refusal(
            view_of(request[http::field::host]), view_of(request[http::field::origin]),
            self->is_upgrade(), self->parameter("token"));
        refusal ? self->answer(Status::forbidden, refusal) : self->pages_->handler(*self);
      });
}

std::string_view LocalVisit::path() const {
  const std::string_view target = view_of(request().target());
  return target.substr(0, target.find('?'));
}

std::string_view LocalVisit::parameter(const std::string& name) const {
  const std::string_view target = view_of(request().target());
  std::size_t at = target.find("?" + name + "=");
  if (at == target.npos) at = target.find("&" + name + "=");
  if (at == target.npos) return {};
  const std::string_view value = target.substr(at + name.size() + 2);
  return value.substr(0, value.find('&'));
}

bool LocalVisit::is_upgrade() const { return boost::beast::websocket::is_upgrade(request()); }

void LocalVisit::answer(Status status, std::string body, const char* type) {
  response_.result(status);
  response_.version(11);
  response_.set(http::field::content_type, type);
  response_.set(http::field::cache_control, "no-store");
  response_.set("Referrer-Policy", "no-referrer");
  response_.set("X-Content-Type-Options", "nosniff");
  response_.set("X-Frame-Options", "DENY");
  response_.set("Cross-Origin-Resource-Policy", "same-origin");
  response_.keep_alive(false);
  response_.body() = std::move(body);
  response_.prepare_payload();
  stream_.expires_after(pages_->request_time);
  http::async_write(stream_, response_, [self = shared_from_this()](Error, std::size_t) {
    Error ignored;
    self->stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
  });
}

boost::beast::tcp_stream LocalVisit::take() {
  stream_.expires_never();
  return std::move(stream_);
}

LocalServer::LocalServer(asio::io_context& io, int port, LocalPages pages)
    : pages_(std::make_shared<LocalPages>(std::move(pages))), acceptor_(io), retry_(io) {
  Error error;
  const asio::ip::tcp::endpoint here(asio::ip::address_v4::loopback(),
                                     static_cast<unsigned short>(port));
  acceptor_.open(here.protocol(), error);
  if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor_.bind(here, error);
  if (!error) acceptor_.listen(16, error);
  if (error)
    throw InputError(
        fmt::format("--port {}: cannot be listened to on 127.0.0.1: {}", port, error.message()));
  pages_->access.listens_on(acceptor_.local_endpoint().port());
}

void LocalServer::accept() {
  acceptor_.async_accept([this](Error error, asio::ip::tcp::socket socket) {
    if (error) {
      // Too many files are open, say: later.
      retry_.expires_after(std::chrono::milliseconds(200));
      retry_.async_wait([this](Error stopped) {
        if (!stopped) accept();
      });
      return;
    }
    socket.set_option(asio::ip::tcp::no_delay(true), error);
    if (pages_->visits < kMostVisits)
      std::make_shared<LocalVisit>(std::move(socket), pages_)->read();
    accept();
  });
}

}  // namespace impedraw
