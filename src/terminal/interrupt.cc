#include "impedraw/terminal/interrupt.h"

#include <csignal>

#include <array>
#include <atomic>
#include <cassert>

namespace impedraw {
namespace {

// Lock-free, so a signal handler may write it, and any thread may read it.
std::atomic<int> received = 0;
std::atomic<bool> quit = false;
static_assert(std::atomic<int>::is_always_lock_free);

constexpr std::array<int, 3> signals = {SIGINT, SIGTERM, SIGHUP};
std::array<struct sigaction, signals.size()> before;
struct sigaction before_quit;
bool in_use = false;

// As under nohup. (A shell ignores SIGINT, too, for what it starts in the background.)
bool stays_ignored(std::size_t i) {
  return signals[i] == SIGHUP && before[i].sa_handler == SIG_IGN;
}

extern "C" void note_signal(int signal) {
  received.store(signal, std::memory_order_relaxed);
  for (std::size_t i = 0; i < signals.size(); ++i)
    if (!stays_ignored(i)) std::signal(signals[i], SIG_DFL);
}

extern "C" void note_quit(int) { quit.store(true, std::memory_order_relaxed); }

}  // namespace

Interrupt::Interrupt() {
  assert(!in_use);
  in_use = true;
  received = 0;
  quit = false;
  struct sigaction on_quit {};
  on_quit.sa_handler = note_quit;
  on_quit.sa_flags = SA_RESTART | SA_RESETHAND;  // a second one ends the program at once
  sigaction(SIGQUIT, &on_quit, &before_quit);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    struct sigaction action {};
    action.sa_handler = note_signal;
    action.sa_flags = SA_RESTART;  // do not fail a log write in progress
    sigaction(signals[i], nullptr, &before[i]);
    if (!stays_ignored(i)) sigaction(signals[i], &action, nullptr);
  }
}

Interrupt::~Interrupt() {
  for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &before[i], nullptr);
  sigaction(SIGQUIT, &before_quit, nullptr);
  in_use = false;
}

bool Interrupt::requested() const noexcept { return received.load(std::memory_order_relaxed) != 0; }

bool Interrupt::emergency() const noexcept { return quit.load(std::memory_order_relaxed); }

int Interrupt::exit_code() const noexcept {
  const int signal = received.load(std::memory_order_relaxed);
  return signal == 0 ? 0 : 128 + signal;
}

}  // namespace impedraw
