// Turns ctrl-C and SIGTERM into a flag that the loop polls, so that an interrupted run keeps its
// log.
#pragma once

namespace impedraw {

// During its lifetime, the first SIGINT or SIGTERM sets the flag; a second one ends the program at
// once, as without this class. At most one instance may exist at a time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();  // restores the previous handlers
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  bool requested() const noexcept;  // cheap enough for every step
  int exit_code() const noexcept;   // 128 + signal (ctrl-C: 130); 0 without one
};

}  // namespace impedraw
