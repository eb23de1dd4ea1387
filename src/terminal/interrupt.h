// ctrl-C and SIGTERM as a flag that the loop looks at, so that a run ends with its log kept.
#pragma once

namespace impedraw {

// While it lives, the first SIGINT or SIGTERM sets the flag; a second one ends the program at once,
// as it would have without this. One at a time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();  // puts back what was in force before
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  bool requested() const noexcept;  // cheap enough for every step
  int exit_code() const noexcept;   // 128 + the signal (ctrl-C: 130), 0 without one
};

}  // namespace impedraw
