// Real-time priority of the thread that drives an arm on a wall clock.
#pragma once

#include <string>
#include <thread>
#include <vector>

namespace impedraw {

// During its lifetime this thread runs with SCHED_FIFO, the process's memory is locked, and some
// stack has been touched. Threads that it starts run as usual. What the system refuses, lacks()
// names; nothing throws. Leaves everything as it was if not `wanted`.
class RealTime {
 public:
  static constexpr int kPriority = 60;  // above most, below the kernel's own threads for timers

  explicit RealTime(bool wanted);
  ~RealTime();
  RealTime(const RealTime&) = delete;
  RealTime& operator=(const RealTime&) = delete;

  // One line for the user; empty: everything asked for was given.
  const std::string& lacks() const noexcept { return lacks_; }

 private:
  bool scheduled_ = false, locked_ = false;
  std::string lacks_;
};

// Gives the thread this one's priority, where this one has SCHED_FIFO.
void schedule_alike(std::thread* other) noexcept;

// Lateness with which this thread wakes up from `count` sleeps to absolute times `period` [s]
// apart, by the monotonic clock [s].
std::vector<double> wake_up_delays(double period, int count);

}  // namespace impedraw
