#include "impedraw/terminal/interrupt.h"

#include <gtest/gtest.h>

#include <csignal>

namespace impedraw {
namespace {

// Whatever started the tests.
[[maybe_unused]] const bool reset = [] {
  for (const int s : {SIGINT, SIGTERM, SIGHUP}) std::signal(s, SIG_DFL);
  return true;
}();

TEST(Interrupt, FirstSignalSetsTheFlag) {
  for (const auto& [signal, code] :
       {std::pair{SIGINT, 130}, std::pair{SIGTERM, 143}, std::pair{SIGHUP, 129}}) {
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

TEST(Interrupt, QuitIsAnEmergencyAndNoInterrupt) {
  Interrupt interrupt;
  EXPECT_FALSE(interrupt.emergency());
  std::raise(SIGQUIT);
  EXPECT_TRUE(interrupt.emergency());
  EXPECT_FALSE(interrupt.requested());
}

TEST(Interrupt, QuitCountsAfterAnInterruptToo) {
  Interrupt interrupt;
  std::raise(SIGINT);
  std::raise(SIGQUIT);
  EXPECT_TRUE(interrupt.emergency());
  EXPECT_EQ(interrupt.exit_code(), 130);
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

// A shell ignores SIGINT for what a script starts in the background.
TEST(Interrupt, AnIgnoredInterruptCounts) {
  std::signal(SIGINT, SIG_IGN);
  {
    Interrupt interrupt;
    std::raise(SIGINT);
    EXPECT_EQ(interrupt.exit_code(), 130);
  }
  EXPECT_EQ(std::signal(SIGINT, SIG_DFL), SIG_IGN) << "put back";
}

// As under nohup.
TEST(Interrupt, WhatIsIgnoredStaysIgnored) {
  const auto before = std::signal(SIGHUP, SIG_IGN);
  {
    Interrupt interrupt;
    std::raise(SIGHUP);
    EXPECT_FALSE(interrupt.requested());
    std::raise(SIGINT);
    EXPECT_EQ(interrupt.exit_code(), 130);
    std::raise(SIGHUP);
  }
  std::raise(SIGHUP);
  std::signal(SIGHUP, before);
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
