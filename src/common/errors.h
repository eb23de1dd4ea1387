// Errors at set-up. The 1 kHz loop throws nothing; it returns a status.
#pragma once

#include <stdexcept>
#include <string>

namespace impedraw {

// Invalid user input. The message is one line that names the fault, its place and what is valid.
// The program exits with code 2 and leaves no files behind.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace impedraw
