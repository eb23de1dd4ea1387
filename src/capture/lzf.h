// LibLZF's compressed format, which PCD's binary_compressed has.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace impedraw {

// Absent unless `packed` is valid and exactly `size` bytes come out.
inline std::optional<std::string> lzf_unpacked(std::string_view packed, std::size_t size) {
  if (size / 264 > packed.size()) return {};  // 3 bytes refer to at most 264
  std::string out;
  out.reserve(size);
  std::size_t i = 0;
  bool damaged = false;
  const auto next = [&]() -> std::size_t {
    damaged = damaged || i >= packed.size();
    return damaged ? 0 : static_cast<unsigned char>(packed[i++]);
  };
  while (i < packed.size()) {
    const std::size_t control = next();
    std::size_t length = control < 32 ? control + 1 : control >> 5;
    if (control < 32) {
      damaged = packed.size() - i < length || size - out.size() < length;
      if (damaged) return {};
      out.append(packed.substr(i, length));
      i += length;
      continue;
    }
    if (length == 7) length += next();
    length += 2;
    const std::size_t back = ((control & 31) << 8) + next() + 1;
    if (damaged || back > out.size() || size - out.size() < length) return {};
    for (; length > 0; --length) out.push_back(out[out.size() - back]);
  }
  if (out.size() != size) return {};
  return out;
}

}  // namespace impedraw
