#include "impedraw/drawing/bounded.h"

#include <pthread.h>

#include <chrono>
#include <ctime>
#include <future>
#include <memory>
#include <thread>
#include <utility>

namespace impedraw {

bool done_within(double seconds, std::function<void()> work) {
  const auto task = std::make_shared<std::packaged_task<void()>>(std::move(work));
  std::future<void> done = task->get_future();
  std::thread thread([task] { (*task)(); });
  clockid_t clock{};
  const bool timed = pthread_getcpuclockid(thread.native_handle(), &clock) == 0;
  while (done.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready) {
    timespec used{};
    if (!timed || clock_gettime(clock, &used) != 0) continue;
    if (static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec) <= seconds)
      continue;
    thread.detach();
    return false;
  }
  thread.join();
  done.get();
  return true;
}

}  // namespace impedraw
