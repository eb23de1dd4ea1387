// The command line: reads arguments, names errors, returns exit codes. What it does is in
// commands.h.
#pragma once

namespace impedraw {

// A whole call of the program, as main() has it; argv[argc] is null. Returns the exit code. Prints
// with C's streams, which are flushed when it returns. Signals should have their default actions.
int command_line(int argc, char** argv);

}  // namespace impedraw
