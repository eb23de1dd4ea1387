// Points in space, one for each cube that was visited: what a tool leaves along its way, and what
// it has touched. Its size is fixed: nothing is allocated while it is filled.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

struct KeptPlace {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  double value = 0.0;
  int count = 0;  // 0: not visited
  std::array<int, 3> cell{};
};

class PlaceMap {
 public:
  // cell: side of a cube [m]; room: for so many cubes, a power of two.
  PlaceMap(double cell, std::size_t room) : cell_(cell), places_(room) {}

  // The place of the cube in which p lies; null if there is no room for it.
  KeptPlace* at(const Eigen::Vector3d& p) noexcept {
    const std::array<int, 3> cell = cell_of(p);
    std::size_t i = slot_of(cell);
    while (places_[i].count > 0 && places_[i].cell != cell) i = (i + 1) % places_.size();
    if (places_[i].count > 0) return &places_[i];
    if (2 * used_ >= places_.size()) return nullptr;
    ++used_;
    places_[i].cell = cell;
    places_[i].count = 1;
    return &places_[i];
  }

  // Calls f(place) for what was visited in the cube of p and the 26 about it.
  template <typename F>
  void around(const Eigen::Vector3d& p, const F& f) const noexcept {
    const std::array<int, 3> c = cell_of(p);
    for (int n = 0; n < 27; ++n) {
      const std::array<int, 3> cell{c[0] + n % 3 - 1, c[1] + n / 3 % 3 - 1, c[2] + n / 9 - 1};
      std::size_t i = slot_of(cell);
      while (places_[i].count > 0 && places_[i].cell != cell) i = (i + 1) % places_.size();
      if (places_[i].count > 0) f(places_[i]);
    }
  }

 private:
  std::array<int, 3> cell_of(const Eigen::Vector3d& p) const noexcept {
    const auto index = [&](double x) { return static_cast<int>(std::floor(x / cell_)); };
    return {index(p.x()), index(p.y()), index(p.z())};
  }
  std::size_t slot_of(const std::array<int, 3>& c) const noexcept {
    const auto x = static_cast<std::uint64_t>(c[0]) * 0x9E3779B97F4A7C15u ^
                   static_cast<std::uint64_t>(c[1]) * 0xC2B2AE3D27D4EB4Fu ^
                   static_cast<std::uint64_t>(c[2]) * 0x165667B19E3779F9u;
    return static_cast<std::size_t>((x >> 20) % places_.size());
  }

  double cell_;
  std::size_t used_ = 0;
  std::vector<KeptPlace> places_;
};

}  // namespace impedraw
