// Reads a file in a process of its own: what others' code makes of a damaged file may crash, run
// for ever or take all memory. The program goes on with a result or with one line.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <new>
#include <string>
#include <string_view>

#include "impedraw/common/errors.h"

namespace impedraw {

// The result of read(), or its exception's text after a "!".
inline std::string result_or_error(const std::string& name,
                                   const std::function<std::string()>& read) {
  try {
    return read();
  } catch (const std::bad_alloc&) {
    return "!" + name + ": takes more than 4 GiB of memory to read: decimate the mesh";
  } catch (const std::exception& error) {
    return std::string("!") + error.what();
  }
}

// read()'s result, which is not empty and does not begin with "!", from a forked process. Throws
// InputError with the text of what read() throws, or one that begins with `name` and says that it
// crashed in the library `reader`, or took too long.
inline std::string read_in_child(const std::string& name, const char* reader,
                                 const std::function<std::string()>& read_file) {
  constexpr rlim_t kMostSeconds = 60;                        // of CPU time
  constexpr std::size_t kMostMemory = std::size_t{4} << 30;  // [bytes] beyond what is in use
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw InputError(name + ": cannot be read: " + std::strerror(errno));
  const pid_t child = fork();
  if (child == 0) {
    for (int number = 1; number < 32; ++number) signal(number, SIG_DFL);
    const rlimit no_core{0, 0}, cpu{kMostSeconds, kMostSeconds + 1};
    close(STDERR_FILENO);  // the C library's last words
    setrlimit(RLIMIT_CORE, &no_core);
    setrlimit(RLIMIT_CPU, &cpu);
    std::size_t used = 0;  // [pages]
    std::ifstream("/proc/self/statm") >> used;
    used *= static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const rlimit memory{used + kMostMemory, used + kMostMemory};
    if (used < std::size_t{1} << 40)  // more is the shadow of the address sanitizer
      setrlimit(RLIMIT_AS, &memory);
    const std::string result = result_or_error(name, read_file);
    std::string_view rest = result;
    for (ssize_t n = 0; n >= 0 && !rest.empty(); rest.remove_prefix(static_cast<std::size_t>(n)))
      n = std::max<ssize_t>(write(ends[1], rest.data(), rest.size()), 0);
    _exit(0);
  }
  close(ends[1]);
  std::string result, block(1 << 20, ' ');
  for (ssize_t n = 1; child > 0 && (n > 0 || errno == EINTR);) {
    n = read(ends[0], block.data(), block.size());
    if (n == 0) break;
    if (n > 0) result.append(block, 0, static_cast<std::size_t>(n));
  }
  close(ends[0]);
  int status = 0;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (child < 0 || WIFSIGNALED(status) || result.empty()) {
    throw InputError(name + ": cannot be read: " +
                     (child < 0 ? "no process could be started"
                      : WTERMSIG(status) == SIGXCPU
                          ? "it takes more than " + std::to_string(kMostSeconds) + " s"
                          : std::string("it is damaged; ") + reader + ", which reads it, crashed"));
  }
  if (result[0] == '!') throw InputError(result.substr(1));
  return result;
}

}  // namespace impedraw
