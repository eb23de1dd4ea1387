// Exit codes of the program.
#pragma once

namespace impedraw {

enum ExitCode { kFinished = 0, kMissed = 1, kBadInput = 2, kStopped = 3, kInterrupted = 130 };

}  // namespace impedraw
