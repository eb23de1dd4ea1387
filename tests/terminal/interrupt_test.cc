#include "impedraw/terminal/interrupt.h"

#include <gtest/gtest.h>

#include <csignal>

namespace impedraw {
namespace {

TEST(Interrupt, FirstSignalSetsTheFlag) {
  for (const auto& [signal, code] : {std::pair{SIGINT, 130}, std::pair{SIGTERM, 143}}) {
    Interrupt interrupt;
    EXPECT_FALSE(interrupt.requested());
    EXPECT_EQ(interrupt.exit_code(), 0);
    std::raise(signal);
    EXPECT_TRUE(interrupt.requested());
    EXPECT_EQ(interrupt.exit_code(), code);
  }
  Interrupt fresh;
  EXPECT_FALSE(fresh.requested()) << "a new one starts without the old one's signal";
}

TEST(InterruptDeathTest, SecondSignalEndsTheProgram) {
  EXPECT_EXIT(
      {
        Interrupt interrupt;
        std::raise(SIGINT);
        std::raise(SIGINT);
      },
      ::testing::KilledBySignal(SIGINT), "");
}

TEST(InterruptDeathTest, WhatWasInForceIsPutBack) {
  EXPECT_EXIT(
      {
        { Interrupt interrupt; }
        std::raise(SIGTERM);
      },
      ::testing::KilledBySignal(SIGTERM), "");
}

}  // namespace
}  // namespace impedraw
