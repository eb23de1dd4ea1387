// A set of the cubes of a grid that points lie in.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

// The number of the cube of `side` [m] that p lies in, not 0; they repeat after 2²¹ cubes. Each
// cube's middle is a multiple of the side.
inline std::uint64_t cube_of(const Eigen::Vector3d& p, double side) noexcept {
  constexpr double kUp = 1 << 20;  // makes places positive, so that they can be cut off
  std::uint64_t number = 1;
  for (int k = 0; k < 3; ++k)
    number = number << 21 |
             (static_cast<std::uint64_t>(static_cast<std::int64_t>(p[k] / side + (kUp + 0.5))) &
              0x1fffff);
  return number;
}

// Open addressing: a question reads one place, mostly. 0 is no member.
class CubeSet {
 public:
  explicit CubeSet(std::size_t expected = 0) {
    while (places_.size() < 2 * expected) places_.resize(2 * places_.size());
  }
  bool contains(std::uint64_t cube) const noexcept { return places_[place_of(cube)] == cube; }
  // For one who asks about the cube soon.
  void prefetch(std::uint64_t cube) const noexcept { __builtin_prefetch(&places_[first_of(cube)]); }
  // True where the cube was no member yet.
  bool insert(std::uint64_t cube) {
    std::uint64_t& place = places_[place_of(cube)];
    if (place == cube) return false;
    place = cube;
    if (2 * ++size_ > places_.size()) grow();
    return true;
  }

 private:
  std::size_t first_of(std::uint64_t cube) const noexcept {
    const std::uint64_t mixed = cube * 0x9e3779b97f4a7c15;
    return (mixed ^ mixed >> 32) & (places_.size() - 1);
  }
  // The slot that the cube has, or could be put into.
  std::size_t place_of(std::uint64_t cube) const noexcept {
    std::size_t at = first_of(cube);
    while (places_[at] != 0 && places_[at] != cube) at = (at + 1) & (places_.size() - 1);
    return at;
  }
  void grow() {
    std::vector<std::uint64_t> old(2 * places_.size());
    places_.swap(old);
    for (const std::uint64_t cube : old)
      if (cube != 0) places_[place_of(cube)] = cube;
  }

  std::vector<std::uint64_t> places_ = std::vector<std::uint64_t>(64);
  std::size_t size_ = 0;
};

}  // namespace impedraw
