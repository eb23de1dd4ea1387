// Work that two threads share.
#pragma once

#include <thread>

namespace impedraw {

// Calls work(begin, end) for both halves of 0 … n at once. `work` must not throw.
template <class Work>
void in_halves(int n, const Work& work) {
  std::thread other(work, 0, n / 2);
  work(n / 2, n);
  other.join();
}

}  // namespace impedraw
