#include "impedraw/live/page_server.h"

#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/live/local_http.h"

namespace impedraw {

class PageServer::Impl {
 public:
  explicit Impl(int port)
      : server_(io_, port, {[this](LocalVisit& visit) { handle(visit); }, kMostQuestion}) {
    server_.accept();
  }

  std::string address() const { return server_.access().address(); }

  void run(const PageServerContent& content, const std::function<bool()>& ended) {
    content_ = content;
    while (!ended()) io_.run_for(std::chrono::milliseconds(100));
  }

 private:
  static constexpr std::size_t kMostQuestion = 65536;  // [bytes]
  static constexpr char kJson[] = "application/json";

  void handle(LocalVisit& visit) {
    namespace http = boost::beast::http;
    const http::verb method = visit.request().method();
    const std::string path(visit.path());
    if (method == http::verb::get && path == "/")
      return visit.answer(http::status::ok, content_.page, "text/html; charset=utf-8");
    if (method == http::verb::get && path == "/data")
      return visit.answer(http::status::ok, content_.data, kJson);
    if (method != http::verb::post || path.size() < 2)
      return visit.answer(http::status::not_found, "nothing here\n");
    try {
      visit.answer(http::status::ok, content_.answer(path.substr(1), visit.request().body()),
                   kJson);
    } catch (const InputError& error) {
      visit.answer(http::status::bad_request, nlohmann::json{{"error", error.what()}}.dump(),
                   kJson);
    }
  }

  PageServerContent content_;
  boost::asio::io_context io_{1};
  LocalServer server_;
};

PageServer::PageServer(int port) : impl_(std::make_unique<Impl>(port)) {}
PageServer::~PageServer() = default;
std::string PageServer::address() const { return impl_->address(); }

void PageServer::run(const PageServerContent& content, const std::function<bool()>& ended) {
  impl_->run(content, ended);
}

}  // namespace impedraw
