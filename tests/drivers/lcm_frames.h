// Bytes of LCM's tcpq transport, as liblcm 1.3 writes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace impedraw {

using Bytes = std::vector<std::uint8_t>;

inline void put_number(Bytes* to, std::uint64_t value, int size) {
  for (int shift = 8 * (size - 1); shift >= 0; shift -= 8)
    to->push_back(static_cast<std::uint8_t>(value >> shift));
}

inline std::uint64_t number_at(const Bytes& bytes, std::size_t at, int size) {
  std::uint64_t value = 0;
  for (int i = 0; i < size; ++i) value = value << 8 | bytes.at(at + static_cast<std::size_t>(i));
  return value;
}

template <typename More>
void append(Bytes* to, const More& more) {
  to->insert(to->end(), more.begin(), more.end());
}

// What the broker answers to a client's greeting, which has the magic number 0x287617fb.
inline Bytes lcm_greeting(std::uint32_t magic = 0x287617fa) {
  Bytes all;
  put_number(&all, magic, 4);
  put_number(&all, 0x0100, 4);
  return all;
}

inline Bytes lcm_frame(std::string_view channel, const Bytes& message, std::uint32_t kind = 1) {
  Bytes all;
  put_number(&all, kind, 4);
  put_number(&all, channel.size(), 4);
  append(&all, channel);
  put_number(&all, message.size(), 4);
  append(&all, message);
  return all;
}

}  // namespace impedraw
