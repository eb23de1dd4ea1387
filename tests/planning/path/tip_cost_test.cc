// A large drawing: asking its path for the tip at a time does not touch the heap.
#include <atomic>
#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

#include "impedraw/planning/path/tip_planner.h"
#include "planning/surfaces.h"

static std::atomic<long> allocations{0};

[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace impedraw {
namespace {

using Eigen::Vector2d;
TEST(TipCost, HundredFiftyThousandPoints) {
  std::vector<PlacedStroke> strokes;
  for (int k = 0; k < 1500; ++k) {
    std::vector<Vector2d> points;
    const Vector2d centre =
        0.12 * std::sqrt(k / 1500.0) * Vector2d(std::cos(2.4 * k), std::sin(2.4 * k)) +
        Vector2d(0.6, 0);
    for (int i = 0; i < 100; ++i)
      points.push_back(centre + 0.004 * Vector2d(std::cos(0.063 * i), std::sin(0.126 * i)));
    strokes.push_back(surfaces::line(points));
  }
  const TipPath path = plan_tip_path(strokes, surfaces::bowl);
  double sum = 0;
  constexpr int kCalls = 200000;
  const long before = allocations;
  for (int i = 0; i < kCalls; ++i)  // in order, as the loop asks
    sum += path.at(path.duration() * i / kCalls).reference.p_WD.x();
  EXPECT_EQ(allocations, before);
  ::operator delete(::operator new(3));  // not left out by a compiler, as a new-expression may be
  EXPECT_EQ(allocations, before + 1);    // the count does count
  EXPECT_GT(sum, 0);
}

}  // namespace
}  // namespace impedraw
