// How the program was called. Texts name the command as a source tree has it, ./impedraw; what is
// printed names it as it was called.
#pragma once

#include <string>

namespace impedraw {

// "impedraw" where it is installed. Before anything is printed; not thread-safe.
void set_command(const std::string& command);

// The text with the command as it was called.
std::string as_called(std::string text);

}  // namespace impedraw
