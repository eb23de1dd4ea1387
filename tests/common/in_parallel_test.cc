#include "impedraw/common/in_parallel.h"

#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

class InParallel : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { parallel_threads = GetParam(); }
  void TearDown() override { parallel_threads = 0; }
};

TEST_P(InParallel, DoesEachPieceOnce) {
  for (const int n : {0, 1, 2, 1000}) {
    std::vector<int> times(static_cast<std::size_t>(n), 0);
    in_parallel(n, [&](int i) { ++times[static_cast<std::size_t>(i)]; });
    EXPECT_EQ(times, std::vector<int>(static_cast<std::size_t>(n), 1)) << n;
  }
}

TEST_P(InParallel, ThrowsWhatTheFirstPieceThrew) {
  for (int round = 0; round < 50; ++round) {
    try {
      in_parallel(100, [](int i) {
        if (i >= 17) throw std::runtime_error(std::to_string(i));
      });
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "17");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Threads, InParallel, testing::Values(0, 1, 2, 3));

}  // namespace
}  // namespace impedraw
