// The arm's joints along planned strokes, by finite differences of its postures in time.
#include "impedraw/planning/preflight/joint_rates.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "arm_on_surface.h"
#include "planning/surfaces.h"
#include "seeds.h"

namespace impedraw {
namespace {

// Largest joint speed, as a share of its limit, while the path draws. Each posture follows from the
// one before, at the same instants as the controller would ask for them.
double largest_share(ArmModel& arm, const TipPath& path, const JointVector& start) {
  constexpr double kDt = 0.01;  // [s]
  IkSettings ik;
  ik.position_tolerance = ik.axis_tolerance = 1e-8;
  ik.posture_gain = 0.0;
  ik.max_steps = 60;
  double largest = 0.0;
  for (const StrokeTimes& stroke : path.strokes()) {
    JointVector q = start;
    bool known = false;
    for (double t = stroke.start; t < stroke.end; t += kDt) {
      const TipReference r = path.at(t).reference;
      const IkResult found = find_posture(arm, {r.p_WD, -r.n_WD}, q, ik);
      if (!found.reached) {
        known = false;
        continue;
      }
      if (known)
        largest = std::max(
            largest, ((found.q - q).cwiseAbs().array() / arm.limits().speed.array()).maxCoeff() /
                         kDt);
      q = found.q;
      known = true;
    }
  }
  return largest;
}

PlacedStroke random_stroke(std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  std::vector<Eigen::Vector2d> points;
  Eigen::Vector2d at(0.6 + 0.05 * u(random), 0.1 * u(random));
  double heading = 3.14 * u(random), turn = 0.0;
  for (int i = 0; i < 40; ++i) {
    points.push_back(at);
    turn = 0.8 * turn + 0.1 * u(random);
    heading += turn;
    at += 0.003 * Eigen::Vector2d(std::cos(heading), std::sin(heading));
  }
  return surfaces::line(points);
}

// At ten times the usual speed, over hills of up to 39° of slope.
PathSettings fast() {
  PathSettings settings;
  settings.draw_speed = 0.5;
  settings.draw_acceleration = 10.0;
  settings.normal_acceleration = 100.0;
  settings.tilt_speed = 20.0;
  settings.tilt_acceleration = 1000.0;
  settings.joint_acceleration = 200.0;
  return settings;
}

TEST(JointRates, NoJointPassesItsLimitAlongRandomPaths) {
  ArmModel arm(surfaces::kArm);
  const JointVector start = surfaces::start_posture(arm);
  const PathSettings settings = fast();
  const JointRates limits(arm, settings, start, start);
  int faster = 0;
  for (unsigned seed = 0; seed < seeds(40, 200); ++seed) {
    std::mt19937 random(seed);
    const PlacedStroke stroke = random_stroke(random);
    const TipPath limited = plan_tip_path({stroke}, surfaces::waves, settings, limits);
    EXPECT_LE(largest_share(arm, limited, start), 1.0) << "seed " << seed;
    const TipPath free = plan_tip_path({stroke}, surfaces::waves, settings);
    faster += largest_share(arm, free, start) > 1.0;
  }
  EXPECT_GT(faster, 0) << "the limits must have something to limit";
}

TEST(JointRates, AnEasyStrokeKeepsItsTime) {
  ArmModel arm(surfaces::kArm);
  const JointVector start = surfaces::start_posture(arm);
  const PathSettings settings;
  const auto sine = surfaces::shape("sine");
  EXPECT_EQ(plan_tip_path(sine, surfaces::bowl, settings, JointRates(arm, settings, start, start))
                .duration(),
            plan_tip_path(sine, surfaces::bowl, settings).duration());
}

}  // namespace
}  // namespace impedraw
