// Several pens in one drawing: their order, what is asked of a person, and the length of a tip that
// nobody measured. The length that the world has is the oracle.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <fstream>

#include "impedraw/experiment/prepare.h"
#include "impedraw/log/run_data.h"
#include "impedraw/run/pen_changes.h"
#include "impedraw/run/simulated_arm.h"
#include "log/run_columns.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

class PenChangesTest : public ScratchFolder {
 protected:
  // Three layers in the bowl: red, blue, red again.
  Prepared layers(const std::string& pens, std::vector<std::string> more = {},
                  const std::string& base = "bowl") {
    std::ofstream(folder_ / "layers.svg")
        << R"(<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"
             fill="none" stroke-width="0.5">
          <g id="a" stroke="red"><path d="M5 5 H55"/></g>
          <g id="b" stroke="blue"><path d="M5 20 C20 10 40 30 55 20"/><path d="M5 30 H55"/></g>
          <g id="c" stroke="red"><path d="M5 45 H55"/></g></svg>)";
    std::ofstream(folder_ / "pens.yaml")
        << "extends: " << fs::absolute("scenarios/" + base + ".yaml").string()
        << "\ndrawing: {svg: layers.svg, placement: {fit_radius: 0.06}}\n"
        << pens;
    DrawOptions options;
    options.scenario = folder_ / "pens.yaml";
    options.assignments = std::move(more);
    return prepare(resolve(options));
  }
  RunHooks recording() {
    RunHooks hooks;
    hooks.pause = [this](const std::string& asks) { asked_.push_back(asks); };
    hooks.holds_pen = [this](const HeldPen& pen) { held_.push_back(pen); };
    return hooks;
  }
  // RMS distance of a stroke's ink from the line asked for, seen along the drawing axis, but for
  // its first and last 3 mm [m].
  double off_line(const Experiment& e, int stroke) const {
    const RunData run = read_run(log());
    const PlacedStroke& asked = e.plan.strokes[static_cast<std::size_t>(stroke)];
    double sum = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < run.stroke.size(); ++i) {
      if (run.stroke[i] != stroke || !std::isfinite(run.contact_point[i].x())) continue;
      const Eigen::Vector2d p = run.contact_point[i].head<2>();
      const double along = nearest_place(asked, p);
      if (along < 3e-3 || along > plane_length(asked) - 3e-3) continue;
      sum += (p - place_on(asked, along).p_P).squaredNorm();
      ++count;
    }
    return std::sqrt(sum / count);
  }
  fs::path log() const { return folder_ / "run.h5"; }

  std::vector<std::string> asked_;
  std::vector<HeldPen> held_;
};

constexpr const char* kPens =
    "pens: [{layer: a, colour: red}, {layer: b, colour: blue, width: 0.5}, {layer: c, colour: "
    "red}]\n";

TEST_F(PenChangesTest, APersonIsAskedBetweenPensAlone) {
  Prepared e = layers(kPens);
  const RunOutcome outcome = run(e, log(), 0.0, recording());
  EXPECT_EQ(outcome.end, RunEnd::finished) << outcome.cause;
  EXPECT_THAT(asked_, ElementsAre(HasSubstr("'b'"), HasSubstr("'a'")));
  EXPECT_TRUE(outcome.lacking.empty());
  std::vector<int> numbers;
  for (const HeldPen& pen : held_) numbers.push_back(pen.number);
  EXPECT_EQ(numbers.front(), 0);
  EXPECT_EQ(numbers.back(), 0) << "layers a and c have the same pen";
  EXPECT_THAT(std::vector<int>(numbers), testing::Contains(1));
}

TEST_F(PenChangesTest, AnotherForceIsNoOtherPen) {
  Prepared e = layers("pens: [{layer: a, force: 3}, {layer: c, speed: 0.04}]\n");
  EXPECT_FALSE(needs_pens(e));
  EXPECT_EQ(run(e, log(), 0.0, recording()).end, RunEnd::finished);
  EXPECT_TRUE(asked_.empty());
}

// The new tip is longer, or shorter, than anybody knows. With a sensor that has noise, bias, drift
// and delay, seen surface and joints that are not quite as believed, too.
TEST_F(PenChangesTest, ATouchFindsANewTipAndTheDrawingGoesOn) {
  struct Case {
    const char* scenario;
    double longer;  // [m]
  };
  for (const Case& c : {Case{"bowl", 1.5e-3}, {"bowl", -4e-3}, {"bowl-sine-realistic", 1.5e-3}}) {
    SCOPED_TRACE(c.scenario);
    held_.clear();
    Prepared e =
        layers(kPens, {"pen.check=true", fmt::format("world.errors.pens_longer=[0, {}]", c.longer)},
               c.scenario);
    const RunOutcome outcome = run(e, log(), 0.0, recording());
    ASSERT_EQ(outcome.end, RunEnd::finished) << outcome.cause;
    EXPECT_TRUE(outcome.lacking.empty());
    double found = 0.0;
    for (const HeldPen& pen : held_)
      if (pen.number == 1) found = pen.longer;
    EXPECT_NEAR(found, c.longer, 0.2e-3);
    EXPECT_NEAR(held_.back().longer, 0.0, 0.2e-3) << "the first pen again";
    for (int stroke = 0; stroke < 4; ++stroke) EXPECT_LT(off_line(e, stroke), 0.1e-3) << stroke;
  }
}

TEST_F(PenChangesTest, ResumesWithThePenThatIsIn) {
  Prepared e = layers(kPens, {"pen.check=true", "world.errors.pens_longer=[0, 0.0015]"});
  RunHooks hooks = recording();
  hooks.progress = [&](const RunProgress&) {};
  hooks.interrupted = [&] { return asked_.size() == 1 && held_.size() > 3; };
  ASSERT_EQ(run(e, log(), 0.0, hooks).end, RunEnd::interrupted);
  const HeldPen in = held_.back();
  ASSERT_EQ(in.number, 1);
  std::optional<Resumption> rest = read_resumption(e, log());
  ASSERT_TRUE(rest);
  rest->pen = in;
  *rest->pen->spot -= 0.5e-3;  // the spot is where the earlier run felt it
  asked_.clear();
  const RunOutcome outcome = run(e, log(), 0.0, recording(), &*rest);
  EXPECT_EQ(outcome.end, RunEnd::finished) << outcome.cause;
  EXPECT_TRUE(outcome.lacking.empty());
  EXPECT_THAT(asked_, ElementsAre(HasSubstr("'a'"))) << "pen b is in, and is not asked for again";
  EXPECT_EQ(held_.back().number, 0);
  EXPECT_NEAR(held_.back().longer, 0.5e-3, 0.1e-3);
}

// A known spot tells the first pen's length, too. One that is not where it is said to be is found
// before a pen bends on it.
TEST_F(PenChangesTest, AKnownSpotChecksTheFirstPenToo) {
  const double z = layers(kPens).surface()(0.6, 0.0)->p_P.z();
  const auto with_spot = [&](double height) {
    held_.clear();
    Prepared e = layers(kPens, {"pen.check=true", "world.errors.pens_longer=[0.001, 0.003]",
                                fmt::format("pen.spot=[0.6, 0, {}]", height)});
    return run(e, log(), 0.0, recording());
  };
  const RunOutcome outcome = with_spot(z);
  EXPECT_EQ(outcome.end, RunEnd::finished) << outcome.cause;
  double least = 1.0, most = 0.0;
  for (const HeldPen& pen : held_) (pen.number == 1 ? most : least) = pen.longer;
  EXPECT_NEAR(least, 1e-3, 0.2e-3);
  EXPECT_NEAR(most, 3e-3, 0.2e-3);
  for (const double wrong : {-0.1, -0.022}) {
    const RunOutcome stopped = with_spot(z + wrong);
    EXPECT_EQ(stopped.end, RunEnd::stopped);
    EXPECT_THAT(stopped.cause, HasSubstr("pen.spot")) << wrong;
    double hardest = 0.0;
    for (const Eigen::Vector3d& f : read_rows(log()).contact_force)
      if (f.allFinite()) hardest = std::max(hardest, f.norm());
    EXPECT_LT(hardest, 40.0) << wrong;
  }
}

TEST_F(PenChangesTest, ACheckNeedsAWrench) {
  try {
    layers(kPens, {"pen.check=true", "control.wrench=none", "control.inertia=natural"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("pen.check needs a measured wrench"));
  }
}

}  // namespace
}  // namespace impedraw
