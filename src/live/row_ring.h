// Rows of numbers from one thread to another without waiting: a ring of fixed size, for one
// producer and one consumer. Where it is full, rows are dropped.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace impedraw {

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

}  // namespace impedraw
