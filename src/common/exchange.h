// Data from one thread to another without a lock and without a wait.
//
// Both sides keep what they hold: nothing is allocated or freed but by T's own assignment.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <utility>

namespace impedraw {

// First in, first out; one thread gives, one other takes. `Room`: a power of two.
template <typename T, std::size_t Room>
class Queue {
  static_assert(Room > 0 && (Room & (Room - 1)) == 0);

 public:
  // Returns false if there is no room: nothing is given then.
  bool give(T value) noexcept {
    const std::size_t at = given_.load(std::memory_order_relaxed);
    if (at - taken_.load(std::memory_order_acquire) == Room) return false;
    all_[at % Room] = std::move(value);
    given_.store(at + 1, std::memory_order_release);
    return true;
  }
  // Returns false if there is none.
  bool take(T* value) noexcept {
    const std::size_t at = taken_.load(std::memory_order_relaxed);
    if (at == given_.load(std::memory_order_acquire)) return false;
    *value = std::move(all_[at % Room]);
    taken_.store(at + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<T, Room> all_{};
  // On cache lines of their own: each is written by one thread and read by the other.
  alignas(64) std::atomic<std::size_t> given_ = 0;
  alignas(64) std::atomic<std::size_t> taken_ = 0;
};

// The latest value; one thread gives, one other looks. Three slots: the one that is written, the
// one that is looked at, and between them the latest that was given.
template <typename T>
class Latest {
 public:
  // The slot to write; holds an older value.
  T& slot() noexcept { return all_[back_]; }
  // Makes what slot() holds the latest.
  void give() noexcept {
    back_ = between_.exchange(back_ | kNew, std::memory_order_acq_rel) & kSlot;
  }

  // Takes the latest, if there is one that was not looked at yet. Returns whether there was.
  bool refresh() noexcept {
    if (!(between_.load(std::memory_order_relaxed) & kNew)) return false;
    front_ = between_.exchange(front_, std::memory_order_acq_rel) & kSlot;
    return true;
  }
  // As of the last refresh().
  const T& value() const noexcept { return all_[front_]; }

 private:
  static constexpr unsigned kSlot = 3, kNew = 4;
  std::array<T, 3> all_{};
  alignas(64) std::atomic<unsigned> between_ = 1;
  alignas(64) unsigned back_ = 0;   // of the giver
  alignas(64) unsigned front_ = 2;  // of the looker
};

}  // namespace impedraw
