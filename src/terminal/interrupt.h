// Turns ctrl-C, SIGTERM and SIGHUP (the terminal is gone) into a flag that the loop polls, so that
// the pen is lifted before an interrupted run ends. SIGQUIT (ctrl-\) sets another one: emergency
// stop.
#pragma once

#include <stdexcept>
#include <string>

namespace impedraw {

// Work was given up because of a signal. The program prints the message and exits with the code.
class Interrupted : public std::runtime_error {
 public:
  Interrupted(const std::string& message, int exit_code)
      : std::runtime_error(message), exit_code_(exit_code) {}
  int exit_code() const noexcept { return exit_code_; }

 private:
  int exit_code_;
};

// During its lifetime, the first of these signals sets the flag; a second one ends the program at
// once, as without this class. SIGQUIT sets its flag also after one of them. If SIGHUP was ignored
// (nohup), it stays so. At most one instance may exist at a time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();  // restores the previous handlers
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  bool requested() const noexcept;  // cheap enough for every step
  bool emergency() const noexcept;  // SIGQUIT came; requested() is not set by it
  int exit_code() const noexcept;   // 128 + signal (ctrl-C: 130); 0 without one
};

}  // namespace impedraw
