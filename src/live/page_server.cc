#include "impedraw/live/page_server.h"

#include <chrono>
#include <optional>
#include <string_view>
#include <utility>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/live/local_access.h"
#include "impedraw/live/local_http.h"

namespace impedraw {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using Error = beast::error_code;
using std::chrono::milliseconds;

constexpr std::size_t kMostHeader = 8192, kMostQuestion = 65536;  // [bytes]
constexpr std::size_t kMostVisits = 24;                           // at a time
constexpr milliseconds kRequestTime{5000};

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

struct Shared {
  LocalAccess access;
  PageServerContent content;
  std::size_t visits = 0;
};

// One request and its answer.
class Visit : public std::enable_shared_from_this<Visit> {
 public:
  Visit(tcp::socket socket, Shared& shared) : stream_(std::move(socket)), shared_(shared) {
    ++shared_.visits;
  }
  ~Visit() { --shared_.visits; }

  void read() {
    parser_.header_limit(kMostHeader);
    parser_.body_limit(kMostQuestion);
    stream_.expires_after(kRequestTime);
    http::async_read(stream_, buffer_, parser_,
                     [self = shared_from_this()](Error error, std::size_t) {
                       if (error == http::error::header_limit || error == http::error::body_limit)
                         return self->answer(http::status::payload_too_large, "too long\n");
                       if (!error) self->handle();
                     });
  }

 private:
  void handle() {
    const auto& request = parser_.get();
    const std::string_view target = view_of(request.target());
    const std::size_t query = target.find("?token=");
    const std::string_view path = target.substr(0, query);
    const std::string_view token = query == target.npos ? "" : target.substr(query + 7);
    if (const char* refusal =
            shared_.access.refusal(view_of(request[http::field::host]),
                                   view_of(request[http::field::origin]), false, token))
      return answer(http::status::forbidden, refusal);
    if (request.method() == http::verb::get && path == "/")
      return answer(http::status::ok, shared_.content.page, "text/html; charset=utf-8");
    if (request.method() == http::verb::get && path == "/data")
      return answer(http::status::ok, shared_.content.data, kJson);
    if (request.method() != http::verb::post || path.size() < 2)
      return answer(http::status::not_found, "nothing here\n");
    try {
      answer(http::status::ok, shared_.content.answer(std::string(path.substr(1)), request.body()),
             kJson);
    } catch (const InputError& error) {
      answer(http::status::bad_request, nlohmann::json{{"error", error.what()}}.dump(), kJson);
    }
  }

  void answer(http::status status, std::string body, const char* type = "text/plain") {
    response_ = local_answer(status, std::move(body), type);
    stream_.expires_after(kRequestTime);
    http::async_write(stream_, response_, [self = shared_from_this()](Error, std::size_t) {
      Error ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  static constexpr char kJson[] = "application/json";
  beast::tcp_stream stream_;
  Shared& shared_;
  beast::flat_buffer buffer_{kMostHeader + kMostQuestion};
  http::request_parser<http::string_body> parser_;
  http::response<http::string_body> response_;
};

}  // namespace

class PageServer::Impl {
 public:
  explicit Impl(int port) {
    shared.access.listens_on(listen_locally(&acceptor_, port));
    accept();
  }

  void run(const std::function<bool()>& ended) {
    while (!ended()) io_.run_for(milliseconds(100));
  }

  Shared shared;  // outlives what io_ still holds

 private:
  void accept() {
    acceptor_.async_accept([this](Error error, tcp::socket socket) {
      if (error) {
        // Too many files are open, say: later.
        retry_.expires_after(milliseconds(200));
        retry_.async_wait([this](Error stopped) {
          if (!stopped) accept();
        });
        return;
      }
      socket.set_option(tcp::no_delay(true), error);
      if (shared.visits < kMostVisits) std::make_shared<Visit>(std::move(socket), shared)->read();
      accept();
    });
  }

  asio::io_context io_{1};
  tcp::acceptor acceptor_{io_};
  asio::steady_timer retry_{io_};
};

PageServer::PageServer(int port) : impl_(std::make_unique<Impl>(port)) {}
PageServer::~PageServer() = default;
std::string PageServer::address() const { return impl_->shared.access.address(); }

void PageServer::run(const PageServerContent& content, const std::function<bool()>& ended) {
  impl_->shared.content = content;
  impl_->run(ended);
}

}  // namespace impedraw
