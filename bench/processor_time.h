// Processor time, which hardly depends on the load of the machine.
#pragma once

#include <sys/resource.h>

namespace impedraw {

// Of this process with all its threads, and of its finished children [s].
inline double processor_seconds() {
  double sum = 0.0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    sum += static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  }
  return sum;
}

}  // namespace impedraw
