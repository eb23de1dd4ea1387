// Errors of set-up. The loop at 1 kHz throws nothing: it returns a status.
#pragma once

#include <stdexcept>
#include <string>

namespace impedraw {

// What the user gave cannot be used. The message is one line that names what, where, and what would
// be valid. The program ends with exit code 2 and leaves nothing behind.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace impedraw
