// The world's own steps: integration steps within a control step, the drives' torque limits, pushes
// on links, and bodies that touch the canvas.
#include "impedraw/simulation/world.h"

#include <cmath>

#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "worlds.h"

namespace impedraw {
namespace {

using namespace testing_worlds;
const Eigen::Vector3d kNoPush = Eigen::Vector3d::Zero();

WorldSettings with_substeps(int substeps) {
  WorldSettings settings;
  settings.substeps = substeps;
  return settings;
}

TEST(World, SubstepsAreStepsUnderTheSameTorque) {
  const JointVector q = working_posture(), v = JointVector::Constant(7, 0.2);
  World coarse(kArm, nullptr, with_substeps(4)), fine(kArm, nullptr, with({}, 0.25e-3));
  coarse.set_state(q, v);
  fine.set_state(q, v);
  const JointVector tau = 1.02 * coarse.terms().bias;
  for (int i = 0; i < 50; ++i) {
    coarse.step(tau, kNoPush);
    for (int k = 0; k < 4; ++k) fine.step(tau, kNoPush);
  }
  EXPECT_NEAR(coarse.state().time, 0.05, 1e-12);
  EXPECT_EQ(coarse.state().q, fine.state().q);
  EXPECT_EQ(coarse.state().v, fine.state().v);
}

// 2 kg fall on the tip's spring and settle: the force is the weight, and its mean over the fall
// too, however fine the steps.
TEST(World, ContactForceIsTheMeanOverTheStep) {
  double peak[3];
  int k = 0;
  for (const int substeps : {1, 4, 16}) {
    PlaneSettings plane;
    plane.centre = {0.0, 0.0, 0.1};
    const Canvas canvas(make_plane(plane));
    World world(kSlider, &canvas, with_substeps(substeps));
    JointVector q = JointVector::Zero(3);
    q[2] = plane.centre.z() + 1e-4;
    world.set_state(q, JointVector::Zero(3));
    Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
    peak[k] = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const TipContact& contact = world.step(JointVector::Zero(3), kNoPush);
      impulse += 1e-3 * contact.f_W;
      peak[k] = std::max(peak[k], contact.f_W.z());
    }
    const World::Terms terms = world.terms();
    const double weight = terms.bias[2];
    ASSERT_GT(weight, 10.0);
    // Impulse of force and weight is the change of momentum.
    EXPECT_NEAR(impulse.z() - 2.0 * weight, terms.M(2, 2) * world.state().v[2], 1e-6 * weight);
    EXPECT_NEAR(world.step(JointVector::Zero(3), kNoPush).f_W.z(), weight, 1e-3 * weight);
    ++k;
  }
  EXPECT_NEAR(peak[1], peak[0], 0.1 * peak[0]);
  EXPECT_NEAR(peak[2], peak[1], 0.05 * peak[0]);
}

TEST(World, RefusesNoSubsteps) {
  EXPECT_THROW(World(kArm, nullptr, with_substeps(0)), InputError);
  EXPECT_THROW(World(kArm, nullptr, with_substeps(101)), InputError);
}

TEST(World, DrivesGiveAtMostTheEffortOfTheUrdf) {
  JointVector effort(7);
  effort << 320, 320, 176, 176, 110, 40, 40;  // models/iiwa14_pen.urdf
  World world(kArm, nullptr, {});
  world.set_state(working_posture(), JointVector::Zero(7));
  for (const double sign : {1.0, -1.0}) {
    world.step(sign * JointVector::Constant(7, 1e3), kNoPush);
    EXPECT_EQ(world.applied_torque(), JointVector(sign * effort));
  }
  const JointVector within = 0.9 * effort;
  world.step(within, kNoPush);
  EXPECT_EQ(world.applied_torque(), within);
}

// M Δv = h Jᵀ f, J by finite differences of the link's origin, computed here from the URDF.
TEST(World, APushOnALinkActsAtItsOrigin) {
  const auto elbow = [](const JointVector& q) {  // origin of link_4
    const double right = M_PI / 2, half = M_PI;
    const Eigen::Vector3d at[] = {{0, 0, 0.1575}, {0, 0, 0.2025}, {0, 0.2045, 0}, {0, 0, 0.2155}};
    const double roll[] = {0, right, right, right}, yaw[] = {0, half, half, 0};
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    for (int j = 0; j < 4; ++j)
      X = X * Eigen::Translation3d(at[j]) * Eigen::AngleAxisd(yaw[j], Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(roll[j], Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(q[j], Eigen::Vector3d::UnitZ());
    return Eigen::Vector3d(X.translation());
  };
  const JointVector q = working_posture();
  World world(kArm, nullptr, {});
  const auto link = world.link("link_4");
  ASSERT_TRUE(link);
  EXPECT_FALSE(world.below_flange(*link));
  EXPECT_TRUE(world.below_flange(world.link("pen").value()));
  EXPECT_FALSE(world.link("link_44"));
  const Eigen::Vector3d f(3.0, 20.0, -7.0);
  Eigen::Matrix<double, 3, 7> J;
  for (int j = 0; j < 7; ++j) {
    JointVector step = JointVector::Zero(7);
    step[j] = 1e-6;
    J.col(j) = (elbow(q + step) - elbow(q - step)) / 2e-6;
  }
  world.set_state(q, JointVector::Zero(7));
  const World::Terms terms = world.terms();
  world.push_link(*link, f);
  world.step(terms.bias, kNoPush);
  const Eigen::VectorXd impulse = terms.M * world.state().v;
  EXPECT_LT((impulse - 1e-3 * J.transpose() * f).norm(), 1e-7);
  EXPECT_GT(impulse.norm(), 1e-3);
  // It lasts for one step.
  world.set_state(q, JointVector::Zero(7));
  world.step(terms.bias, kNoPush);
  EXPECT_LT(world.state().v.norm(), 1e-9);
}

// A square about a point and with a normal.
Canvas square_at(const Eigen::Vector3d& p_W, const Eigen::Vector3d& n_W, double half = 0.1) {
  const Eigen::Vector3d u = half * n_W.unitOrthogonal(), v = n_W.cross(u);
  return Canvas(
      TriangleMesh{{p_W - u - v, p_W + u - v, p_W + u + v, p_W - u + v}, {{0, 1, 2}, {0, 2, 3}}});
}

// The pen's shaft is a cylinder of radius 5 mm that ends 10 mm above the tip. A plane through the
// tip at an angle to it touches the cylinder's rim where tan(angle) > 2: 63.4°.
TEST(World, SaysWhichLinkTouchesTheCanvas) {
  World probe(kArm, nullptr, {});
  probe.set_state(working_posture(), JointVector::Zero(7));
  const Pose X_WE = probe.state().X_WE;
  const auto touching = [&](const Eigen::Vector3d& p_W, const Eigen::Vector3d& n_W,
                            double half = 0.1) {
    const Canvas canvas = square_at(p_W, n_W, half);
    World world(kArm, &canvas, {});
    world.set_state(working_posture(), JointVector::Zero(7));
    world.step(world.terms().bias, kNoPush);
    return world.touching_link();
  };
  const auto tilted = [&](double degrees) {
    const double angle = degrees * M_PI / 180.0;
    return Eigen::Vector3d(-std::cos(angle) * X_WE.R.col(2) + std::sin(angle) * X_WE.R.col(0));
  };
  EXPECT_EQ(touching(X_WE.p, tilted(0.0)), "");
  EXPECT_EQ(touching(X_WE.p, tilted(62.0)), "");
  EXPECT_EQ(touching(X_WE.p, tilted(65.0)), "pen");
  EXPECT_EQ(touching(X_WE.p - 0.06 * X_WE.R.col(2), tilted(30.0)), "pen") << "pierced";
  // The flange's end, 120 mm above the tip, is flat and has a radius of 45 mm.
  const auto beside = [&](double h, double away) {
    return touching(X_WE.p - h * X_WE.R.col(2) + away * X_WE.R.col(0), X_WE.R.col(0), 5e-3);
  };
  EXPECT_EQ(beside(0.130, 0.044), "link_7");
  EXPECT_EQ(beside(0.130, 0.046), "");
  EXPECT_EQ(beside(0.114, 0.030), "") << "below its end";
}

// Distances are not queried at every step; a body that moves in is found all the same.
TEST(World, FindsALinkThatMovesIntoTheCanvas) {
  World probe(kArm, nullptr, {});
  probe.set_state(working_posture(), JointVector::Zero(7));
  const Pose X_WE = probe.state().X_WE;
  const Eigen::Vector3d side = X_WE.R.col(0);
  // 30 mm beside the shaft's middle
  const Canvas canvas = square_at(X_WE.p - 0.06 * X_WE.R.col(2) + 0.03 * side, -side, 0.03);
  World world(kArm, &canvas, {});
  world.set_state(working_posture(), JointVector::Zero(7));
  const JointVector hold = world.terms().bias;
  int steps = 0;
  while (world.touching_link().empty() && ++steps < 1000) world.step(hold, 30.0 * side);
  ASSERT_LT(steps, 1000);
  EXPECT_EQ(world.touching_link(), "pen");
  // The shaft's nearest point has come to the plane by the tip's way, within a step's motion.
  const Pose now = world.state().X_WE;
  double nearest = 1.0;
  for (double h = 0.03; h <= 0.09; h += 1e-4) {  // over the square
    const Eigen::Vector3d p = now.p - h * now.R.col(2);
    nearest = std::min(nearest, 0.03 - (p - X_WE.p).dot(side));
  }
  EXPECT_LT(nearest, 0.005 + 1e-4);
  EXPECT_GT(nearest, 0.005 - 2e-3);
}

// A thin sheet has two sides: which one its triangles show makes no difference to the tip.
TEST(World, AnOpenSheetResistsFromBehind) {
  World probe(kArm, nullptr, {});
  probe.set_state(working_posture(), JointVector::Zero(7));
  const Pose X_WE = probe.state().X_WE;
  const Eigen::Vector3d ahead = X_WE.R.col(2);
  const auto pushed = [&](const Eigen::Vector3d& n_W) {
    const Canvas canvas = square_at(X_WE.p + 0.02 * ahead, n_W);
    World world(kArm, &canvas, {});
    world.set_state(working_posture(), JointVector::Zero(7));
    double most = 0.0;
    for (int i = 0; i < 400; ++i) {
      world.step(world.terms().bias, 5.0 * ahead);
      most = std::max(most, (world.state().X_WE.p - X_WE.p).dot(ahead));
    }
    return most;
  };
  const double front = pushed(-ahead);
  EXPECT_GT(front, 0.020);
  EXPECT_LT(front, 0.025);
  EXPECT_NEAR(pushed(ahead), front, 1e-12);
}

}  // namespace
}  // namespace impedraw
