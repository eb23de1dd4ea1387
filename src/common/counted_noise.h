// Random numbers that belong to a seed and a counter: the same in any order and on any thread.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace impedraw {

// SplitMix64's finaliser: neighbouring counters give unrelated bits.
inline std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

// In (0, 1).
inline double uniform_of(std::uint64_t bits) {
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

// Standard normal number, by the Box-Muller transform.
inline double counted_normal(std::uint64_t seed, std::uint64_t counter) {
  const std::uint64_t key = mixed(seed) ^ counter;
  const double radius = std::sqrt(-2.0 * std::log(uniform_of(mixed(2 * key))));
  return radius * std::cos(2.0 * std::numbers::pi * uniform_of(mixed(2 * key + 1)));
}

}  // namespace impedraw
