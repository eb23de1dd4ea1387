// Numbers in network order, as LCM writes them.
#pragma once

#include <cstdint>

namespace impedraw {

// Writes the lowest `bytes` bytes of a value, and moves on behind them.
inline void put_big_endian(std::uint64_t value, int bytes, std::uint8_t** to) noexcept {
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8)
    *(*to)++ = static_cast<std::uint8_t>(value >> shift);
}

// Reads a value of `bytes` bytes, and moves on behind it.
inline std::uint64_t get_big_endian(int bytes, const std::uint8_t** from) noexcept {
  std::uint64_t value = 0;
  for (int i = 0; i < bytes; ++i) value = value << 8 | *(*from)++;
  return value;
}

}  // namespace impedraw
