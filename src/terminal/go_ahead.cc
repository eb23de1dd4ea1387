#include "impedraw/terminal/go_ahead.h"

#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <atomic>

#include "impedraw/terminal/say.h"

namespace impedraw {
namespace {

std::atomic<bool> signalled = false;

extern "C" void note_go_ahead(int) { signalled.store(true, std::memory_order_relaxed); }

}  // namespace

GoAhead::GoAhead() : terminal_(isatty(STDIN_FILENO) == 1 && isatty(STDERR_FILENO) == 1) {
  signalled = false;
  struct sigaction action {};
  action.sa_handler = note_go_ahead;
  action.sa_flags = SA_RESTART;
  sigaction(SIGUSR1, &action, &before_);
}

GoAhead::~GoAhead() { sigaction(SIGUSR1, &before_, nullptr); }

void GoAhead::ask(const std::string& what) {
  if (terminal_) tcflush(STDIN_FILENO, TCIFLUSH);
  signalled = false;
  asked_ = true;
  say(stderr, "{}; then {}kill -USR1 {}\n", what, terminal_ ? "press Enter, or " : "", getpid());
}

bool GoAhead::given() noexcept {
  if (!asked_) return false;
  bool answer = signalled.exchange(false);
  pollfd in{STDIN_FILENO, POLLIN, 0};
  if (!answer && terminal_ && poll(&in, 1, 0) == 1) {
    std::array<char, 256> line;
    const ssize_t size = read(STDIN_FILENO, line.data(), line.size());
    answer = size > 0;
    if (size <= 0) terminal_ = false;  // nobody is there any more
  }
  if (answer) asked_ = false;
  return answer;
}

}  // namespace impedraw
