// The benchmark's references and workpieces against finite differences and the true mesh.
#include <cmath>
#include <fstream>
#include <numbers>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "impedraw/canvas/canvas.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/rotations.h"
#include "impedraw/judge/force_case.h"
#include "impedraw/judge/force_rig.h"
#include "impedraw/judge/force_trial.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

TEST(ForceProgramme, ReferencesAreDerivativesOfEachOther) {
  constexpr double kDelta = 1e-4;
  for (const ForceCase& c : force_cases()) {
    Workpiece piece;
    piece.shape = c.shape;
    piece.X_WB = {{0.0, 0.0, 1e-3}, rotation({0.01, -0.02, 0.0})};
    const ForceProgramme programme(c, piece, {0.5, 0.05, 0.2}, Vector3d::UnitZ());
    // The path with its rests, not the descent, whose speed jumps.
    for (double t = programme.start() + 0.01; t < programme.end() - 0.01; t += 0.0173) {
      const TipReference before = programme.at(t - kDelta).reference,
                         now = programme.at(t).reference,
                         after = programme.at(t + kDelta).reference;
      ASSERT_LT((now.v_WD - (after.p_WD - before.p_WD) / (2.0 * kDelta)).norm(), 2e-3) << c.name;
      ASSERT_LT((now.a_WD - (after.v_WD - before.v_WD) / (2.0 * kDelta)).norm(), 0.5) << c.name;
      const Vector3d n_dot = (after.n_WD - before.n_WD) / (2.0 * kDelta);
      ASSERT_LT((now.w_WD.cross(now.n_WD) - n_dot).norm(), 2e-2) << c.name;
      ASSERT_NEAR(now.n_WD.norm(), 1.0, 1e-12);
      EXPECT_TRUE(now.pen_down);
    }
    EXPECT_FALSE(programme.at(programme.end() + 0.1).reference.pen_down);
    EXPECT_FALSE(programme.at(0.0).reference.pen_down);
    EXPECT_LT((programme.at(0.0).reference.p_WD - Vector3d(0.5, 0.05, 0.2)).norm(), 1e-9);
  }
}

TEST(ForceProgramme, CommandIsWhatIsJudged) {
  const ForceCase steps = force_cases({"steps"}).front();
  const ForceProgramme programme(steps, {}, {0.6, 0.0, 0.13}, Vector3d::UnitZ());
  const ForceQuestion question = programme.question(programme.start());
  ASSERT_EQ(question.changes.size(), 3u);
  for (const ForceChange& change : question.changes) {
    EXPECT_DOUBLE_EQ(programme.at(change.at - 1e-6).asked, change.before);
    EXPECT_DOUBLE_EQ(programme.at(change.at + 1e-6).asked, change.after);
    EXPECT_DOUBLE_EQ(programme.at(change.until - 1e-6).asked, change.after);
  }
  const ForceCase ramps = force_cases({"ramps"}).front();
  const ForceProgramme ramp(ramps, {}, {0.6, 0.0, 0.13}, Vector3d::UnitZ());
  EXPECT_NEAR(ramp.at(ramp.start() + 1.5).asked, 10.0, 1e-9);
  EXPECT_NEAR(ramp.at(ramp.start() + 1.5).reference.force_rate, 10.0, 1e-9);
  EXPECT_NEAR(ramp.at(ramp.start() + 3.1).reference.force_rate, -50.0, 1e-9);
}

TEST(ForceProgramme, NamesDifferAndWrongOnesAreTold) {
  std::set<std::string> names;
  for (const ForceCase& c : force_cases()) EXPECT_TRUE(names.insert(c.name).second) << c.name;
  EXPECT_EQ(force_cases({"sweep", "steps"}).front().name, "steps");
  EXPECT_THROW(force_cases({"stepps"}), InputError);
}

// What a rig is told, against the closed form of each case's motion, spring and hand.
TEST(ForceRig, IsToldWhatTheWorkpieceDoes) {
  const auto order = [](const std::string& name, int number) {
    const ForceCase c = force_cases({name}).front();
    Workpiece piece;
    piece.shape = c.shape;
    const ForceProgramme programme(c, piece, {0.6, 0.0, 0.13}, Vector3d::UnitZ());
    return nlohmann::json::parse(rig_order(c, piece, programme, number));
  };
  const auto still = order("hold-still", 3);
  EXPECT_EQ(still["run"], 3);
  EXPECT_EQ(still["shape"], "bowl");
  EXPECT_TRUE(still["poses"].empty() && still["stiffness"].empty() && still["hand"].empty());
  EXPECT_DOUBLE_EQ(still["leave"].get<double>() - still["start"].get<double>(),
                   5.0 + ForceProgramme::kLeave);

  const auto tilting = order("hold-tilting", 1);
  EXPECT_EQ(tilting["shape"], "flat");
  EXPECT_EQ(tilting["poses"].size(), 5501u);
  const std::vector<double> first = tilting["poses"][0], later = tilting["poses"][3000];
  EXPECT_EQ(first, (std::vector<double>{0, 0, 0, 1, 0, 0, 0}));
  // After the ramp: 2° sin(2π 0.4 Hz (t − ramp's lag)) about y through a point 50 mm beside.
  const double roll = 2.0 * std::atan2(later[5], later[3]);
  EXPECT_LE(std::abs(roll), 2.0 * std::numbers::pi / 180.0 + 1e-12);
  EXPECT_GT(std::abs(roll), 0.01);
  const Vector3d axis(0.55, 0.0, 0.10), p(later[0], later[1], later[2]);
  EXPECT_LT((rotation({0.0, roll, 0.0}) * axis + p - axis).norm(), 1e-12) << "the axis stands";

  const auto stiffening = order("hold-stiffening", 1);
  const std::vector<double> k = stiffening["stiffness"];
  EXPECT_NEAR(k[0], 1e3, 1e-9);
  EXPECT_NEAR(k[2500], std::sqrt(1e3 * 1e6), 1e-6);
  EXPECT_NEAR(k[5000], 1e6, 1e-6);
  EXPECT_NEAR(k.back(), 1e6, 1e-6);

  Vector3d impulse = Vector3d::Zero();
  const auto across = order("hand-across", 1);
  for (const std::vector<double> F : across["hand"]) impulse += 1e-3 * Vector3d(F[0], F[1], F[2]);
  EXPECT_LT((impulse - Vector3d(0.0, 10.0, 0.0)).norm(), 0.02) << "10 N for a second";
}

// Readings of a ramp, and a run that began 2 s into the session.
TEST(ForceSensor, FillsARecordFromItsFile) {
  const auto file = std::filesystem::temp_directory_path() / fmt::format("sensor-{}.csv", getpid());
  std::ofstream(file) << "time,force\n0,0\n10,20\n";
  ForceRun run;
  run.begin = 2.0;
  run.programme.emplace(force_cases({"hold-still"}).front(), Workpiece(), Vector3d(0.6, 0.0, 0.13),
                        Vector3d::UnitZ());
  for (double t = 0.0; t < 9.0; t += 0.5) run.record.push_back({t, 5.0, std::nan(""), 0.0});
  SensorFile(file, 0.0).fill(&run);
  for (const JudgedSample& s : run.record)
    EXPECT_NEAR(s.force, std::min(20.0, 2.0 * (s.time + 2.0)), 1e-12);
  run.ask();
  EXPECT_EQ(run.ended, "");
  EXPECT_DOUBLE_EQ(run.question.from, run.programme->start());
  // By runs: another run's readings say nothing.
  std::ofstream(file) << "run,time,force\n3,0,50\n3,9,50\n4,0,1\n4,4,9\n5,0,70\n";
  run.order = 4;
  SensorFile(file, 0.0).fill(&run);
  for (const JudgedSample& s : run.record)
    EXPECT_NEAR(s.force, std::min(9.0, 1.0 + 2.0 * s.time), 1e-12);
  for (const int none : {2, 6}) {
    run.order = none;
    SensorFile(file, 0.0).fill(&run);
    for (const JudgedSample& s : run.record) EXPECT_TRUE(std::isnan(s.force));
  }
  std::ofstream(file) << "run,time,force\n4,0,1\n4,0,9\n";
  EXPECT_THROW(SensorFile(file, 0.0), InputError);
  std::ofstream(file) << "time,force\n0,0\n1;20\n";
  EXPECT_THROW(SensorFile(file, 0.0), InputError);
  std::filesystem::remove(file);
  EXPECT_THROW(SensorFile(file, 0.0), InputError);
}

// Away from the roof's edge, which is believed to be round.
TEST(Workpiece, IsBelievedToBeWhereItIs) {
  for (const auto shape :
       {Workpiece::Shape::bowl, Workpiece::Shape::flat, Workpiece::Shape::roof}) {
    Workpiece piece;
    piece.shape = shape;
    const Canvas canvas(piece.mesh());
    for (const double x : {-0.1, -0.03, 0.03, 0.08})
      for (const double y : {-0.05, 0.0, 0.09})
        for (const double height : {-1e-3, 2e-3}) {
          const Workpiece::Place on = piece.at(x, y);
          const Vector3d q = on.p_W + height * on.n_W;
          const SurfacePoint truth = canvas.closest(q);
          const SurfaceEstimate believed = piece.estimate(q);
          const double tolerance = shape == Workpiece::Shape::roof ? 4e-4 : 5e-6;
          EXPECT_NEAR(believed.distance, truth.distance, tolerance);
          EXPECT_NEAR(believed.distance, height, 1e-6);
          EXPECT_LT((believed.n_W - truth.n_W).norm(), 2e-3);
        }
  }
}

}  // namespace
}  // namespace impedraw
