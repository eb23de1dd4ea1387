// The reaction to verdicts against the table of its header; and what the parts of a run decide.
#include <map>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/experiment/scenario.h"
#include "impedraw/run/reaction.h"
#include "impedraw/run/remaining.h"

namespace impedraw {
namespace {

using State = Reaction::State;
using testing::HasSubstr;
using testing::StartsWith;

constexpr double kCycle = 1e-3;
// From a state, under verdicts from hold to lose.
constexpr const char* kTable = R"(
  follow  follow  done   lift   brake  halt  damp  over
  lift    lift    lift   lift   brake  halt  damp  over
  brake   brake   brake  brake  brake  halt  damp  over
  rise    rise    rise   rise   brake  halt  damp  over
  halt    halt    halt   halt   halt   halt  damp  over
  damp    damp    damp   damp   damp   damp  damp  over
  over    over    over   over   over   over  over  over
)";

TEST(Reaction, FollowsItsTable) {
  const std::map<std::string, State> states = {{"follow", State::follow}, {"lift", State::lift},
                                               {"brake", State::brake},   {"rise", State::rise},
                                               {"halt", State::halt},     {"damp", State::damp},
                                               {"done", State::done},     {"over", State::over}};
  std::istringstream table(kTable);
  std::string from, to;
  int rows = 0;
  for (; table >> from; ++rows) {
    EXPECT_EQ(Reaction::next(states.at(from), Severity::none), states.at(from));
    for (int s = static_cast<int>(Severity::hold); s <= static_cast<int>(Severity::lose); ++s) {
      table >> to;
      EXPECT_EQ(Reaction::next(states.at(from), static_cast<Severity>(s)), states.at(to))
          << from << " " << s;
    }
  }
  EXPECT_EQ(rows, 7);
}

TEST(Reaction, KeepsTheFirstCauseAndAddsAHalt) {
  Ending ending;
  Reaction reaction(&ending);
  reaction.take({Severity::hold});
  EXPECT_EQ(ending.end, RunEnd::finished);
  reaction.take({Severity::lift, "the canvas ran away"});
  reaction.take({Severity::lift, "a late step"});
  EXPECT_EQ(ending.end, RunEnd::stopped);
  EXPECT_EQ(ending.cause, "the canvas ran away");
  reaction.take({Severity::halt, "a fence"});
  EXPECT_EQ(ending.cause, "the canvas ran away; then a fence");
  EXPECT_EQ(reaction.state(), State::halt);
}

TEST(Reaction, AHaltStopsARunThatAPersonInterrupted) {
  Ending ending;
  Reaction reaction(&ending);
  reaction.take({Severity::lift, "interrupted", RunEnd::interrupted});
  EXPECT_EQ(ending.end, RunEnd::interrupted);
  reaction.take({Severity::damp, "the clock stands still"});
  EXPECT_EQ(ending.end, RunEnd::stopped);
  EXPECT_EQ(ending.cause, "the clock stands still");
}

TEST(Reaction, ADrawingThatGoesOnKeepsTheCauseForItself) {
  Ending ending;
  Reaction reaction(&ending);
  reaction.take({Severity::brake, "joint 4 was too fast", RunEnd::finished});
  EXPECT_EQ(ending.end, RunEnd::finished);
  EXPECT_EQ(reaction.cause(), "joint 4 was too fast");
  reaction.take({Severity::lose, "no connection"});
  EXPECT_EQ(ending.cause, "no connection");
  EXPECT_EQ(reaction.state(), State::over);
  reaction.begin();
  EXPECT_EQ(reaction.state(), State::over);
}

// Calm below 5 % of the speed limits, at rest below 0.2 %, and in half a second at the latest.
TEST(Reaction, BrakesUntilTheMotionIsCalm) {
  const auto cycles = [](Verdict verdict, double share) {
    Ending ending;
    Reaction reaction(&ending);
    reaction.take(verdict);
    EXPECT_TRUE(reaction.brakes());
    int n = 1;
    while (!reaction.calms(share, kCycle)) ++n;
    EXPECT_EQ(reaction.state(), verdict.severity == Severity::halt ? State::over : State::rise);
    return n;
  };
  const Verdict fast{.severity = Severity::brake, .calm = JointSpeedShares::kCalm};
  EXPECT_EQ(cycles(fast, 0.04), 1);
  EXPECT_NEAR(cycles(fast, 0.06), 500, 1);
  EXPECT_NEAR(cycles({Severity::halt}, 0.04), 500, 1);
  EXPECT_EQ(cycles({Severity::halt}, 0.001), 1);
}

TEST(Reaction, AVerdictThatIsNotWorseDoesNotProlongTheBraking) {
  Ending ending;
  Reaction reaction(&ending);
  reaction.take({.severity = Severity::brake, .calm = JointSpeedShares::kCalm});
  reaction.take({Severity::lift, "a late step"});
  EXPECT_TRUE(reaction.calms(0.04, kCycle));
}

TEST(Verdict, TheWorseWinsAndOfTwoAlikeTheFirst) {
  const Verdict none, lift{Severity::lift, "a"}, other{Severity::lift, "b"}, halt{Severity::halt};
  EXPECT_FALSE(none);
  EXPECT_EQ(&worse(none, lift), &lift);
  EXPECT_EQ(&worse(lift, other), &lift);
  EXPECT_EQ(&worse(halt, lift), &halt);
}

TEST(BlockedPlaces, KeepsTwiceAsFarOffEachTimeAtTheSamePlace) {
  BlockedPlaces blocked;
  for (int i = 0; i < 6; ++i) blocked.add({3, 0.050, 0.052});
  for (int i = 0; i < 6; ++i) {
    const StrokePart& kept = blocked.parts()[static_cast<std::size_t>(i)];
    EXPECT_EQ(kept.stroke, 3);
    EXPECT_NEAR(kept.from, 0.049, 1e-12);
    const double beyond[] = {2e-3, 4e-3, 8e-3, 16e-3, 32e-3, 64e-3};
    EXPECT_NEAR(kept.to, 0.052 + beyond[i], 1e-12) << i;
  }
  blocked.add({3, 0.125, 0.125});
  EXPECT_NEAR(blocked.parts().back().to, 0.125 + 128e-3, 1e-12) << "within 10 mm of its end";
  blocked.add({3, 0.29, 0.29});
  EXPECT_NEAR(blocked.parts().back().to, 0.292, 1e-12) << "another place";
  blocked.add({4, 0.09, 0.09});
  EXPECT_NEAR(blocked.parts().back().to, 0.092, 1e-12) << "another stroke";
}

TEST(BlockedPlaces, LeavesRoomAroundWhatTheArmCannotFollow) {
  BlockedPlaces blocked;
  blocked.add_unreached({1, 0.02, 0.03});
  EXPECT_NEAR(blocked.parts()[0].from, 0.015, 1e-12);
  EXPECT_NEAR(blocked.parts()[0].to, 0.035, 1e-12);
  blocked.add_stroke({2, 0.0, 0.1});
  EXPECT_EQ(blocked.parts()[1].to, 0.1);
  while (!blocked.full()) blocked.add({0, 0.0, 0.0});
  EXPECT_EQ(blocked.parts().size(), BlockedPlaces::kMost);
}

// The ladder of joint_speed_shares.h names the default of a path's share.
TEST(JointSpeedShares, HasThePathsDefault) {
  EXPECT_EQ(PathSettings().joint_speed_share, JointSpeedShares::kPlanned);
}

}  // namespace
}  // namespace impedraw
