// A person's word that the run may go on: Enter at the terminal, or SIGUSR1 from elsewhere.
#pragma once

#include <csignal>
#include <string>

namespace impedraw {

class GoAhead {
 public:
  GoAhead();   // from now on SIGUSR1 does not end the program
  ~GoAhead();  // restores its handler
  GoAhead(const GoAhead&) = delete;
  GoAhead& operator=(const GoAhead&) = delete;

  // Somebody may be at the terminal: input and messages are one.
  bool terminal() const noexcept { return terminal_; }
  // Asks on stderr, and says how to answer. What was typed before is no answer.
  void ask(const std::string& what);
  bool asked() const noexcept { return asked_; }
  // Looks for an answer; does not wait. True once after each ask().
  bool given() noexcept;
  void withdraw() noexcept { asked_ = false; }  // the answer came from elsewhere

 private:
  bool terminal_, asked_ = false;
  struct sigaction before_ {};
};

}  // namespace impedraw
