#include "impedraw/drawing/bounded.h"

#include <atomic>
#include <memory>
#include <stdexcept>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

TEST(Bounded, WorkIsDoneAbandonedOrThrows) {
  int done = 0;
  EXPECT_TRUE(done_within(10, [&] { ++done; }));
  EXPECT_EQ(done, 1);
  EXPECT_THROW(done_within(10, [] { throw std::runtime_error("no"); }), std::runtime_error);
  const auto stop = std::make_shared<std::atomic<bool>>(false);
  EXPECT_FALSE(done_within(0.05, [stop] {
    while (!*stop) {
    }
  }));
  *stop = true;
}

}  // namespace
}  // namespace impedraw
