// Work that threads share. Its results do not depend on their number.
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace impedraw {

// Number of threads that share work; 0: as many as the machine has. For tests.
inline std::atomic<int> parallel_threads = 0;

// Calls work(i) once for each i of 0 … n − 1. Where calls throw, rethrows what that of the least i
// threw; those of greater i may then be missing.
template <class Work>
void in_parallel(int n, const Work& work) {
  const int asked = parallel_threads;
  const int threads =
      std::min(n, asked > 0 ? asked : static_cast<int>(std::thread::hardware_concurrency()));
  std::atomic<int> next = 0, failed = n;
  std::exception_ptr error;
  std::mutex lock;
  const auto share = [&] {
    for (int i = next++; i < failed; i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::lock_guard guard(lock);
        if (i < failed) failed = i, error = std::current_exception();
      }
    }
  };
  std::vector<std::thread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back(share);
  share();
  for (std::thread& thread : others) thread.join();
  if (error) std::rethrow_exception(error);
}

// Calls work(begin, end) for both halves of 0 … n.
template <class Work>
void in_halves(int n, const Work& work) {
  in_parallel(2, [&](int half) { half == 0 ? work(0, n / 2) : work(n / 2, n); });
}

}  // namespace impedraw
