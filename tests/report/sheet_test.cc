// Ticks of an axis, whatever its range.
#include "impedraw/report/sheet.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

TEST(Ticks, RoundAndFew) {
  EXPECT_EQ(ticks(-1.5, 3.2, 4.7), (std::vector<double>{-1, 0, 1, 2, 3}));
  EXPECT_EQ(ticks(0, 45, 45), (std::vector<double>{0, 10, 20, 30, 40}));
  EXPECT_EQ(ticks(-90000, 100000, 190000), (std::vector<double>{-50000, 0, 50000, 100000}));
  EXPECT_TRUE(ticks(0.2, 0.8, 0.6).empty());
}

// A range that one step cannot be counted up in, and none at all.
TEST(Ticks, AnyRange) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (const double range : {1e-300, 1.0, 9.9e3, 1e9, 1e17, 1e300}) {
    for (const double low : {-0.5 * range, 0.0, 1e6, 1e17, 1e300}) {
      const std::vector<double> places = ticks(low, low + range, range);
      EXPECT_LE(places.size(), 11u) << low << ", " << range;
      for (std::size_t i = 1; i < places.size(); ++i) EXPECT_GE(places[i], places[i - 1]);
    }
  }
  EXPECT_TRUE(ticks(0, kInf, kInf).empty());
  EXPECT_TRUE(ticks(std::nan(""), 1, 1).empty());
}

}  // namespace
}  // namespace impedraw
