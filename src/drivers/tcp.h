// The parts of TCP that the links of all drivers use.
#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <optional>
#include <string>

namespace impedraw {

// The address of A.B.C.D:PORT; without :PORT that of `usual_port`, if it is not 0. None for any
// other text: names are not looked up.
std::optional<sockaddr_in> ipv4_address(const std::string& text, int usual_port = 0);

// A connected, non-blocking socket without Nagle's delay, which the caller closes. On failure -1,
// with the reason in `error` (an errno; ETIMEDOUT if nobody answers within `patience` [s]).
int connect_tcp(const sockaddr_in& address, double patience, int* error) noexcept;

// Waits at most `seconds`. True if a read would not block: something came, or the peer left.
bool readable(int descriptor, double seconds) noexcept;
bool writable(int descriptor, double seconds) noexcept;

// Numbers in network order, as LCM writes them.

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
