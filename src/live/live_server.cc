#include "impedraw/live/live_server.h"

#include <pthread.h>

#include <algorithm>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "impedraw/live/local_http.h"

namespace impedraw {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Error = beast::error_code;

constexpr std::size_t kMostMessage = 64;  // of a viewer [bytes]
constexpr std::size_t kRowsAMessage = 512;

void append_number(std::uint32_t number, std::string* out) {
  for (int shift = 0; shift < 32; shift += 8) *out += static_cast<char>((number >> shift) & 0xff);
}

class Viewer;

// The state of the server's thread that the run's thread may read.
struct Shared {
  explicit Shared(const LiveSettings& given) : settings(given), ring(given.row_width, 8192) {}

  const LiveSettings settings;
  RowRing ring;
  std::string page;
  std::atomic<bool> paused = false, stopped = false, emergency = false;
  std::atomic<std::size_t> viewer_count = 0;

  // For the server's thread alone.
  std::vector<float> kept;  // rows, oldest first
  bool ending = false;
  std::shared_ptr<const std::string> report;
  std::vector<std::shared_ptr<Viewer>> viewers;
  int changes = 0;  // of what status() tells

  std::size_t rows() const { return kept.size() / settings.row_width; }
  std::string status() const {
    const char* state = report ? "finished" : ending ? "ending" : paused ? "paused" : "running";
    return fmt::format(R"({{"state": "{}", "stopping": {}}})", state,
                       stopped.load() || emergency.load());
  }
  void notify();
  void obey(std::string_view command);
  void take_rows();
};

class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  Viewer(beast::tcp_stream stream, Shared& shared, double since)
      : ws_(std::move(stream)), shared_(shared), since_(since) {}

  void accept(const LocalVisit::Request& request) {
    ws_.read_message_max(kMostMessage);
    websocket::stream_base::timeout limits{};
    limits.handshake_timeout = shared_.settings.request_time;
    limits.idle_timeout = shared_.settings.silence;
    limits.keep_alive_pings = true;
    ws_.set_option(limits);
    ws_.auto_fragment(false);
    ws_.async_accept(request, [self = shared_from_this()](Error error) {
      if (error) return self->leave();
      self->skip_known();
      self->open_ = true;
      self->send();
      self->read();
    });
  }

  // Sends what the viewer lacks, one message at a time.
  void send() {
    if (!open_ || writing_) return;
    const std::size_t width = shared_.settings.row_width, rows = shared_.rows();
    if (told_ != shared_.changes) {
      told_ = shared_.changes;
      message_ = shared_.status();
      ws_.text(true);
      return write(asio::buffer(message_));
    }
    if (rows_sent_ < rows) {
      const std::size_t behind = rows - rows_sent_;
      // One that has been up to date and fell behind is not sent all that it missed.
      const std::size_t stride =
          up_to_date_ ? (behind + kRowsAMessage - 1) / kRowsAMessage : std::size_t{1};
      const std::size_t count = std::min(kRowsAMessage, (behind + stride - 1) / stride);
      message_.clear();
      append_number(0, &message_);
      append_number(static_cast<std::uint32_t>(count), &message_);
      for (std::size_t i = 0; i < count; ++i)
        message_.append(
            reinterpret_cast<const char*>(&shared_.kept[(rows_sent_ + i * stride) * width]),
            sizeof(float) * width);
      rows_sent_ += (count - 1) * stride + 1;  // the last row is never left out
      ws_.binary(true);
      return write(asio::buffer(message_));
    }
    up_to_date_ = true;
    if (shared_.report && !report_sent_) {
      report_sent_ = true;
      report_ = shared_.report;
      ws_.binary(true);
      return write(asio::buffer(*report_));
    }
  }

  // Every second row of `rows` is gone, the newest is not.
  void halve(std::size_t rows) { rows_sent_ = (rows_sent_ + rows % 2) / 2; }
  bool done() const { return !open_ || (report_sent_ && !writing_); }

  void close() {
    open_ = false;
    Error ignored;
    beast::get_lowest_layer(ws_).socket().shutdown(tcp::socket::shutdown_both, ignored);
    beast::get_lowest_layer(ws_).close();
  }

 private:
  // A viewer that was here before has the rows up to `since_`.
  void skip_known() {
    const std::size_t width = shared_.settings.row_width;
    while (rows_sent_ < shared_.rows() && shared_.kept[rows_sent_ * width] <= since_) ++rows_sent_;
  }

  void write(asio::const_buffer bytes) {
    writing_ = true;
    ws_.async_write(bytes, [self = shared_from_this()](Error error, std::size_t) {
      self->writing_ = false;
      if (error) return self->leave();
      self->send();
    });
  }

  void read() {
    ws_.async_read(buffer_, [self = shared_from_this()](Error error, std::size_t) {
      if (error) return self->leave();
      self->shared_.obey(beast::buffers_to_string(self->buffer_.data()));
      self->buffer_.clear();
      self->read();
    });
  }

  void leave() {
    open_ = false;
    const auto at = std::find(shared_.viewers.begin(), shared_.viewers.end(), shared_from_this());
    if (at == shared_.viewers.end()) return;
    shared_.viewers.erase(at);
    shared_.viewer_count = shared_.viewers.size();
  }

  websocket::stream<beast::tcp_stream> ws_;
  Shared& shared_;
  double since_;
  beast::flat_buffer buffer_{kMostMessage + 256};
  std::string message_;
  std::shared_ptr<const std::string> report_;
  std::size_t rows_sent_ = 0;
  int told_ = -1;
  bool open_ = false, writing_ = false, up_to_date_ = false, report_sent_ = false;
};

void Shared::notify() {
  ++changes;
  for (const auto& viewer : std::vector(viewers)) viewer->send();
}

void Shared::obey(std::string_view command) {
  if (ending || report) return;
  if (command == "pause" && !stopped && !emergency) paused = true;
  if (command == "resume") paused = false;
  if (command == "stop") {
    stopped = true;
    paused = false;
  }
  if (command == "emergency") {
    emergency = true;
    paused = false;
  }
  notify();
}

void Shared::take_rows() {
  const std::size_t width = settings.row_width;
  for (auto row = ring.oldest(); !row.empty(); row = ring.oldest()) {
    kept.insert(kept.end(), row.begin(), row.end());
    ring.pop();
    if (rows() < settings.kept_rows) continue;
    for (const auto& viewer : viewers) viewer->halve(rows());
    std::size_t to = 0;
    for (std::size_t from = (rows() + 1) % 2; from < rows(); from += 2, ++to)  // the newest stays
      std::copy_n(&kept[from * width], width, &kept[to * width]);
    kept.resize(to * width);
  }
}

}  // namespace

class LiveServer::Impl {
 public:
  explicit Impl(const LiveSettings& settings)
      : shared_(settings),
        server_(io_, settings.port,
                {[this](LocalVisit& visit) { handle(visit); }, 0, settings.request_time}),
        timer_(io_),
        begin_(std::chrono::steady_clock::now()) {}

  ~Impl() {
    if (!thread_.joinable()) return;
    asio::post(io_, [this] {
      for (const auto& viewer : std::vector(shared_.viewers)) viewer->close();
      io_.stop();
    });
    thread_.join();
    shared_.viewers.clear();
  }

  void serve(std::string page) {
    shared_.page = std::move(page);
    server_.accept();
    tick();
    // Signals are for the run's thread.
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    thread_ = std::thread([this] { io_.run(); });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }

  void ending() {
    asio::post(io_, [this] {
      shared_.ending = true;
      shared_.notify();
    });
  }

  void finish(std::string data, std::chrono::milliseconds patience) {
    if (!thread_.joinable()) return;
    auto report = std::make_shared<std::string>();
    report->reserve(data.size() + 4);
    append_number(1, report.get());
    *report += data;
    asio::post(io_, [this, report] {
      shared_.take_rows();
      shared_.report = report;
      shared_.notify();
    });
    std::unique_lock lock(mutex_);
    all_have_it_.wait_for(lock, patience, [this] { return delivered_; });
  }

  Shared& shared() { return shared_; }
  const LocalAccess& access() const { return server_.access(); }
  float milliseconds() const {
    return std::chrono::duration<float, std::milli>(std::chrono::steady_clock::now() - begin_)
        .count();
  }

 private:
  void handle(LocalVisit& visit) {
    const std::string_view path = visit.path();
    if (visit.request().method() != http::verb::get)
      return visit.answer(http::status::method_not_allowed, "GET alone\n");
    if (path == "/live" && visit.is_upgrade()) {
      if (shared_.viewers.size() >= shared_.settings.most_viewers)
        return visit.answer(http::status::service_unavailable, "as many viewers as may be\n");
      const std::string_view since = visit.parameter("since");
      const auto viewer = std::make_shared<Viewer>(
          visit.take(), shared_,
          since.empty() ? -1.0 : std::strtod(std::string(since).c_str(), nullptr));
      shared_.viewers.push_back(viewer);
      shared_.viewer_count = shared_.viewers.size();
      return viewer->accept(visit.request());
    }
    if (path == "/" && !visit.is_upgrade())
      return visit.answer(http::status::ok, shared_.page, "text/html; charset=utf-8");
    visit.answer(http::status::not_found, "nothing here\n");
  }

  void tick() {
    timer_.expires_after(shared_.settings.tick);
    timer_.async_wait([this](Error error) {
      if (error) return;
      shared_.take_rows();
      for (const auto& viewer : std::vector(shared_.viewers)) viewer->send();
      if (shared_.report && std::all_of(shared_.viewers.begin(), shared_.viewers.end(),
                                        [](const auto& viewer) { return viewer->done(); })) {
        const std::lock_guard lock(mutex_);
        delivered_ = true;
        all_have_it_.notify_all();
      }
      tick();
    });
  }

  Shared shared_;  // outlives what io_ still holds
  asio::io_context io_{1};
  LocalServer server_;
  asio::steady_timer timer_;
  std::chrono::steady_clock::time_point begin_;
  std::thread thread_;
  std::mutex mutex_;
  std::condition_variable all_have_it_;
  bool delivered_ = false;
};

LiveServer::LiveServer(const LiveSettings& settings) : impl_(std::make_shared<Impl>(settings)) {}
LiveServer::~LiveServer() = default;
int LiveServer::port() const { return impl_->access().port(); }
std::string LiveServer::address() const { return impl_->access().address(); }
void LiveServer::serve(std::string page) { impl_->serve(std::move(page)); }
RowRing& LiveServer::rows() noexcept { return impl_->shared().ring; }
void LiveServer::pause() noexcept { impl_->shared().paused = true; }
void LiveServer::resume() noexcept { impl_->shared().paused = false; }
bool LiveServer::paused() const noexcept { return impl_->shared().paused; }
bool LiveServer::stopped() const noexcept { return impl_->shared().stopped; }
bool LiveServer::emergency() const noexcept { return impl_->shared().emergency; }
float LiveServer::milliseconds() const noexcept { return impl_->milliseconds(); }
void LiveServer::ending() { impl_->ending(); }
void LiveServer::finish(std::string data, std::chrono::milliseconds patience) {
  impl_->finish(std::move(data), patience);
}
std::size_t LiveServer::viewers() const noexcept { return impl_->shared().viewer_count; }

}  // namespace impedraw
