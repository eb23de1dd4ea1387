// Errors at set-up. The 1 kHz loop throws nothing; it returns a status.
#pragma once

#include <stdexcept>
#include <string_view>

#include "impedraw/common/printable.h"

namespace impedraw {

// Invalid user input. The message is one line that names the fault, its place and what is valid.
// The program exits with code 2 and leaves no files behind.
class InputError : public std::runtime_error {
 public:
  // Names and texts of the user may hold anything: control characters are escaped as in JSON, line
  // breaks and tabs too.
  explicit InputError(std::string_view message) : std::runtime_error(printable_line(message)) {}
};

}  // namespace impedraw
