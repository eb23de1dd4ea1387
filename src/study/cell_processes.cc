#include "impedraw/study/cell_processes.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <list>
#include <stdexcept>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "impedraw/files/durable_file.h"
#include "impedraw/terminal/clock.h"

namespace impedraw {

namespace {

namespace fs = std::filesystem;
using Work = std::function<std::string(std::size_t, const fs::path&)>;

struct Child {
  std::size_t piece;
  pid_t pid;
  int from;  // its result
  fs::path file;
  Clock::time_point start;
  std::string text;
};

// The child process. Output of libraries does not disturb the progress line, and the child does not
// outlive its parent.
[[noreturn]] void live(const Work& work, std::size_t piece, const fs::path& file, int to,
                       pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  std::string text;
  try {
    text = work(piece, file);
  } catch (...) {
    _exit(1);
  }
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t n = write(to, text.data() + sent, text.size() - sent);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) _exit(1);
    sent += static_cast<std::size_t>(n);
  }
  _exit(0);  // no atexit: what the parent has open is the parent's to flush
}

// The running child processes. The destructor kills those still running.
class Children {
 public:
  ~Children() {
    for (Child& child : running_) kill_and_wait(child);
  }

  void start(const Work& work, std::size_t piece, const fs::path& file) {
    std::array<int, 2> ends;
    if (pipe2(ends.data(), O_CLOEXEC) != 0)
      throw std::runtime_error(fmt::format("no pipe can be made: {}", std::strerror(errno)));
    const pid_t parent = getpid(), pid = fork();
    if (pid == 0) live(work, piece, file, ends[1], parent);
    close(ends[1]);
    if (pid < 0) {
      close(ends[0]);
      throw std::runtime_error(fmt::format("no process can be started: {}", std::strerror(errno)));
    }
    running_.push_back({piece, pid, ends[0], file, Clock::now(), {}});
  }

  int count() const { return static_cast<int>(running_.size()); }

  // Waits a while for results; hands over each child that has ended or that is over its time.
  void wait(double time_limit,
            const std::function<void(std::size_t, const ProcessEnd&)>& finished) {
    std::vector<pollfd> ends;
    for (const Child& child : running_) ends.push_back({child.from, POLLIN, 0});
    if (poll(ends.data(), ends.size(), 200) < 0 && errno != EINTR)
      throw std::runtime_error("poll: " + std::string(std::strerror(errno)));
    std::size_t i = 0;
    for (auto child = running_.begin(); child != running_.end(); ++i) {
      const bool heard = ends[i].revents != 0, late = seconds_since(child->start) > time_limit;
      if ((heard && !read_some(*child)) || late) {
        const ProcessEnd ended = end(*child, late, time_limit);
        const std::size_t piece = child->piece;
        child = running_.erase(child);
        finished(piece, ended);
      } else {
        ++child;
      }
    }
  }

 private:
  static bool read_some(Child& child) {
    std::array<char, 4096> block;
    const ssize_t n = read(child.from, block.data(), block.size());
    if (n > 0) child.text.append(block.data(), static_cast<std::size_t>(n));
    return n > 0 || (n < 0 && errno == EINTR);
  }

  static int kill_and_wait(Child& child) {
    kill(child.pid, SIGKILL);
    return await(child);
  }

  static int await(Child& child) {
    int status = 0;
    while (waitpid(child.pid, &status, 0) < 0 && errno == EINTR) {
    }
    close(child.from);
    std::error_code ignored;
    fs::remove(child.file, ignored);
    // What a child leaves of its log that is killed.
    fs::remove(fs::path(child.file).replace_extension(".journal"), ignored);
    remove_unfinished(child.file.parent_path());
    return status;
  }

  static ProcessEnd end(Child& child, bool late, double time_limit) {
    ProcessEnd ended;
    ended.wall_time = seconds_since(child.start);
    const int status = late ? kill_and_wait(child) : await(child);
    if (late)
      ended.cause = fmt::format("timeout: took longer than {:.0f} s", time_limit);
    else if (WIFSIGNALED(status))
      ended.cause = fmt::format("crashed: signal {}", WTERMSIG(status));
    else if (WEXITSTATUS(status) != 0 || child.text.empty())
      ended.cause = "crashed: no result";
    else
      ended.text = std::move(child.text);
    return ended;
  }

  std::list<Child> running_;
};

}  // namespace

bool run_processes(std::size_t count, const Work& work, const ProcessSettings& settings,
                   const ProcessHooks& hooks) {
  Children children;
  std::size_t next = 0;
  while (next < count || children.count() > 0) {
    if (hooks.interrupted && hooks.interrupted()) return false;
    while (next < count && children.count() < settings.jobs) {
      children.start(work, next, settings.scratch / fmt::format(".cell-{}-{}.h5", getpid(), next));
      ++next;
    }
    children.wait(settings.time_limit, hooks.finished);
    if (hooks.waiting) hooks.waiting();
  }
  return true;
}

}  // namespace impedraw
