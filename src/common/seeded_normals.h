// Standard normal numbers from a seed, the same on every platform: the standard library's
// distributions are not.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace impedraw {

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
