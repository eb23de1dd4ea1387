// The arm's joints along planned strokes, by finite differences of its postures in time.
#include "impedraw/planning/preflight/joint_rates.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "arm_on_surface.h"
#include "impedraw/control/normal_tracker.h"
#include "impedraw/planning/preflight/preflight.h"
#include "planning/surfaces.h"
#include "seeds.h"

namespace impedraw {
namespace {

// Moves q to the pen placement with the least kinetic energy; the redundant joint relaxes by a
// share towards `rest`. Returns how far the tip was off [m] and [rad].
double follow(ArmModel& arm, const TipReference& r, double share, const JointVector& rest,
              JointVector* q) {
  ArmTerms terms(arm.joints());
  arm.compute(*q, JointVector::Zero(q->size()), &terms);
  Vector6 off;
  off << r.p_WD - terms.X_WE.p, smallest_rotation(terms.X_WE.R.col(2), -r.n_WD);
  const Eigen::MatrixXd W = terms.M.inverse() * terms.J.transpose();
  const Eigen::MatrixXd J_bar = W * (terms.J * W).inverse();
  const JointVector relax = share * (rest - *q);
  *q += relax + J_bar * (off - terms.J * relax);
  return off.cwiseAbs().maxCoeff();
}

// Largest joint speed, as a share of its limit, while the path draws, by finite differences in
// time; NaN where the arm does not reach. The redundant joint relaxes to `start` over 50 mm.
double largest_share(ArmModel& arm, const TipPath& path, const JointVector& start) {
  constexpr double kDt = 2e-3;  // [s]
  double largest = 0.0;
  for (const StrokeTimes& stroke : path.strokes()) {
    TipReference r = path.at(stroke.start).reference;
    JointVector q = find_posture(arm, {r.p_WD, -r.n_WD}, start).q;
    // The approach and settle_time last longer than the redundant joint takes to relax.
    double off = 0.0;
    for (int i = 0; i < 16; ++i)
      off = follow(arm, r, i < 8 ? 1.0 - std::exp(-1.0) : 0.0, start, &q);
    if (off > 1e-6) return std::nan("");
    for (double t = stroke.start; t < stroke.end; t += kDt) {
      r = path.at(t + kDt).reference;
      const JointVector before = q;
      off = follow(arm, r, 1.0 - std::exp(-r.v_WD.norm() * kDt / 0.05), start, &q);
      if (off > 0.01) return std::nan("");
      largest = std::max(
          largest, ((q - before).cwiseAbs().array() / arm.limits().speed.array()).maxCoeff() / kDt);
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
  int faster = 0, reached = 0;
  for (unsigned seed = 0; seed < seeds(40, 200); ++seed) {
    std::mt19937 random(seed);
    const PlacedStroke stroke = random_stroke(random);
    // Near singular postures nothing is promised.
    if (!check_strokes({stroke}, surfaces::waves, arm, nullptr, start).findings.empty()) continue;
    const TipPath limited = plan_tip_path({stroke}, surfaces::waves, settings, limits);
    const double share = largest_share(arm, limited, start);
    if (std::isnan(share)) continue;
    ++reached;
    EXPECT_LE(share, 1.0) << "seed " << seed;
    const TipPath free = plan_tip_path({stroke}, surfaces::waves, settings);
    faster += largest_share(arm, free, start) > 1.0;
  }
  EXPECT_GT(faster, 0) << "the limits must have something to limit";
  EXPECT_GT(reached, 20);
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
