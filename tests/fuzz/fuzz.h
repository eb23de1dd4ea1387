// What every fuzz target shares.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

#include "impedraw/common/errors.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace impedraw::fuzz {

// Takes the input apart from its front; past its end come zeros.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size)
      : rest_(reinterpret_cast<const char*>(data), size) {}

  bool empty() const { return rest_.empty(); }
  std::string_view rest() const { return rest_; }

  std::uint8_t byte() { return number<std::uint8_t>(); }

  template <class T>
  T number() {
    T value{};
    const std::size_t n = rest_.size() < sizeof(T) ? rest_.size() : sizeof(T);
    std::memcpy(&value, rest_.data(), n);
    rest_.remove_prefix(n);
    return value;
  }

 private:
  std::string_view rest_;
};

// A reader may refuse its input, in one line. Any other exception ends the program.
template <class Read>
int expect_value_or_input_error(Read&& read) {
  try {
    read();
  } catch (const InputError& error) {
    const std::string_view line = error.what();
    if (line.empty() || line.find('\n') != line.npos) std::abort();
  }
  return 0;
}

}  // namespace impedraw::fuzz
