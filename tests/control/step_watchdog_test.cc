// Consecutive late steps, a single stall, an invalid time.
#include "impedraw/control/step_watchdog.h"

#include <cmath>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

TEST(StepWatchdog, TripsOnLateStepsInARow) {
  StepWatchdog dog({1e-3, 5, 0.02});
  for (int i = 0; i < 100; ++i)
    EXPECT_FALSE(dog.update(i % 5 == 4 ? 0.5e-3 : 5e-3)) << "never five in a row";
  EXPECT_EQ(dog.late(), 80);
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(dog.update(1.1e-3));
  EXPECT_TRUE(dog.update(1.1e-3));
  EXPECT_TRUE(dog.update(0.1e-3)) << "it stays so";
  dog.reset();
  EXPECT_FALSE(dog.tripped());
  EXPECT_EQ(dog.late(), 0);
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(dog.update(1.1e-3)) << "the settings outlive the reset";
  EXPECT_TRUE(dog.update(1.1e-3));
}

TEST(StepWatchdog, TripsOnASingleStall) {
  StepWatchdog dog({1e-3, 5, 0.02});
  EXPECT_FALSE(dog.update(1e-3)) << "at the limit is in time";
  EXPECT_EQ(dog.late(), 0);
  EXPECT_FALSE(dog.update(0.0199));
  EXPECT_TRUE(dog.update(0.02));
  EXPECT_EQ(dog.late(), 2);
}

TEST(StepWatchdog, ATimeThatIsNotANumberIsAStall) {
  StepWatchdog dog;
  EXPECT_TRUE(dog.update(std::nan("")));
  EXPECT_EQ(dog.late(), 1);
  dog.reset();
  EXPECT_TRUE(dog.update(INFINITY));
}

}  // namespace
}  // namespace impedraw
