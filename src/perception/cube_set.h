// A set of the cubes of a grid that points lie in.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

// The number of the cube of side 1 that p lies in, not 0; they repeat after 2²¹ cubes. Each cube's
// middle has whole coordinates.
inline std::uint64_t cube_of(const Eigen::Vector3d& p) noexcept {
  constexpr double kUp = (1 << 20) + 0.5;  // makes places positive, so that they can be cut off
  const auto along = [](double x) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(x + kUp)) & 0x1fffff;
  };
  return 1ull << 63 | along(p.x()) << 42 | along(p.y()) << 21 | along(p.z());
}
// The key of the cube of `side` [m] that p lies in.
inline std::uint64_t cube_of(const Eigen::Vector3d& p, double side) noexcept {
  return cube_of(Eigen::Vector3d(p / side));
}

// Open addressing over blocks of 4 × 4 × 4 cubes, each with a bit for each of its cubes: of a
// surface's cubes, most share their block, and its place in memory, with the one before.
class CubeSet {
 public:
  bool contains(std::uint64_t cube) const noexcept {
    return (places_[place_of(block_of(cube))].cubes & bit_of(cube)) != 0;
  }
  // True where the cube was no member yet.
  bool insert(std::uint64_t cube) {
    const std::uint64_t block = block_of(cube);
    if (places_[last_].block != block) last_ = place_of(block);
    Place& place = places_[last_];
    if ((place.cubes & bit_of(cube)) != 0) return false;
    if (place.cubes == 0) ++size_;
    place = {block, place.cubes | bit_of(cube)};
    if (2 * size_ > places_.size()) grow();
    return true;
  }

 private:
  struct Place {
    std::uint64_t block = 0, cubes = 0;  // no block has the number 0
  };
  static std::uint64_t block_of(std::uint64_t cube) noexcept {
    return cube & ~(3ull | 3ull << 21 | 3ull << 42);
  }
  static std::uint64_t bit_of(std::uint64_t cube) noexcept {
    return 1ull << ((cube & 3) | (cube >> 21 & 3) << 2 | (cube >> 42 & 3) << 4);
  }
  // The slot that the block has, or could be put into.
  std::size_t place_of(std::uint64_t block) const noexcept {
    const std::uint64_t mixed = block * 0x9e3779b97f4a7c15;
    std::size_t at = (mixed ^ mixed >> 32) & (places_.size() - 1);
    while (places_[at].cubes != 0 && places_[at].block != block)
      at = (at + 1) & (places_.size() - 1);
    return at;
  }
  void grow() {
    std::vector<Place> old(2 * places_.size());
    places_.swap(old);
    last_ = 0;
    for (const Place& place : old)
      if (place.cubes != 0) places_[place_of(place.block)] = place;
  }

  std::vector<Place> places_ = std::vector<Place>(64);
  std::size_t size_ = 0;  // blocks
  std::size_t last_ = 0;  // slot of the last insertion
};

}  // namespace impedraw
