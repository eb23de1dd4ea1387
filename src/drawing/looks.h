// Colours that the eye cannot tell apart.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <map>

namespace impedraw {

class Looks {
 public:
  // One name for the colour and those like it that were asked for before. [0xRRGGBB]
  std::uint32_t of(std::uint32_t colour) {
    const auto [look, is_new] = names_.try_emplace(colour, colour);
    if (!is_new || names_.size() > kMost) return look->second;
    for (const auto& [other, name] : names_) {
      const auto alike = [&, a = other](int shift) {
        return std::abs(int(colour >> shift & 0xff) - int(a >> shift & 0xff)) < kSame;
      };
      if (other == name && other != colour && alike(0) && alike(8) && alike(16))
        return look->second = other;
    }
    return colour;
  }

 private:
  static constexpr int kSame = 6;             // of 255: colours that differ by less are one
  static constexpr std::size_t kMost = 2000;  // colours that are compared
  std::map<std::uint32_t, std::uint32_t> names_;
};

}  // namespace impedraw
