// Prints. All that the program prints, but for its progress line, goes through say(), so that no
// file can move the cursor, rename the window or hide a line, and the command has its right name.
#pragma once

#include <cstdio>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "impedraw/common/printable.h"
#include "impedraw/terminal/called.h"

namespace impedraw {

template <class... Args>
void say(std::FILE* out, fmt::format_string<Args...> format, Args&&... args) {
  const std::string text = printable(as_called(fmt::format(format, std::forward<Args>(args)...)));
  std::fwrite(text.data(), 1, text.size(), out);
}

}  // namespace impedraw
