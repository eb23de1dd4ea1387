// Standard normal numbers from a seed, the same on every platform: the standard library's
// distributions are not.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace impedraw {

// Random numbers that belong to a seed and a counter: the same in any order and on any thread.

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

class SeededNormals {
 public:
  explicit SeededNormals(std::uint64_t seed) : bits_(seed) {}

  // Box and Muller (1958), which gives pairs.
  double next() noexcept {
    if (kept_) {
      kept_ = false;
      return second_;
    }
    const double radius = std::sqrt(-2.0 * std::log(uniform())),
                 angle = 2.0 * std::numbers::pi * uniform();
    second_ = radius * std::sin(angle);
    kept_ = true;
    return radius * std::cos(angle);
  }

 private:
  // In (0, 1): the midpoint of one of 2⁵³ equal intervals, so that its logarithm is finite.
  double uniform() noexcept { return (static_cast<double>(bits_() >> 11) + 0.5) * 0x1p-53; }

  std::mt19937_64 bits_;
  double second_ = 0.0;
  bool kept_ = false;
};

}  // namespace impedraw
