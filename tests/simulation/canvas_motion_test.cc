// A canvas that moves: its kinematics against finite differences, and contact with it against
// closed forms and against a canvas that stands still.
#include "impedraw/simulation/canvas_motion.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "scratch_folder.h"
#include "seeds.h"
#include "worlds.h"

namespace impedraw {
namespace {

using namespace testing_worlds;
using Eigen::Vector3d;

const Vector3d kNoPush = Vector3d::Zero();

Canvas level_plane() {
  PlaneSettings plane;
  plane.centre.setZero();
  plane.width = plane.height = 4.0;
  return Canvas(make_plane(plane));
}

World slider(const Canvas& canvas, double friction, double dt = 1e-3) {
  WorldSettings settings;
  settings.tip.friction = friction;
  settings.dt = dt;
  settings.gravity = 0.0;
  return World(kSlider, &canvas, settings);
}

// At rest under a push of 5 N.
JointVector pressed(double x = 0.0) {
  JointVector q = JointVector::Zero(3);
  q[0] = x;
  q[2] = -5.0 / TipMaterial{}.stiffness;
  return q;
}

JointVector force(double x, double y, double z) {
  JointVector tau(3);
  tau << x, y, z;
  return tau;
}

CanvasMotionSettings conveyor(const Vector3d& velocity) {
  CanvasMotionSettings s;
  s.start = -2.0;  // at full speed from the beginning
  s.velocity = velocity;
  return s;
}

TEST(CanvasMotion, VelocityIsTheDerivativeOfThePose) {
  for (unsigned seed = 1; seed <= seeds(20, 200); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    const auto vector = [&] { return Vector3d(any(rng), any(rng), any(rng)); };
    CanvasMotionSettings s;
    s.centre = vector();
    s.start = any(rng);
    s.stop = s.start + 1.5;
    s.velocity = 0.3 * vector();
    s.turn_axis = vector();
    s.turn_speed = any(rng);
    s.sway = 0.1 * vector();
    s.roll_axis = vector();
    s.roll = 0.3 * any(rng);
    s.jolts = 0.02;
    s.seed = seed;
    const CanvasMotion motion(s);
    for (int i = 0; i < 40; ++i) {
      const double t = s.start - 0.2 + 0.06 * i, h = 1e-5;
      const CanvasMotion::State now = motion.at(t);
      const Vector3d p_K = vector();
      const Vector3d difference =
          (motion.at(t + h).X_WK * p_K - motion.at(t - h).X_WK * p_K) / (2.0 * h);
      EXPECT_LT((now.velocity_at(now.X_WK * p_K) - difference).norm(), 1e-7) << "t = " << t;
      EXPECT_LT((now.X_WK.R.transpose() * now.X_WK.R - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    }
    EXPECT_TRUE(motion.at(s.start - 0.1).X_WK.p.isZero(0.0)) << "K is W before the start";
    EXPECT_TRUE(motion.at(*s.stop + s.ramp + 0.1).v.isZero(1e-15)) << "stopped";
  }
}

TEST(CanvasMotion, AConveyorAndATurntableGoAsFarAsTheirSpeedSays) {
  CanvasMotionSettings s = conveyor({0.0, -0.06, 0.0});
  s.centre = {0.6, 0.0, 0.1};
  s.turn_speed = 0.1;
  const CanvasMotion motion(s);
  const Pose from = motion.at(0.0).X_WK, to = motion.at(10.0).X_WK;
  EXPECT_NEAR((to * s.centre - from * s.centre).y(), -0.6, 1e-12);
  const Eigen::AngleAxisd turn(to.R * from.R.transpose());
  EXPECT_NEAR(turn.angle(), 1.0, 1e-12);
  EXPECT_NEAR(turn.axis().z(), 1.0, 1e-12);
}

TEST(CanvasMotion, JoltsHaveTheirStrengthAndNothingAboveTheirBandwidth) {
  CanvasMotionSettings s;
  s.start = -2.0;
  s.jolts = 0.015;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    s.seed = seed;
    const CanvasMotion motion(s);
    constexpr int kSamples = 8192;
    constexpr double kStep = 0.05;
    Vector3d power = Vector3d::Zero(), acceleration = Vector3d::Zero();
    for (int i = 0; i < kSamples; ++i) {
      const double t = kStep * i, h = 1e-3;
      const Vector3d d = motion.at(t).X_WK.p;
      power += d.cwiseAbs2() / kSamples;
      acceleration =
          acceleration.cwiseMax(((motion.at(t + h).v - motion.at(t - h).v) / (2.0 * h)).cwiseAbs());
    }
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(std::sqrt(power[axis]), s.jolts, 0.05 * s.jolts);
      // RMS of the acceleration of flat noise: jolts (2π f)² / √5; a peak is a few times that
      EXPECT_LT(acceleration[axis], 5.0 * s.jolts * std::pow(2.0 * std::numbers::pi, 2));
    }
    // Correlation with a wave just above the bandwidth.
    double re = 0.0, im = 0.0;
    for (int i = 0; i < kSamples; ++i) {
      const double window = 1.0 - std::cos(2.0 * std::numbers::pi * i / kSamples);
      const double angle = 2.0 * std::numbers::pi * 1.1 * s.jolt_bandwidth * kStep * i;
      const double d = motion.at(kStep * i).X_WK.p.x();
      re += window * d * std::cos(angle) / kSamples;
      im += window * d * std::sin(angle) / kSamples;
    }
    EXPECT_LT(std::hypot(re, im), 1e-3 * s.jolts);
  }
}

TEST(CanvasMotion, RefusesWhatIsNoMotion) {
  CanvasMotionSettings axis;
  axis.turn_axis.setZero();
  EXPECT_THROW(CanvasMotion{axis}, InputError);
  CanvasMotionSettings stop;
  stop.stop = -1.0;
  EXPECT_THROW(CanvasMotion{stop}, InputError);
  stop.stop = stop.start + 0.9 * stop.ramp;
  EXPECT_THROW(CanvasMotion{stop}, InputError);
  CanvasMotionSettings fast;
  fast.velocity = {3.0, 0.0, 0.0};
  EXPECT_THROW(CanvasMotion{fast}, InputError);
}

// Rows of a motion in closed form.
std::string recorded(const CanvasMotion& motion, const Pose& X_KB, double from, double step,
                     int n) {
  std::string text = "t,x,y,z,qw,qx,qy,qz\n";
  for (int i = 0; i < n; ++i) {
    const double t = from + step * i;
    const Pose X_WK = motion.at(t).X_WK;
    const Vector3d p = X_WK * X_KB.p;
    Eigen::Quaterniond q(X_WK.R * X_KB.R);
    if (i % 7 == 3) q.coeffs() *= -1.0;  // is the same rotation
    text += fmt::format("{},{},{},{},{},{},{},{}\n", t + 100.0, p.x(), p.y(), p.z(), q.w(), q.x(),
                        q.y(), q.z());
  }
  return text;
}

CanvasMotionSettings rocking() {
  CanvasMotionSettings s;
  s.start = -2.0;
  s.centre = {0.6, 0.0, 0.1};
  s.sway = {0.02, 0.05, -0.03};
  s.roll_axis = {1.0, 0.5, 0.0};
  s.roll = 0.2;
  return s;
}

TEST(RecordedMotion, PlaysBackWhatWasRecordedOfAnyFrameOfTheBody) {
  const CanvasMotion true_motion(rocking());
  Pose X_KB;
  X_KB.p = {0.3, -0.2, 0.5};
  X_KB.R = Eigen::AngleAxisd(1.0, Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
  const RecordedMotion record(recorded(true_motion, X_KB, 0.0, 0.02, 301), "r.csv");
  EXPECT_NEAR(record.duration(), 6.0, 1e-9);
  const Pose from = true_motion.at(0.0).X_WK;
  for (double t = 0.3; t < 5.7; t += 0.0137) {  // the spline's ends are straight, the motion's not
    const CanvasMotion::State truth = true_motion.at(t);
    const RecordedMotion::State played = record.at(t);
    const Vector3d p_K(0.5, 0.1, 0.2);
    EXPECT_LT((played.X * (from * p_K) - truth.X_WK * p_K).norm(), 2e-6) << "t = " << t;
    const Vector3d v = played.v + played.w.cross(truth.X_WK * p_K - played.p);
    EXPECT_LT((v - truth.velocity_at(truth.X_WK * p_K)).norm(), 2e-4) << "t = " << t;
  }
}

class RecordedMotionFile : public ScratchFolder {};

TEST_F(RecordedMotionFile, StartsAndEndsAtRestAndItsVelocityIsTheDerivative) {
  CanvasMotionSettings s;
  s.start = 1.0;
  s.ramp = 0.4;
  s.file = write("r.csv", recorded(CanvasMotion(rocking()), {}, 0.0, 0.04, 101));
  const CanvasMotion motion(s);
  EXPECT_TRUE(motion.moves());
  for (double t = 0.8; t < 6.0; t += 0.0173) {
    const CanvasMotion::State now = motion.at(t);
    const double h = 1e-5;
    const Vector3d p_K(0.5, 0.1, 0.2);
    const Vector3d difference =
        (motion.at(t + h).X_WK * p_K - motion.at(t - h).X_WK * p_K) / (2.0 * h);
    EXPECT_LT((now.velocity_at(now.X_WK * p_K) - difference).norm(), 1e-6) << "t = " << t;
  }
  EXPECT_TRUE(motion.at(0.9).X_WK.p.isZero(1e-15));
  EXPECT_TRUE(motion.at(1.0 + 4.0 + 0.5).v.isZero(1e-12)) << "stopped where the record ends";
}

TEST(RecordedMotion, RefusesGapsAndJumpsByTheirLine) {
  const auto refused = [](const std::string& rows) -> std::string {
    try {
      RecordedMotion(rows, "r.csv");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const std::string row = "0,0,0,0,1,0,0,0\n";
  EXPECT_EQ(refused(row + "0.1,0.1,0,0,1,0,0,0\n"), "");
  EXPECT_EQ(refused("# tracker\n\n" + row + "0.6,0,0,0,1,0,0,0\n"),
            "r.csv: line 4: a gap of 0.6 s before t = 0.6 s; valid are at most 0.25 s");
  EXPECT_EQ(refused(row + "0.1,0.5,0,0,1,0,0,0\n"),
            "r.csv: line 2: jumps at 5 m/s; valid are at most 2 m/s");
  EXPECT_EQ(refused(row + "0.1,0,0,0,0,1,0,0\n"),
            "r.csv: line 2: turns at 31.4 rad/s; valid are at most 10 rad/s");
  EXPECT_EQ(refused(row + "0,0,0,0,1,0,0,0\n"),
            "r.csv: line 2: t = 0 s does not follow 0 s; times must increase");
  EXPECT_EQ(refused(row + "0.1,0,0,0,1,0,0\n"),
            "r.csv: line 2: has 7 fields; valid are 8: t, x, y, z, qw, qx, qy, qz");
  EXPECT_EQ(refused(row + "0.1,0,nan,0,1,0,0,0\n"), "r.csv: line 2: 'nan' is no number");
  EXPECT_EQ(refused(row + "0.1,0,0,0,0.5,0,0,0\n"),
            "r.csv: line 2: the quaternion's norm is 0.5; valid is 1");
  const std::string next = row + "0.1,0,0,0,1,0,0,0\n";
  EXPECT_EQ(
      refused("# tracker\nt,x,y,z,qx,qy,qz,qw\n" + next),
      "r.csv: line 2: names the columns t, x, y, z, qx, qy, qz, qw; valid are t, x, y, z, qw, "
      "qx, qy, qz in this order");
  for (const char* header : {"time [s],x [m],y [m],z [m],q_w,q_x,q_y,q_z\n", "t,a,b,c,d,e,f,g\n"})
    EXPECT_EQ(refused(header + next), "") << header;
  EXPECT_EQ(refused(row), "r.csv: has fewer than two rows");
  EXPECT_EQ(refused(""), "r.csv: has fewer than two rows");
}

// A block of mass m on a belt of speed u: friction accelerates it by μ F/m until it goes along.
TEST(MovingCanvas, ABeltDragsTheTipAlong) {
  const Canvas canvas = level_plane();
  World world = slider(canvas, 0.3);
  world.set_state(pressed(), JointVector::Zero(3));
  const double u = 0.2, m = world.terms().M(0, 0);
  world.move_canvas(CanvasMotion(conveyor({u, 0.0, 0.0})));
  const double slip_time = u * m / (0.3 * 5.0);  // 0.33 s
  ASSERT_GT(slip_time, 0.1);
  for (int i = 1; i <= 1000; ++i) {
    world.step(force(0.0, 0.0, -5.0), kNoPush);
    const double t = 1e-3 * i, expected = t < slip_time ? 0.3 * 5.0 / m * t : u;
    ASSERT_NEAR(world.state().v[0], expected, 2e-3 * u) << "t = " << t;
  }
}

// Forces depend on relative motion alone: a tip and a belt that both move by u more.
TEST(MovingCanvas, ForcesAreThoseOnAStandingCanvasForTheSameRelativeMotion) {
  const Canvas canvas = level_plane();
  const Vector3d u(0.15, -0.1, 0.05);
  World standing = slider(canvas, 0.3), moving = slider(canvas, 0.3);
  JointVector v = JointVector::Zero(3);
  v[0] = 0.05;
  standing.set_state(pressed(), v);
  CanvasMotionSettings s = conveyor(u);
  const CanvasMotion motion(s);
  JointVector q = pressed();
  q.head<3>() += motion.at(0.0).X_WK.p;  // it moves since −2 s
  v.head<3>() += u;
  moving.move_canvas(motion);
  moving.set_state(q, v);
  for (int i = 0; i < 1000; ++i) {
    const JointVector tau =
        force(1.5 * std::sin(0.01 * i), std::cos(0.02 * i), -5.0 + std::sin(0.05 * i));
    const Vector3d f = standing.step(tau, kNoPush).f_W;
    ASSERT_LT((moving.step(tau, kNoPush).f_W - f).norm(), 1e-6) << "step " << i;
  }
}

// The same on a table that turns, seen from the tip's side: it sticks and goes round with the
// table; the friction is the centripetal force.
TEST(MovingCanvas, ATurntableCarriesTheTipRound) {
  const Canvas canvas = level_plane();
  World world = slider(canvas, 2.0);
  CanvasMotionSettings s;
  s.start = -2.0;
  s.turn_speed = 1.5;
  const CanvasMotion motion(s);
  const double r = 0.3;
  JointVector v = JointVector::Zero(3);
  v[1] = s.turn_speed * r;
  world.move_canvas(motion);
  world.set_state(pressed(r), v);
  const double m_x = world.terms().M(0, 0), m_y = world.terms().M(1, 1);
  for (int i = 1; i <= 2000; ++i) {
    const Vector3d f = world.step(force(0.0, 0.0, -5.0), kNoPush).f_W;
    const double angle = s.turn_speed * 1e-3 * i, a = s.turn_speed * s.turn_speed * r;
    const JointVector& q = world.state().q;
    ASSERT_LT((q.head<2>() - r * Eigen::Vector2d(std::cos(angle), std::sin(angle))).norm(), 1e-3);
    if (i < 10) continue;
    ASSERT_NEAR(f.x(), -m_x * a * std::cos(angle), 0.01 * m_x * a) << "step " << i;
    ASSERT_NEAR(f.y(), -m_y * a * std::sin(angle), 0.01 * m_x * a) << "step " << i;
  }
}

// A tip on a heaving plane: the contact carries the push and accelerates the mass,
// F = push + m z̈ with z = A sin ω t, as its spring is stiff (√(k/m) = 16 ω).
TEST(MovingCanvas, AHeavingPlaneAcceleratesTheTip) {
  const Canvas canvas = level_plane();
  World world = slider(canvas, 0.3);
  CanvasMotionSettings s;
  s.start = -10.0;
  s.sway = {0.0, 0.0, 0.01};
  s.sway_frequency = 1.0;
  world.move_canvas(CanvasMotion(s));
  world.set_state(pressed(), JointVector::Zero(3));
  const double m = world.terms().M(2, 2), w = 2.0 * std::numbers::pi * s.sway_frequency;
  const double k = TipMaterial{}.stiffness;
  // the forced oscillation of m on k and b
  const double b = TipMaterial{}.damping;
  const std::complex<double> i_w(0.0, w), moved = (k + b * i_w) / (k + b * i_w + m * i_w * i_w);
  for (int i = 1; i <= 4000; ++i) {
    const double f = world.step(force(0.0, 0.0, -5.0), kNoPush).f_W.z();
    if (i < 1000) continue;  // the tip has caught up with the plane
    const std::complex<double> phase = std::exp(i_w * (1e-3 * i + 10.0 - 0.5e-3));
    const double z_acceleration = std::imag(0.01 * moved * i_w * i_w * phase);
    ASSERT_NEAR(f, 5.0 + m * z_acceleration, 0.02) << "step " << i;
  }
}

// Contact point and normal are in W, also where the canvas has turned.
TEST(MovingCanvas, ContactIsReportedInTheWorld) {
  const Canvas canvas = level_plane();
  World world = slider(canvas, 0.0);
  CanvasMotionSettings s;
  s.roll = 0.2;
  s.roll_axis = Vector3d::UnitY();
  s.roll_frequency = 0.0;  // sin 0: nothing
  s.start = -2.0;
  s.sway = {0.0, 0.0, 0.1};
  s.sway_frequency = 0.0;
  EXPECT_TRUE(CanvasMotion(s).at(1.0).X_WK.R.isIdentity(1e-15));
  s.roll_frequency = 0.125;  // sin(2π 0.125 · 2) = 1 at t = 0, at rest there
  const CanvasMotion motion(s);
  const Vector3d n = motion.at(0.0).X_WK.R.col(2);
  ASSERT_NEAR(n.z(), std::cos(0.2), 1e-12);
  world.move_canvas(motion);
  JointVector q = JointVector::Zero(3);
  q[0] = 0.1;
  const double radius = TipMaterial{}.radius;
  // the ball's centre is `radius` above the tip
  q[2] = (-n.x() * q[0] + (radius - 1e-4)) / n.z() - radius;
  world.set_state(q, JointVector::Zero(3));
  const TipContact& contact = world.step(JointVector::Zero(3), kNoPush);
  ASSERT_TRUE(contact.touching);
  EXPECT_LT((contact.n_W - n).norm(), 1e-12);
  EXPECT_NEAR(n.dot(contact.p_WC), 0.0, 1e-12);
  EXPECT_NEAR(contact.f_W.normalized().dot(n), 1.0, 1e-12);
}

TEST(MovingCanvas, ACanvasThatMovesIntoALinkIsFound) {
  World probe(kArm, nullptr, {});
  probe.set_state(working_posture(), JointVector::Zero(7));
  const Canvas canvas = plane_under(probe.state().X_WE.p, -0.2);  // 200 mm beneath the tip
  World world(kArm, &canvas, {});
  CanvasMotionSettings s;
  s.ramp = 0.1;
  s.velocity = {0.0, 0.0, 0.25};
  world.move_canvas(CanvasMotion(s));
  world.set_state(working_posture(), JointVector::Zero(7));
  const JointVector hold = world.terms().bias;
  int steps = 0;
  bool touched = false;
  while (world.touching_link().empty() && ++steps < 4000)
    touched |= world.step(hold, kNoPush).touching;
  EXPECT_TRUE(touched) << "the tip, first";
  EXPECT_FALSE(world.touching_link().empty());
}

}  // namespace
}  // namespace impedraw
