// Arms and sensors that lie: each is named, damped by what can be true alone, and zero beyond
// gravity is sent last.
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/run/monitors/reading_monitor.h"
#include "impedraw/run/simulated_arm.h"
#include "run/prepared.h"
#include "seeds.h"

namespace impedraw {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

// The simulated arm as `lie` tells it. Notes what it is sent beyond gravity.
class Liar : public Driver {
 public:
  using Lie = std::function<void(ArmState*)>;
  // The torque that acts, of the one commanded, the weight's, and the time.
  using Drive = std::function<JointVector(JointVector, const JointVector&, double)>;
  Liar(Prepared& e, Lie lie = {}, bool moves = true, Drive drive = {})
      : inner_(e, e.belief.start_q, Disturbances(e.scenario, e.plan.path)),
        lie_(std::move(lie)),
        drive_(std::move(drive)),
        moves_(moves),
        state_(e.belief.arm.joints()) {}

  DriverInfo info() const override { return inner_.info(); }
  void start() override { inner_.start(); }
  const ArmState& read() noexcept override {
    const double next = state_.time + inner_.info().period;
    if (moves_ || !begun_)
      state_ = inner_.read();
    else  // brakes that nobody opened
      state_.time = state_.state_time = state_.wrench_time = next;
    begun_ = true;
    if (lie_) lie_(&state_);
    return state_;
  }
  void command(const JointVector& tau, const JointVector& gravity) noexcept override {
    sent.push_back((tau - gravity).cwiseAbs().maxCoeff());
    if (moves_) inner_.command(drive_ ? drive_(tau, gravity, state_.time) : tau, gravity);
  }
  const std::string& fault() const noexcept override { return inner_.fault(); }
  void stop() noexcept override { inner_.stop(); }
  const GroundTruth* truth() const noexcept override { return inner_.truth(); }

  std::vector<double> sent;  // largest |τ − g| of a cycle [Nm]

 private:
  SimulatedArm inner_;
  Lie lie_;
  Drive drive_;
  bool moves_, begun_ = false;
  ArmState state_;
};

// When the fault was found, as its text tells [s].
double found_at(const RunOutcome& outcome) {
  const std::size_t at = outcome.cause.find("t = ");
  return at == std::string::npos ? -1.0 : std::stod(outcome.cause.substr(at + 4));
}

// From then on at most 0.5 s pass with no torque above `most`, and zero is the last.
void expect_damped(const Liar& arm, const RunOutcome& outcome, double most) {
  EXPECT_EQ(outcome.end, RunEnd::stopped);
  const double found = found_at(outcome);
  ASSERT_GE(found, 0.0) << outcome.cause;
  EXPECT_LE(outcome.simulated, found + 0.51);
  ASSERT_FALSE(arm.sent.empty());
  EXPECT_EQ(arm.sent.back(), 0.0);
  for (auto i = static_cast<std::size_t>(std::llround(found / 1e-3)) + 1; i < arm.sent.size(); ++i)
    ASSERT_LE(arm.sent[i], most) << i;
}

TEST(Lies, OfTheScenarioAreNamed) {
  const struct {
    const char* kind;
    const char* cause;
    double found;  // after so long at the latest [s]
    double most;   // torque beyond gravity that is sent from then on [Nm]
  } cases[] = {
      {"jumped_state", "the position of joint 1 jumped by 0.5", 0.002, 5.0},
      {"drifting_state", "the positions of joint 1 contradict its speed", 0.5, 30.0},
      {"standing_state", "", 0.5, 250.0},
      {"false_speed", "joint 1 turns at 9.00 rad/s, which its positions contradict", 0.002, 5.0},
      {"false_wrench", "fence.force: the force on the tip was 20", 0.005, 250.0},
      {"future_wrench", "the wrench is stamped 3600.000 s ahead of the arm's clock", 0.002, 5.0},
      {"nan_wrench", "numbers that are not finite", 0.21, 1e9},
      {"stale_state", "joint states that are stale", 0.31, 1e9}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.kind);
    Prepared e = prepared(
        "bowl-sine", {std::string("faults=[{kind: ") + c.kind + ", start: 0.4, duration: 1000}]"});
    const double begun = time_at(e.plan.path, 0.4);
    Liar arm(e);
    const RunOutcome outcome = run(e, arm, {}, 0.0);
    EXPECT_EQ(outcome.end, RunEnd::stopped);
    EXPECT_THAT(outcome.cause, HasSubstr(c.cause));
    if (*c.cause == '\0') {  // whichever of what it does shows first
      EXPECT_THAT(outcome.cause,
                  AnyOf(HasSubstr("does not move"), HasSubstr("fence."), HasSubstr("contradict")));
    }
    EXPECT_GE(found_at(outcome), begun - 1e-3);
    EXPECT_LE(found_at(outcome), begun + c.found);
    if (c.most < 1e9) expect_damped(arm, outcome, c.most);
  }
}

// With a sensor the first such reading was taken for hammering, and one at the end of the sensor's
// range for none at all: the run went on for ever with the last wrench before it.
TEST(Lies, AFalseWrenchOfASensorIsNamed) {
  for (const auto& [name, cause] :
       {std::pair("bowl-sine-sensor", "fence.force: the force on the tip was"),
        {"bowl-sine-touch", "fence.force: the force on the tip was"},
        {"bowl-sine-realistic", "the wrench sensor stays at the end of its range (100 N"},
        {"bowl-sine-real", "the wrench sensor stays at the end of its range (100 N"}}) {
    SCOPED_TRACE(name);
    Prepared e = prepared(name, {"faults=[{kind: false_wrench, start: 0.4, duration: 1000}]"});
    const double begun = time_at(e.plan.path, 0.4);
    Liar arm(e);
    const RunOutcome outcome = run(e, arm, {}, 0.0);
    EXPECT_EQ(outcome.end, RunEnd::stopped);
    EXPECT_THAT(outcome.cause, testing::StartsWith(cause));
    EXPECT_LE(found_at(outcome), begun + 0.1);
    EXPECT_EQ(arm.sent.back(), 0.0);
  }
}

// A dead sensor reads zero. The pen then pressed with 68 N and more, part after part, and the run
// finished.
TEST(Lies, AWrenchThatIsZeroForEverIsNamed) {
  for (const char* name : {"bowl-sine", "bowl-sine-sensor", "bowl-sine-real", "bowl-sine-touch"}) {
    for (const double share : {-0.1, 0.1, 0.6}) {
      Prepared e = prepared(name);
      const double from = time_at(e.plan.path, share);
      SCOPED_TRACE(testing::Message() << name << " from " << from << " s");
      Liar arm(e, [&](ArmState* s) {
        if (s->time >= from) s->wrench.setZero();
      });
      double hardest = 0.0;
      RunHooks hooks;
      hooks.row = [&](const LogRow& row) { hardest = std::max(hardest, row.contact_force.norm()); };
      const RunOutcome outcome = run(e, arm, {}, 0.0, hooks);
      EXPECT_LT(hardest, 65.0) << outcome.cause;
      if (hardest == 0.0) continue;  // the pen never came down: nothing is drawn, which is said
      EXPECT_EQ(outcome.end, RunEnd::stopped);
      EXPECT_THAT(outcome.cause, AnyOf(HasSubstr("of which the measured wrench tells"),
                                       HasSubstr("the wrench stands still")));
    }
  }
}

// The pen is far behind on its way down, but nothing holds it: 19 N are the joints'.
TEST(Lies, FrictionInTheJointsMakesNoWrenchALie) {
  Prepared e = prepared("bowl-sine-touch", {"world.joint_friction=4"});
  Liar arm(e);
  EXPECT_THAT(run(e, arm, {}, 0.0).cause, Not(HasSubstr("the measured wrench tells")));
}

// With 60 N on the arm the canvas is felt all the same.
TEST(Lies, AHandOnTheArmMakesNoWrenchALie) {
  for (const char* link : {"link_5", "link_6"}) {
    SCOPED_TRACE(link);
    Prepared e = prepared("bowl-sine", {std::string("pushes=[{link: ") + link +
                                        ", force: 60, direction: [0, 0, 1], middle: 0.5, "
                                        "duration: 2}]"});
    Liar arm(e);
    EXPECT_EQ(run(e, arm, {}, 0.0).end, RunEnd::finished);
  }
}

// Estimated from positions that no longer came, the speed grew: a joint was braked that did not
// turn, up to 20 rad/s and 155 N on the canvas.
TEST(Lies, AStaleStateIsNotDamped) {
  for (const double share : {0.0, 0.2, 0.5}) {
    SCOPED_TRACE(share);
    Prepared e = prepared(
        "bowl-sine-real",
        {"faults=[{kind: stale_state, start: " + std::to_string(share) + ", duration: 1000}]"});
    double hardest = 0.0;
    RunHooks hooks;
    hooks.row = [&](const LogRow& row) { hardest = std::max(hardest, row.contact_force.norm()); };
    Liar arm(e);
    const RunOutcome outcome = run(e, arm, {}, 0.0, hooks);
    EXPECT_THAT(outcome.cause, HasSubstr("joint states that are stale"));
    EXPECT_LT(hardest, 15.0);
  }
}

// The pen has left the surface by then. Without an end, the drawing went on in the air, 17 mm off,
// until a link met the canvas.
TEST(Lies, AWrenchThatDoesNotComeBackEndsTheRun) {
  for (const char* name : {"bowl-sine", "bowl-sine-realistic", "bowl-sine-real"}) {
    SCOPED_TRACE(name);
    Prepared e = prepared(name, {"faults=[{kind: stale_wrench, start: 0.4, duration: 1000}]"});
    const double begun = time_at(e.plan.path, 0.4);
    Liar arm(e);
    const RunOutcome outcome = run(e, arm, {}, 0.0);
    EXPECT_EQ(outcome.end, RunEnd::stopped);
    EXPECT_THAT(outcome.cause, HasSubstr("no fresh wrench came for 1.0 s"));
    EXPECT_LE(found_at(outcome), begun + 1.1);
  }
}

// Digits of a stamp of 1e300 s filled a page.
TEST(Lies, AClockBeyondReasonIsToldInAFewDigits) {
  for (const int which : {0, 1, 2}) {
    Prepared e = prepared("bowl-sine");
    Liar arm(e, [&](ArmState* s) {
      if (s->time < 0.1) return;
      (which == 0 ? s->time : which == 1 ? s->state_time : s->wrench_time) = 1e300;
    });
    const RunOutcome outcome = run(e, arm, {}, 0.0);
    EXPECT_THAT(outcome.cause, HasSubstr("e+300 s"));
    EXPECT_LT(outcome.cause.size(), 120u) << outcome.cause;
  }
}

TEST(Lies, AnArmThatStandsStillIsNotPlayedThePlan) {
  for (const char* name : {"bowl-sine", "bowl-sine-natural", "bowl-sine-realistic", "bowl-m-blind",
                           "bowl-sine-touch", "wall"}) {
    for (const double force : {0.0, 5.0}) {
      SCOPED_TRACE(testing::Message() << name << " " << force << " N");
      Prepared e = prepared(name);
      Liar arm(
          e,
          [&](ArmState* s) {
            if (force > 0.0) s->wrench << 0.0, 0.0, force, 0.0, 0.0, 0.0;
          },
          false);
      const RunOutcome outcome = run(e, arm, {}, 0.0);
      EXPECT_EQ(outcome.end, RunEnd::stopped);
      EXPECT_THAT(outcome.cause, AnyOf(HasSubstr("does not move"), HasSubstr("fence.lag")));
      EXPECT_LT(outcome.simulated, e.plan.path.duration());
      EXPECT_EQ(arm.sent.back(), 0.0);
    }
  }
}

// Random joints, sizes and times.
TEST(Lies, OfAnySizeThatNoArmCanMoveAreNamed) {
  const unsigned seed = 36;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (unsigned i = 0; i < seeds(12, 200); ++i) {
    const int kind = static_cast<int>(i % 4), j = std::uniform_int_distribution<int>(0, 6)(random);
    const double from = draw(0.5, 8.0), sign = draw(-1.0, 1.0) < 0.0 ? -1.0 : 1.0;
    const double jump = sign * draw(0.05, 2.0), rate = sign * draw(0.2, 1.0),
                 speed = sign * draw(10.0, 30.0), force = sign * draw(170.0, 400.0);
    SCOPED_TRACE(testing::Message()
                 << "kind " << kind << ", joint " << j + 1 << ", from " << from << " s: " << jump
                 << " rad, " << rate << " rad/s, " << speed << " rad/s, " << force << " N");
    Prepared e = prepared("bowl-sine");
    Liar arm(e, [&](ArmState* s) {
      if (s->time < from) return;
      if (kind == 0) s->q[j] += jump;
      if (kind == 1) s->q[j] += rate * (s->time - from);
      if (kind == 2) s->v[j] += speed;
      if (kind == 3) s->wrench[j % 3] += force;
    });
    const RunOutcome outcome = run(e, arm, {}, 0.0);
    EXPECT_THAT(outcome.cause, HasSubstr(kind == 3 ? "fence.force: the force on the tip was"
                                                   : "joint " + std::to_string(j + 1)));
    EXPECT_LE(found_at(outcome), from + (kind == 1 ? 0.8 : 0.005)) << outcome.cause;
    expect_damped(arm, outcome, kind == 3 ? 250.0 : 60.0);
  }
}

// Readings that stand still while the arm moves on, of one joint or of all. Unnoticed, frozen
// positions make the pen hit the canvas with 180 N, and frozen speeds with 245 N.
TEST(Lies, ReadingsThatStandStillAreNamedBeforeThePenHitsTheCanvas) {
  const unsigned seed = 36;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  const char* names[] = {"bowl-sine", "bowl-sine-natural", "bowl-sine-realistic"};
  for (unsigned i = 0; i < seeds(8, 120); ++i) {
    const double share = std::uniform_real_distribution<double>(0.1, 0.9)(random);
    const int only = std::uniform_int_distribution<int>(-7, 6)(random);  // < 0: all
    const bool q_stands = i % 4 < 3, v_stands = i % 4 != 1, v_zero = i % 4 == 2;
    const char* const name = names[i % 3];
    SCOPED_TRACE(testing::Message()
                 << name << " " << share << ", joint " << only + 1 << " " << i % 4);
    Prepared e = prepared(name);
    const double from = time_at(e.plan.path, share);
    std::optional<ArmState> last;
    Liar arm(e, [&](ArmState* s) {
      if (s->time < from) return;
      if (!last) last = *s;
      for (Eigen::Index j = 0; j < s->q.size(); ++j) {
        if (only >= 0 && j != only) continue;
        if (q_stands) s->q[j] = last->q[j];
        if (v_stands) s->v[j] = v_zero ? 0.0 : last->v[j];
      }
    });
    double hardest = 0.0;
    RunHooks hooks;
    hooks.row = [&](const LogRow& row) { hardest = std::max(hardest, row.contact_force.norm()); };
    const RunOutcome outcome = run(e, arm, {}, 0.0, hooks);
    EXPECT_THAT(outcome.cause, HasSubstr("joint"));
    EXPECT_LT(hardest, q_stands ? 12.0 : 40.0);
    // A light wrist joint that froze slowly may run away first, to the simulator's own end.
    if (outcome.cause.find("went unstable") == std::string::npos) {
      EXPECT_EQ(arm.sent.back(), 0.0) << outcome.cause;
    }
  }
}

// Two joints of 2 kg m². A motion at 0.1 rad/s, begun from rest, that ends within a reading takes
// 200 Nm.
TEST(Lies, ASlowArmWhosePositionsStandStillIsStoppedAtOnce) {
  for (const char* name : {"bowl-sine", "bowl-sine-natural", "bowl-sine-realistic"}) {
    SCOPED_TRACE(name);
    Prepared e = prepared(name, {"path.draw_speed=0.005",
                                 "faults=[{kind: standing_state, start: 0.03, duration: 1000}]"});
    double hardest = 0.0;
    RunHooks hooks;
    hooks.row = [&](const LogRow& row) { hardest = std::max(hardest, row.contact_force.norm()); };
    Liar arm(e);
    const RunOutcome outcome = run(e, arm, {}, 0.0, hooks);
    EXPECT_THAT(outcome.cause, HasSubstr("the arm does not move, although joint"));
    EXPECT_LT(hardest, 8.0);
  }
}

// Unnoticed, a wrench with the wrong sign makes the arm press with 250 N, and a torque with 290 N.
TEST(Lies, AWrongSignIsNamedBeforeThePenHitsTheCanvas) {
  const unsigned seed = 36;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  const char* names[] = {"bowl-sine", "bowl-sine-realistic", "bowl-sine-real", "bowl-m-elastic"};
  for (unsigned i = 0; i < seeds(10, 120); ++i) {
    const double share = std::uniform_real_distribution<double>(0.1, 0.9)(random);
    const int only = std::uniform_int_distribution<int>(-1, 6)(random);  // −1: all joints
    const bool wrench = i % 2 == 0, always = i % 4 == 0;
    const char* const name = names[i / 2 % 4];
    SCOPED_TRACE(testing::Message()
                 << name << (wrench ? " wrench " : " torque ") << share << ", joint " << only + 1);
    Prepared e = prepared(name);
    const double from = always ? 0.0 : time_at(e.plan.path, share);
    Liar arm(
        e,
        [&](ArmState* s) {
          if (wrench && s->time >= from) s->wrench = -s->wrench;
        },
        true,
        [&](JointVector tau, const JointVector& gravity, double time) {
          for (Eigen::Index j = 0; j < tau.size() && !wrench && time >= from; ++j)
            if (only < 0 || j == only) tau[j] = 2.0 * gravity[j] - tau[j];
          return tau;
        });
    double hardest = 0.0;
    RunHooks hooks;
    hooks.row = [&](const LogRow& row) { hardest = std::max(hardest, row.contact_force.norm()); };
    const RunOutcome outcome = run(e, arm, {}, 0.0, hooks);
    EXPECT_EQ(outcome.end, RunEnd::stopped);
    EXPECT_THAT(outcome.cause,
                AnyOf(HasSubstr("wrench"), HasSubstr("against its torque"), HasSubstr("jumped")));
    EXPECT_LT(hardest, wrench ? 20.0 : 45.0);
  }
}

// Its law answers with several times the wrench, which hides a part of what nothing explains.
TEST(Lies, OfALightPadAreNamed) {
  Prepared e = prepared("bowl-sine-real", {"tool.kind=pad", "control.inertia=light_normal",
                                           "control.inertia_scale=0.15"});
  Liar arm(e, [](ArmState* s) { s->wrench = -s->wrench; });
  EXPECT_THAT(run(e, arm, {}, 0.0).cause, HasSubstr("against the measured wrench"));
}

TEST(Lies, AWrenchThatStandsStillIsNamedAsThePenIsLifted) {
  Prepared e = prepared("bowl-sine");
  const double from = time_at(e.plan.path, 0.5);
  std::optional<ArmState> last;
  Liar arm(e, [&](ArmState* s) {
    if (s->time < from) return;
    if (!last) last = *s;
    s->wrench = last->wrench;
  });
  const RunOutcome outcome = run(e, arm, {}, 0.0);
  EXPECT_THAT(outcome.cause, HasSubstr("the wrench stands still"));
  EXPECT_LT(outcome.simulated, e.plan.path.duration() + 5.0);
  EXPECT_EQ(arm.sent.back(), 0.0);
}

}  // namespace
}  // namespace impedraw
