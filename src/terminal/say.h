// Prints. All that the program prints, but for its progress line, goes through say(), so that no
// file can move the cursor, rename the window or hide a line, and the command has its right name.
#pragma once

#include <cstdio>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "impedraw/common/printable.h"

namespace impedraw {

// The name that the program was called by. Texts name the command as a source tree has it,
// ./impedraw; printed ones name it as it was called.

// "impedraw" where it is installed. Before anything is printed; not thread-safe.
void set_command(const std::string& command);

// The text with the command as it was called.
std::string as_called(std::string text);

template <class... Args>
void say(std::FILE* out, fmt::format_string<Args...> format, Args&&... args) {
  const std::string text = printable(as_called(fmt::format(format, std::forward<Args>(args)...)));
  std::fwrite(text.data(), 1, text.size(), out);
}

}  // namespace impedraw
