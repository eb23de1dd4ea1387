// Runs in several passes: gaps are redrawn and interrupted runs continue. Also drawings on inclined
// planes.
#include <algorithm>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drawn_scenario.h"
#include "impedraw/common/errors.h"
#include "impedraw/run/simulated_arm.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

double length_mm(const std::vector<StrokePart>& parts) {
  double sum = 0.0;
  for (const StrokePart& part : parts) sum += 1e3 * part.length();
  return sum;
}

// The arm's own signals find the same gap as the simulator's truth, and a second pass closes it.
TEST(Passes, WhatGotNoInkIsDrawnAgain) {
  const Figures once = draw_scenario("safety-no-cloud");
  ASSERT_EQ(once.outcome.lacking.size(), 1u);
  EXPECT_TRUE(once.outcome.drawn_again.empty());
  EXPECT_LT(once["coverage"], 0.99);
  // Here measured along the plane; in the metric on the surface, where points within 0.5 mm of ink
  // are covered.
  EXPECT_NEAR(length_mm(once.outcome.lacking), once["longest_gap"] + 1.0,
              0.2 * once["longest_gap"]);

  const Figures twice = draw_scenario("safety-no-cloud", {"drawing.redraw=true"});
  ASSERT_EQ(twice.outcome.drawn_again.size(), 1u);
  EXPECT_NEAR(twice.outcome.drawn_again[0].from, once.outcome.lacking[0].from, 1e-9);
  EXPECT_TRUE(twice.outcome.lacking.empty());
  EXPECT_EQ(twice["coverage"], 1.0);
  EXPECT_EQ(twice["gaps"], 0.0);
  EXPECT_EQ(twice["ink_outside"], 0.0);
  EXPECT_GT(twice.outcome.simulated, once.outcome.simulated + 1.0);
}

// Perception always fails at the same place: the second pass is the last, and the rest is reported.
TEST(Passes, WhatStillHasNoneIsTold) {
  const Figures f = draw_scenario(
      "safety-no-cloud",
      {"drawing.redraw=true", "faults=[{kind: no_cloud, start: 0.5, duration: 100}]"});
  EXPECT_EQ(f.outcome.drawn_again.size(), 1u);
  ASSERT_EQ(f.outcome.lacking.size(), 1u);
  EXPECT_LT(f["coverage"], 0.6);
  EXPECT_GT(length_mm(f.outcome.lacking), 100.0);
}

TEST(Passes, AnInterruptedRunGoesOn) {
  DrawOptions options;
  options.scenario = "scenarios/bowl-m.yaml";
  const fs::path log =
      fs::temp_directory_path() / ("impedraw_passes_" + std::to_string(getpid()) + ".h5");
  for (const double when :
       {0.5, 4.0, 8.0, 13.0}) {  // before the stroke, within it twice, near its end
    SCOPED_TRACE(when);
    options.assignments = {when == 4.0 || when == 13.0 ? "log.rate=reduced" : "log.rate=full"};
    double now = 0.0;
    RunHooks hooks;
    hooks.progress = [&](const RunProgress& p) { now = p.time; };
    hooks.interrupted = [&] { return now > when; };
    Prepared first = prepare(resolve(options));
    ASSERT_EQ(run(first, log, 0.0, hooks).end, RunEnd::interrupted);
    const std::size_t kept = read_run(log).rows();

    Prepared second = prepare(resolve(options));
    const Resumption resumption = read_resumption(second, log).value();
    EXPECT_NEAR(resumption.time, when + 1.0, 0.05) << "the pen was lifted for a second";
    const RunOutcome outcome = run(second, log, 0.0, {}, &resumption);
    EXPECT_EQ(outcome.end, RunEnd::finished);
    EXPECT_TRUE(outcome.lacking.empty());
    const RunData rows = read_run(log);
    ASSERT_GT(rows.time.size(), kept);
    for (std::size_t i = 1; i < rows.time.size(); ++i)
      ASSERT_NEAR(rows.time[i] - rows.time[i - 1], 1e-3, 1e-9) << i;
    const Metrics metrics = compute_metrics(rows);
    EXPECT_EQ(metrics.coverage.or_nan(), 1.0);
    EXPECT_EQ(metrics.strokes_missed.or_nan(), 0.0);
    EXPECT_EQ(metrics.ink_outside.or_nan(), 0.0);
    EXPECT_LE(metrics.ink_error_max.or_nan(), 0.2);
    EXPECT_LE(metrics.touchdown_peak.or_nan(), 8.0);

    Prepared third = prepare(resolve(options));  // nothing is left
    const Resumption all = read_resumption(third, log).value();
    EXPECT_TRUE(rest_of(third.plan.strokes, all.ink.parts(), kShortestGap).empty());
  }
  fs::remove(log);
}

TEST(Passes, WhatCannotBeDrawnIsRefusedOrLeftOutAndSaid) {
  const std::vector<std::string> wide = {"drawing.shape=circle", "drawing.placement.scale=2.5",
                                         "drawing.placement.centre=[0.65, 0]"};
  DrawOptions options;
  options.assignments = wide;
  try {
    prepare(resolve(options));
    FAIL() << "a circle of 150 mm, 50 mm off the middle of a bowl of 180 mm";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("stroke 0"));
    EXPECT_THAT(error.what(), HasSubstr("leaves the canvas"));
    EXPECT_THAT(error.what(), HasSubstr("--skip-unreachable"));
  }
  std::vector<std::string> skip = wide;
  skip.push_back("drawing.skip_unreachable=true");
  const Figures f = draw_scenario("bowl", skip);
  EXPECT_EQ(f["coverage"], 1.0);
  EXPECT_EQ(f["strokes_missed"], 0.0);
  EXPECT_LE(f["ink_error_rms"], 0.04);

  // Drawn and omitted parts make up the circle and meet at the rim.
  options.assignments = skip;
  const Prepared e = prepare(resolve(options));
  double covered = 0.0;
  for (const StrokePart& part : e.plan.preflight.drawable) covered += part.length();
  for (const Finding& finding : e.plan.preflight.findings) covered += finding.part.length();
  EXPECT_NEAR(covered, plane_length(e.artwork.strokes[0]), 1e-9);
  for (const PlacedStroke& stroke : e.plan.strokes)
    for (const Eigen::Vector2d& p : stroke.p_P)
      EXPECT_LE((p - Eigen::Vector2d(0.6, 0.0)).norm(), 0.18);
  EXPECT_FALSE(notes_of(e).empty());
}

// The planned duration equals the duration of the run.
TEST(Passes, ThePlansTimeIsTheRuns) {
  DrawOptions options;
  options.scenario = "scenarios/bowl-m-natural.yaml";
  const double planned = prepare(resolve(options)).plan.path.duration();
  EXPECT_NEAR(draw_scenario("bowl-m-natural").outcome.simulated, planned, 0.001 * planned);
}

// A circle on a wall equals a circle on a table.
TEST(Passes, AWallIsDrawnOnAsATableIs) {
  const Figures f = draw_scenario(
      "wall", {"drawing.svg=", "drawing.shape=circle", "drawing.placement.fit_radius=0.15"});
  EXPECT_EQ(f["contact_fraction"], 1.0);
  EXPECT_EQ(f["coverage"], 1.0);
  EXPECT_LE(f["ink_error_rms"], 0.04);
  EXPECT_NEAR(f["force_mean"], 5.0, 0.05);
  EXPECT_LE(f["tilt_max"], 1.0);
  for (std::size_t i = 0; i < f.run.stroke.size(); ++i)
    if (f.run.stroke[i] >= 0) {
      ASSERT_NEAR(f.run.contact_point[i].x(), 0.82, 1e-9);
    }
}

}  // namespace
}  // namespace impedraw
