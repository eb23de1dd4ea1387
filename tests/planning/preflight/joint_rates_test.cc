// The arm's joints along planned strokes, by finite differences of its postures in time.
#include "impedraw/planning/preflight/joint_rates.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "arm_on_surface.h"
#include "impedraw/control/normal_tracker.h"
#include "impedraw/planning/preflight/preflight.h"
#include "planning/surfaces.h"

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

constexpr double kDt = 2e-3;  // of the differences below [s]

// One stroke's postures, kDt apart. The redundant joint relaxes to `start` over 50 mm. Empty where
// the arm does not reach.
std::vector<std::vector<JointVector>> postures(ArmModel& arm, const TipPath& path,
                                               const JointVector& start) {
  std::vector<std::vector<JointVector>> strokes;
  for (const StrokeTimes& stroke : path.strokes()) {
    TipReference r = path.at(stroke.start).reference;
    JointVector q = find_posture(arm, {r.p_WD, -r.n_WD}, start).q;
    // The approach and settle_time last longer than the redundant joint takes to relax.
    double off = 0.0;
    for (int i = 0; i < 16; ++i)
      off = follow(arm, r, i < 8 ? 1.0 - std::exp(-1.0) : 0.0, start, &q);
    if (off > 1e-6) return {};
    strokes.push_back({q});
    for (double t = stroke.start; t < stroke.end; t += kDt) {
      r = path.at(t + kDt).reference;
      off = follow(arm, r, 1.0 - std::exp(-r.v_WD.norm() * kDt / 0.05), start, &q);
      if (off > 0.01) return {};
      strokes.back().push_back(q);
    }
  }
  return strokes;
}

// Largest joint speed, as a share of its limit, while the path draws; NaN where the arm does not
// reach.
double largest_share(ArmModel& arm, const TipPath& path, const JointVector& start) {
  double largest = std::nan("");
  for (const std::vector<JointVector>& q : postures(arm, path, start))
    for (std::size_t i = 1; i < q.size(); ++i)
      largest = std::fmax(
          largest,
          ((q[i] - q[i - 1]).cwiseAbs().array() / arm.limits().speed.array()).maxCoeff() / kDt);
  return largest;
}

// The same of the torque that moves the arm, holds it and presses the pen on.
double largest_torque_share(ArmModel& arm, const TipPath& path, const JointVector& start,
                            const DrawingLoad& load) {
  constexpr std::size_t kWide = 4;  // differences over 16 ms
  double largest = std::nan("");
  ArmTerms terms(arm.joints());
  for (const std::vector<JointVector>& q : postures(arm, path, start))
    for (std::size_t i = kWide; i + kWide < q.size(); ++i) {
      const JointVector v = (q[i + kWide] - q[i - kWide]) / (2.0 * kWide * kDt);
      const JointVector a =
          (q[i + kWide] - 2.0 * q[i] + q[i - kWide]) / (kWide * kDt * kWide * kDt);
      arm.compute(q[i], v, &terms);
      const Eigen::Vector3d axis = terms.X_WE.R.col(2);
      const JointVector torque = terms.M * a + terms.Cv + terms.g +
                                 load.normal_force * terms.J.topRows<3>().transpose() * axis;
      largest =
          std::fmax(largest, (torque.cwiseAbs().array() / arm.limits().torque.array()).maxCoeff());
    }
  return largest;
}

// The same of acceleration [rad/s²], by differences over 16 ms.
double largest_acceleration(ArmModel& arm, const TipPath& path, const JointVector& start) {
  constexpr std::size_t kWide = 4;
  double largest = std::nan("");
  for (const std::vector<JointVector>& q : postures(arm, path, start))
    for (std::size_t i = kWide; i + kWide < q.size(); ++i)
      largest =
          std::fmax(largest, (q[i + kWide] - 2.0 * q[i] + q[i - kWide]).cwiseAbs().maxCoeff() /
                                 (kWide * kDt * kWide * kDt));
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

// Those of 200 random strokes that the pre-flight lets pass, with their seeds. Nothing is promised
// near singular postures.
template <typename Judge>
void for_drawable_strokes(ArmModel& arm, const JointVector& start, Judge&& judge) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const PlacedStroke stroke = random_stroke(random);
    if (check_strokes({stroke}, surfaces::waves, arm, nullptr, start).findings.empty())
      judge(seed, stroke);
  }
}

TEST(JointRates, NoJointPassesItsLimitAlongRandomPaths) {
  ArmModel arm(surfaces::kArm);
  const JointVector start = surfaces::start_posture(arm);
  const PathSettings settings = fast();
  const JointRates limits(arm, settings, start, start);
  int faster = 0, reached = 0;
  for_drawable_strokes(arm, start, [&](unsigned, const PlacedStroke& stroke) {
    const TipPath limited = plan_tip_path({stroke}, surfaces::waves, settings, limits);
    const double share = largest_share(arm, limited, start);
    if (std::isnan(share)) return;
    ++reached;
    EXPECT_LE(share, 1.0);
    const TipPath free = plan_tip_path({stroke}, surfaces::waves, settings);
    faster += largest_share(arm, free, start) > 1.0;
  });
  EXPECT_GT(faster, 0) << "the limits must have something to limit";
  EXPECT_GT(reached, 100);
}

// The limit holds where the plan samples the postures, every kStep. Between them, where a joint
// starts and ends a fast turn near a singular posture, a joint may pass it by a quarter. What bends
// within less than kStep is not seen: the fitted line of seed 150 does, on a steep slope.
// The defect: near singular postures bends were averaged over two steps, and joints reached five
// times the limit.
TEST(JointRates, NoJointAcceleratesFasterThanItsLimitAlongRandomPaths) {
  ArmModel arm(surfaces::kArm);
  const JointVector start = surfaces::start_posture(arm);
  PathSettings settings = fast();
  settings.joint_speed_share = 1.0;
  settings.joint_acceleration = 20.0;
  PathSettings any = settings;
  any.joint_acceleration = 1000.0;
  const JointRates limits(arm, settings, start, start), free(arm, any, start, start);
  int faster = 0, reached = 0, above = 0;
  std::vector<unsigned> far_above;
  for_drawable_strokes(arm, start, [&](unsigned seed, const PlacedStroke& stroke) {
    const double share =
        largest_acceleration(arm, plan_tip_path({stroke}, surfaces::waves, settings, limits),
                             start) /
        settings.joint_acceleration;
    if (std::isnan(share)) return;
    ++reached;
    above += share > 1.0;
    if (share > 1.3) far_above.push_back(seed);
    if (seed % 4 == 0)
      faster += largest_acceleration(arm, plan_tip_path({stroke}, surfaces::waves, any, free),
                                     start) > 1.3 * settings.joint_acceleration;
  });
  EXPECT_GT(faster, 25) << "the limits must have something to limit";
  EXPECT_GT(reached, 100);
  EXPECT_LE(above, 12);
  EXPECT_EQ(far_above, std::vector<unsigned>{150});
}

TEST(JointRates, NoJointNeedsMoreTorqueThanItsShareAlongRandomPaths) {
  ArmModel arm(surfaces::kArm);
  const JointVector start = surfaces::start_posture(arm);
  PathSettings settings = fast();
  settings.joint_speed_share = 1.0;
  settings.joint_acceleration = 1000.0;
  const DrawingLoad load{.normal_force = 5.0, .friction = 0.3, .torque_share = 0.3};
  PathSettings any = settings;
  any.joint_torque_share = 1.0;
  const JointRates limits(arm, settings, start, start, load),
      free(arm, any, start, start, {.torque_share = 100.0});
  int above = 0, reached = 0;
  for_drawable_strokes(arm, start, [&](unsigned, const PlacedStroke& stroke) {
    const double share = largest_torque_share(
        arm, plan_tip_path({stroke}, surfaces::waves, settings, limits), start, load);
    if (std::isnan(share)) return;
    ++reached;
    EXPECT_LE(share, load.torque_share);
    above += largest_torque_share(arm, plan_tip_path({stroke}, surfaces::waves, settings, free),
                                  start, load) > load.torque_share;
  });
  EXPECT_GT(above, 5) << "the limits must have something to limit";
  EXPECT_GT(reached, 100);
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

// The defect: lines that pass by the base wound the joints up by whole turns, and each stroke after
// such a one crawled.
TEST(JointRates, AStrokeThatWindsTheArmUpSlowsNoneAfterIt) {
  ArmModel arm(surfaces::kArm);
  const JointVector start = surfaces::start_posture(arm);
  const PathSettings settings;
  const PlacedStroke sine = surfaces::shape("sine")[0];
  // Of the sine, the last stroke [s].
  const auto time = [&](const std::vector<PlacedStroke>& strokes) {
    const StrokeTimes last =
        plan_tip_path(strokes, surfaces::waves, settings, JointRates(arm, settings, start, start))
            .strokes()
            .back();
    return last.end - last.start;
  };
  const double alone = time({sine});
  for (unsigned seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> side(-0.9, 0.9);
    std::vector<Eigen::Vector2d> wild;
    for (int i = 0; i < 6; ++i) wild.emplace_back(side(random), side(random));
    EXPECT_LT(time({surfaces::line(wild), sine}), 1.3 * alone);
  }
}

}  // namespace
}  // namespace impedraw
