// How made-up runs end, and how much of them was drawn, by hand.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/metrics/ending.h"
#include "made_up_rows.h"

namespace impedraw {
namespace {

using namespace testing;
using ::testing::AllOf;
using ::testing::HasSubstr;

// The plain run draws 50 mm; 10 mm more were asked for and left out.
Promise plain_promise() {
  Promise promise;
  promise.asked = 0.06;
  promise.promised = 0.05;
  promise.undrawable = 0.01;
  promise.problems = {{"off_canvas", 1}, {"too_steep", 1}};
  promise.lengths = {{"off_canvas", 0.008}, {"too_steep", 0.002}};
  return promise;
}

MadeUp run_with(const Ending& ending, const Promise& promise = plain_promise()) {
  MadeUp run = plain_run();
  run.attributes[kEndingAttribute] = ending_text(ending);
  run.attributes[kPromiseAttribute] = promise_text(promise);
  return run;
}

void lift_all(MadeUp& run) {
  for (std::size_t i = 0; i < run.rows(); ++i) lift(run, i);
}

TEST(EndingOf, ALogSaysHowItsLoopEnded) {
  for (const RunEnd end : {RunEnd::finished, RunEnd::stopped, RunEnd::interrupted}) {
    const Ending made{end, end == RunEnd::finished ? "" : "why \"<b>\"", "", {{"wall", 0.25}}};
    const Ending read = read_ending({{kEndingAttribute, ending_text(made)}});
    EXPECT_EQ(read.end, end);
    EXPECT_EQ(read.cause, made.cause);
    EXPECT_EQ(read.given_up, made.given_up);
    EXPECT_EQ(metrics_of(run_with(made)).at("ending"),
              (Json{{"end", name_of(end)}, {"cause", made.cause}}));
  }
  EXPECT_THAT(told({RunEnd::interrupted, "ctrl-C"}), HasSubstr("by a person: ctrl-C"));
  for (const char* broken : {"", "{", "[]", "{\"end\": 3}", "{\"end\": \"finished\"}"})
    EXPECT_EQ(read_ending({{kEndingAttribute, broken}}).end, RunEnd::unknown) << broken;
  EXPECT_EQ(metrics_of(plain_run()).at("ending").at("end"), "unknown");  // killed, or older
}

TEST(EndingOf, NothingDrawnIsSaidWithItsReason) {
  MadeUp run = run_with({});
  EXPECT_EQ(metrics_of(run).at("ending").at("end"), "finished");
  lift_all(run);
  const Json m = metrics_of(run);
  EXPECT_EQ(m.at("ending").at("end"), "nothing_drawn");
  EXPECT_THAT(m.at("ending").at("cause").get<std::string>(),
              AllOf(HasSubstr("never pressed"), HasSubstr("no ink 50 mm")));
  EXPECT_EQ(m.at("drawn"), 0.0);
  // What stopped by itself says why it stopped, with or without ink; a dry run asks for none.
  MadeUp halted = run_with({RunEnd::stopped, "a fence"});
  lift_all(halted);
  EXPECT_EQ(metrics_of(halted).at("ending").at("end"), "stopped");
  Promise dry = plain_promise();
  dry.asks_ink = false;
  MadeUp in_air = run_with({}, dry);
  lift_all(in_air);
  EXPECT_EQ(metrics_of(in_air).at("ending").at("end"), "finished");
  EXPECT_TRUE(metrics_of(in_air).at("drawn").is_null());
}

// A speck of ink is no drawing: 0.45 mm of 60.
TEST(EndingOf, ASpeckIsNothing) {
  MadeUp run = run_with({});
  lift_all(run);
  for (std::size_t i = 1500; i < 1510; ++i) touch(run, i, 0.05 * (i - 1000.0));
  EXPECT_EQ(metrics_of(run).at("ending").at("end"), "nothing_drawn");
  for (std::size_t i = 1500; i < 1520; ++i) touch(run, i, 0.05 * (i - 1000.0));  // 0.95 mm
  EXPECT_EQ(metrics_of(run).at("ending").at("end"), "finished");
}

TEST(EndingOf, FarOffIsMoreThanFiveMillimetres) {
  for (const double off : {4.9, 5.1}) {
    MadeUp run = run_with({});
    for (std::size_t i = 1000; i < 2000; ++i) touch(run, i, 0.05 * (i - 1000.0), off);
    EXPECT_EQ(metrics_of(run).at("ending").at("end"), off > 5.0 ? "far_off" : "finished") << off;
    // The pen, of an arm that saw the surface; blind, its set-point lies elsewhere.
    MadeUp path = run_with({});
    for (std::size_t i = 1000; i < 2000; ++i) path.tip_position[i].x() = 1e-3 * off;
    EXPECT_EQ(metrics_of(path).at("ending").at("end"), "finished");
    path.surface_normal.assign(path.rows(), Eigen::Vector3d::UnitZ());
    path.surface_distance.assign(path.rows(), 0.0);
    EXPECT_EQ(metrics_of(path).at("ending").at("end"), off > 5.0 ? "far_off" : "finished") << off;
  }
}

// A pad that leans presses beside its line, within its face.
TEST(EndingOf, APadMayPressBesideItsLine) {
  Promise pad = plain_promise();
  pad.face = 0.015;
  for (const double off : {19.0, 21.0}) {
    MadeUp run = run_with({}, pad);
    for (std::size_t i = 1000; i < 2000; ++i) touch(run, i, 0.05 * (i - 1000.0), off);
    EXPECT_EQ(metrics_of(run).at("ending").at("end"), off > 20.0 ? "far_off" : "finished") << off;
  }
}

TEST(DrawnLengths, TheRestIsByReason) {
  MadeUp run = run_with({});
  for (std::size_t i = 1200; i < 1300; ++i) lift(run, i);  // 10 to 15 mm: ends at 9.95
  for (std::size_t i = 1500; i < 1515; ++i) lift(run, i);  // 0.8 mm counts as drawn
  Json m = metrics_of(run);
  EXPECT_NEAR(m.at("not_drawn_mm").at("off_canvas").get<double>(), 8.0, 1e-9);
  EXPECT_NEAR(m.at("not_drawn_mm").at("too_steep").get<double>(), 2.0, 1e-9);
  EXPECT_NEAR(m.at("not_drawn_mm").at("no_ink").get<double>(), 5.05 + 0.05, 1e-4);
  EXPECT_NEAR(m.at("drawn").get<double>(), (60.0 - 15.1) / 60.0, 1e-5);
  // 3 mm of it were given up before a wall.
  run.attributes[kEndingAttribute] = ending_text({RunEnd::finished, "", "", {{"wall", 3e-3}}});
  m = metrics_of(run);
  EXPECT_NEAR(m.at("not_drawn_mm").at("wall").get<double>(), 3.0, 1e-9);
  EXPECT_NEAR(m.at("not_drawn_mm").at("no_ink").get<double>(), 2.1, 1e-4);
  // A run that ended before its end did not come to the rest.
  run.attributes[kEndingAttribute] = ending_text({RunEnd::interrupted, "ctrl-C"});
  m = metrics_of(run);
  EXPECT_NEAR(m.at("not_drawn_mm").at("not_reached").get<double>(), 5.1, 1e-4);
  EXPECT_FALSE(m.at("not_drawn_mm").contains("no_ink"));
  // One that went through its whole plan, far off, did.
  run.attributes[kEndingAttribute] = ending_text({RunEnd::far_off, "ink is 26 mm off"});
  EXPECT_FALSE(metrics_of(run).at("not_drawn_mm").contains("not_reached"));
  // A later pass over the gap fills it: the rows of its second half, again.
  MadeUp again = run_with({});
  for (std::size_t i = 1000; i < 1500; ++i) lift(again, i);
  for (std::size_t i = 2200; i < 2700; ++i) {
    again.stroke[i] = 0;
    again.stroke_along[i] = again.stroke_along[i - 1200];
    touch(again, i, 0.05 * (i - 2200.0));
  }
  EXPECT_FALSE(metrics_of(again).at("not_drawn_mm").contains("no_ink"));
  EXPECT_NEAR(metrics_of(again).at("drawn").get<double>(), 50.0 / 60.0, 1e-9);
}

TEST(DrawnLengths, AnyStrokeCounts) {
  MadeUp run = run_with({});
  const double drawn = value(run, "drawn");
  for (int& stroke : run.stroke) stroke = stroke == 0 ? 1 : stroke;
  run.target_stroke.assign(run.target_stroke.size(), 1);
  EXPECT_EQ(value(run, "drawn"), drawn);
}

TEST(DrawnLengths, AnOlderLogDoesNotSay) {
  MadeUp run = run_with({});
  std::fill(run.stroke_along.begin(), run.stroke_along.end(), kNone);
  expect_null(run, {"drawn"}, "where on a stroke");
}

TEST(DrawnLengths, TextHasTheLongestFirst) {
  EXPECT_EQ(rest_text({{"off_canvas", 200.0}, {"too_steep", 1234.0}}),
            "too steep 1.23 m, edge 200 mm");
  EXPECT_EQ(rest_text({}), "");
  EXPECT_EQ(length_text(999.9), "1 m");
}

TEST(MetricsSummary, SaysHowMuchWasDrawn) {
  MadeUp made = run_with({});
  const RunData run = recorded(made, made);
  EXPECT_THAT(metrics_summary(compute_metrics(run)),
              AllOf(HasSubstr("drew 50 mm of 60 mm, 83 %; the rest: edge 8 mm, too steep 2 mm\n"),
                    HasSubstr("finished"), HasSubstr("5 ± 0 N")));
}

// A force that is asked to vary is told by its error, not by its spread.
TEST(MetricsSummary, TellsTheErrorOfAForceThatVaries) {
  MadeUp made = run_with({});
  for (std::size_t i = 900; i < 2100; ++i) {
    made.push[i] = i < 1500 ? 3.0 : 6.0;
    made.contact_force[i].z() = made.push[i] + 0.1;
  }
  const RunData run = recorded(made, made);
  EXPECT_THAT(metrics_summary(compute_metrics(run)),
              HasSubstr("N on average, 0.1 N RMS from the force asked for"));
}

// A pen that is up and is hit.
TEST(Metrics, LargestContactForceCountsAllRows) {
  MadeUp run = plain_run();
  touch(run, 100, 0.0, 0.0, 37.0);
  EXPECT_EQ(value(run, "contact_force_max"), 37.0);
  EXPECT_EQ(value(run, "force_peak"), 5.0);
}

}  // namespace
}  // namespace impedraw
