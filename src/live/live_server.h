// Shows a run in browsers on this machine while it goes on: one page and one WebSocket, served by a
// thread of its own.
//
//   loop thread ── RowRing ──> server thread: rows kept ──> each viewer's socket
//   loop thread <── atomics ── pause, resume, stop, emergency
//
// Only 127.0.0.1 is listened to. A request needs the token of the address and a Host of this
// server; a WebSocket needs its Origin, too (RFC 6455, 10.2: any page may open a socket here). What
// lacks them gets 403. Nothing is read from the disk.
//
// Viewers cannot slow the run, nor grow memory: rows are kept once for all of them, each has one
// message under way, and one that falls behind is sent every n-th row. One that neither reads nor
// answers pings is disconnected.
//
// Messages to a viewer, little endian:
//   text    {"state": "running" | "paused" | "ending" | "finished", "stopping": bool}
//   binary  uint32 0, uint32 rows, then float32 rows × row_width: rows, oldest first
//   binary  uint32 1, then the data of the finished report, as in its page
// From a viewer, text: pause, resume, stop, emergency.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace impedraw {

// Rows of numbers from one thread to another without waiting: a ring of fixed size, for one
// producer and one consumer. Where it is full, rows are dropped.
class RowRing {
 public:
  // width: numbers of a row; rows: most that wait for the consumer.
  RowRing(std::size_t width, std::size_t rows)
      : width_(width), rows_(rows), numbers_(width * rows, 0.0f) {}

  std::size_t width() const { return width_; }

  // Producer. A row to fill, followed by commit(); empty where the ring is full. Neither allocates,
  // locks or waits.
  std::span<float> next() noexcept {
    const std::uint64_t n = written_.load(std::memory_order_relaxed);
    if (n - read_.load(std::memory_order_acquire) >= rows_) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return {};
    }
    return {&numbers_[n % rows_ * width_], width_};
  }
  void commit() noexcept { written_.fetch_add(1, std::memory_order_release); }

  // Consumer. The oldest row, followed by pop(); empty where there is none.
  std::span<const float> oldest() const noexcept {
    const std::uint64_t n = read_.load(std::memory_order_relaxed);
    if (n == written_.load(std::memory_order_acquire)) return {};
    return {&numbers_[n % rows_ * width_], width_};
  }
  void pop() noexcept { read_.fetch_add(1, std::memory_order_release); }

  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  const std::size_t width_, rows_;
  std::vector<float> numbers_;
  alignas(64) std::atomic<std::uint64_t> written_ = 0;
  alignas(64) std::atomic<std::uint64_t> read_ = 0;
  alignas(64) std::atomic<std::uint64_t> dropped_ = 0;
};

struct LiveSettings {
  int port = 0;  // 0: a free one
  std::size_t row_width = 1;
  std::size_t most_viewers = 8;
  std::size_t kept_rows = 60000;  // beyond, every second row is given up
  std::chrono::milliseconds tick{20};
  std::chrono::milliseconds request_time{5000};  // for a request to arrive
  std::chrono::milliseconds silence{20000};      // after which a viewer is disconnected
};

class LiveServer {
 public:
  // Listens; nobody is answered before serve(). Throws InputError if the port cannot be had.
  explicit LiveServer(const LiveSettings& settings);
  ~LiveServer();  // disconnects everybody
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;

  int port() const;
  std::string address() const;  // with the token

  // Starts to answer with this page.
  void serve(std::string page);

  // For the loop's thread. None of these waits.
  RowRing& rows() noexcept;
  bool paused() const noexcept;
  void pause() noexcept;  // as a person would on the page
  void resume() noexcept;
  bool stopped() const noexcept;        // once, for good
  bool emergency() const noexcept;      // the same
  float milliseconds() const noexcept;  // since construction, by the steady clock

  // The run is over: its results are being made.
  void ending();
  // Sends the finished report to all viewers; returns once they have it, or after `patience`.
  void finish(std::string data, std::chrono::milliseconds patience);

  std::size_t viewers() const noexcept;

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace impedraw
