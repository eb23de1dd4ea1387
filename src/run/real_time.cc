#include "impedraw/run/real_time.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>

#include <cerrno>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

namespace impedraw {
namespace {

constexpr std::size_t kStack = 256 * 1024;  // touched in advance [bytes]

void touch_stack() {
  unsigned char stack[kStack];
  std::memset(stack, 0, kStack);
  asm volatile("" : : "r"(stack) : "memory");  // or the compiler leaves it out
}

// MCL_FUTURE under a finite limit would make a later allocation fail.
int lock_memory() {
  rlimit limit{};
  const bool unlimited = getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
  return mlockall(unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT);
}

}  // namespace

RealTime::RealTime(bool wanted) {
  if (!wanted) return;
  sched_param priority{};
  priority.sched_priority = kPriority;
  // 0: of this thread alone. Without the reset, the log's thread would inherit the priority.
  scheduled_ = sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &priority) == 0;
  if (!scheduled_)
    lacks_ = fmt::format("no SCHED_FIFO ({}); the user needs an rtprio of {} in limits.conf",
                         std::strerror(errno), kPriority);
  locked_ = lock_memory() == 0;
  if (!locked_)
    lacks_ += fmt::format("{}memory is not locked ({}); the user needs memlock unlimited there",
                          lacks_.empty() ? "" : "; ", std::strerror(errno));
  touch_stack();
}

RealTime::~RealTime() {
  const sched_param usual{};
  if (scheduled_) sched_setscheduler(0, SCHED_OTHER, &usual);
  if (locked_) munlockall();
}

void schedule_alike(std::thread* other) noexcept {
  if ((sched_getscheduler(0) & ~SCHED_RESET_ON_FORK) != SCHED_FIFO) return;
  sched_param priority{};
  sched_getparam(0, &priority);
  pthread_setschedparam(other->native_handle(), SCHED_FIFO, &priority);
}

std::vector<double> wake_up_delays(double period, int count) {
  std::vector<double> delays;
  delays.reserve(static_cast<std::size_t>(count));
  timespec due{}, now{};
  clock_gettime(CLOCK_MONOTONIC, &due);
  const long step = std::lround(1e9 * period);
  for (int i = 0; i < count; ++i) {
    due.tv_nsec += step;
    while (due.tv_nsec >= 1'000'000'000) {
      due.tv_nsec -= 1'000'000'000;
      ++due.tv_sec;
    }
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr) == EINTR) {
    }
    clock_gettime(CLOCK_MONOTONIC, &now);
    delays.push_back(static_cast<double>(now.tv_sec - due.tv_sec) +
                     1e-9 * static_cast<double>(now.tv_nsec - due.tv_nsec));
  }
  return delays;
}

}  // namespace impedraw
