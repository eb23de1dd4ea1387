// Between two threads nothing is lost, torn, or taken twice. exchange_tsan_test runs the same under
// ThreadSanitizer.
#include "impedraw/common/exchange.h"

#include <array>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

TEST(Queue, GivesInOrderAndSaysWhenItIsFull) {
  Queue<int, 4> queue;
  int value = 0;
  EXPECT_FALSE(queue.take(&value));
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(queue.give(10 * round + i));
    EXPECT_FALSE(queue.give(99));
    for (int i = 0; i < 4; ++i) {
      EXPECT_TRUE(queue.take(&value));
      EXPECT_EQ(value, 10 * round + i);
    }
    EXPECT_FALSE(queue.take(&value));
  }
}

TEST(Queue, LosesNothingBetweenTwoThreads) {
  constexpr int kAll = 20000;
  Queue<std::array<int, 8>, 64> queue;
  std::thread giver([&] {
    for (int i = 0; i < kAll; ++i) {
      std::array<int, 8> value;
      value.fill(i);
      while (!queue.give(value)) std::this_thread::yield();
    }
  });
  for (int i = 0; i < kAll; ++i) {
    std::array<int, 8> value{};
    while (!queue.take(&value)) std::this_thread::yield();
    for (const int part : value) ASSERT_EQ(part, i);
  }
  giver.join();
}

TEST(Latest, IsTheLastThatWasGiven) {
  Latest<int> latest;
  EXPECT_FALSE(latest.refresh());
  EXPECT_EQ(latest.value(), 0);
  for (const int value : {1, 2, 3}) {
    latest.slot() = value;
    latest.give();
  }
  EXPECT_EQ(latest.value(), 0) << "until it is refreshed";
  EXPECT_TRUE(latest.refresh());
  EXPECT_EQ(latest.value(), 3);
  EXPECT_FALSE(latest.refresh());
  EXPECT_EQ(latest.value(), 3);
}

// Each value that is seen is whole and newer than the one before. Its slots own memory, which the
// giver frees as it writes.
TEST(Latest, IsWholeBetweenTwoThreads) {
  constexpr int kAll = 20000;
  struct Value {
    std::array<int, 8> parts{};
    std::shared_ptr<const int> owned;
  };
  Latest<Value> latest;
  std::thread giver([&] {
    for (int i = 1; i <= kAll; ++i) {
      latest.slot().parts.fill(i);
      latest.slot().owned = std::make_shared<const int>(i);
      latest.give();
      if (i % 16 == 0) std::this_thread::yield();
    }
  });
  int last = 0;
  while (last < kAll) {
    if (!latest.refresh()) {
      std::this_thread::yield();
      continue;
    }
    const Value& now = latest.value();
    ASSERT_GT(now.parts[0], last);
    last = now.parts[0];
    for (const int part : now.parts) ASSERT_EQ(part, last);
    ASSERT_EQ(*now.owned, last);
  }
  giver.join();
}

}  // namespace
}  // namespace impedraw
