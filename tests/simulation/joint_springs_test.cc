// Joints with springs against closed forms: deflection, resonance and anti-resonance, the torque
// loop's frequency response, energy, and the gear's friction.
#include "impedraw/simulation/joint_springs.h"

#include <cmath>
#include <complex>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "impedraw/common/errors.h"
#include "worlds.h"

namespace impedraw {
namespace {

using namespace testing_worlds;
using Complex = std::complex<double>;
const Eigen::Vector3d kNoPush = Eigen::Vector3d::Zero();
constexpr double kMass = 2.5;  // of the slider along its first joint [kg]

WorldSettings elastic(double K, double D, double B, double loop = 0.0, double dt = 1e-3) {
  WorldSettings settings = with({}, dt);
  settings.gravity = 0.0;
  settings.joint_spring.stiffness = {K};
  settings.joint_spring.damping = {D};
  settings.joint_spring.rotor_inertia = {B};
  settings.joint_spring.loop_bandwidth = loop;
  return settings;
}

// Amplitude and phase at ω of samples a step of dt apart, beside a drift at constant speed.
Complex response(const std::vector<double>& samples, double omega, double dt) {
  const auto n = static_cast<Eigen::Index>(samples.size());
  Eigen::MatrixXd A(n, 4);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = dt * static_cast<double>(i);
    A.row(i) << std::sin(omega * t), std::cos(omega * t), 1.0, t;
  }
  const Eigen::VectorXd x =
      A.colPivHouseholderQr().solve(Eigen::Map<const Eigen::VectorXd>(samples.data(), n));
  return {x[0], x[1]};
}

TEST(JointSprings, StandStillUnderGravityAndGiveAsTheTorqueSays) {
  WorldSettings settings;
  settings.joint_spring.arm = SpringsOf::iiwa;
  World world(kArm, nullptr, settings);
  const JointVector q = working_posture();
  world.set_state(q, JointVector::Zero(7));
  const JointVector g = world.terms().bias;
  for (int i = 0; i < 1000; ++i) world.step(g, kNoPush);
  EXPECT_LT((world.state().q - q).norm(), 1e-9);
  EXPECT_LT((world.springs()->theta() - q - g / 1e4).norm(), 1e-9);
  EXPECT_GT(g.cwiseAbs().maxCoeff(), 20.0);  // 2 mrad

  // A push that the motors hold: the loop sees it, the links give.
  WorldSettings held = elastic(5e3, 50.0, 1.0);
  World slider(kSlider, nullptr, held);
  slider.set_state(JointVector::Zero(3), JointVector::Zero(3));
  for (int i = 0; i < 4000; ++i)
    slider.step(-8.0 * JointVector::Unit(3, 0), Eigen::Vector3d(8.0, 0.0, 0.0));
  EXPECT_NEAR(slider.state().q[0] - slider.springs()->theta()[0], 8.0 / 5e3, 1e-6);
}

TEST(JointSprings, RotorAndLinkRespondAsTwoMassesOnASpring) {
  const double K = 4e3, D = 8.0, B = 1.5, dt = 5e-4;
  const double anti = std::sqrt(K / kMass), resonance = std::sqrt(K * (1.0 / B + 1.0 / kMass));
  for (const double omega :
       {0.5 * anti, anti, 0.5 * (anti + resonance), resonance, 1.5 * resonance}) {
    World world(kSlider, nullptr, elastic(K, D, B, 0.0, dt));
    world.set_state(JointVector::Zero(3), JointVector::Zero(3));
    std::vector<double> link, rotor;
    for (int i = 0; i < 16000; ++i) {
      if (i >= 10000) {
        link.push_back(world.state().q[0]);
        rotor.push_back(world.springs()->theta()[0]);
      }
      world.step(std::sin(omega * dt * (i - 10000)) * JointVector::Unit(3, 0), kNoPush);
    }
    const Complex s(0.0, omega), spring = D * s + K;
    const Complex whole = s * s * (B * kMass * s * s + (B + kMass) * spring);
    EXPECT_LT(std::abs(response(link, omega, dt) * whole / spring - 1.0), 0.03) << omega;
    EXPECT_LT(std::abs(response(rotor, omega, dt) - (kMass * s * s + spring) / whole),
              0.03 * std::abs(spring / whole))
        << omega;
  }
}

TEST(JointSprings, TheTorqueLoopIsASecondOrderLowPassWithTheLinkHeld) {
  const double K = 1e4, B = 2.0, loop = 200.0, h = 2e-4;
  WorldSettings settings = elastic(K, 0.0, B, loop);
  const JointVector none = JointVector::Zero(1);
  JointSprings springs(settings.joint_spring, none, GearFriction({}, none), h);
  for (const double omega : {20.0, 100.0, 200.0, 300.0, 600.0}) {
    springs.reset(none, none, none);
    std::vector<double> torque;
    for (int i = 0; i < 8000; ++i) {
      springs.begin(JointVector::Constant(1, std::sin(omega * h * (i - 3000))), none, none);
      springs.finish(none);
      if (i >= 3000) torque.push_back(springs.torque()[0]);
    }
    const Complex s(0.0, omega);
    const Complex expected =
        loop * loop / (s * s + 2.0 * JointSprings::kLoopDamping * loop * s + loop * loop);
    EXPECT_LT(std::abs(response(torque, omega, h) - expected), 0.05 * std::abs(expected)) << omega;
  }
}

TEST(JointSprings, TheLoopLeavesItsInertiaAndAShareOfTheFriction) {
  const double K = 1e4, B = 2.0, loop = 200.0, left = K / (loop * loop), share = left / B;
  World world(kSlider, nullptr, elastic(K, 10.0, B, loop));
  world.set_state(JointVector::Zero(3), JointVector::Zero(3));
  for (int i = 0; i < 1000; ++i) world.step(3.0 * JointVector::Unit(3, 0), kNoPush);
  EXPECT_NEAR(world.state().v[0], 3.0 / (kMass + left), 0.02 * 3.0 / (kMass + left));

  WorldSettings rough = elastic(K, 10.0, B, loop);
  rough.joint_friction = 8.0;  // on the link, more than it is asked for
  World gear(kSlider, nullptr, rough);
  for (const double torque : {0.9 * 8.0 * share, 1.1 * 8.0 * share}) {
    gear.set_state(JointVector::Zero(3), JointVector::Zero(3));
    for (int i = 0; i < 2000; ++i) gear.step(torque * JointVector::Unit(3, 0), kNoPush);
    const double free = 2.0 * (torque - 8.0 * share) / (kMass + left);
    EXPECT_NEAR(gear.state().v[0], std::max(0.0, free), 0.02 * 0.1 + 0.03 * std::abs(free));
  }
  WorldSettings viscous = elastic(K, 10.0, B, loop);
  viscous.errors.viscous_friction = 20.0;
  World oiled(kSlider, nullptr, viscous);
  oiled.set_state(JointVector::Zero(3), JointVector::Zero(3));
  for (int i = 0; i < 20000; ++i) oiled.step(JointVector::Unit(3, 0), kNoPush);
  EXPECT_NEAR(oiled.state().v[0], 1.0 / (20.0 * share), 1e-3);
}

TEST(JointSprings, TheSensorsOffsetIsWhatTheLoopTakesForTorque) {
  const double K = 1e4, B = 2.0, loop = 200.0, share = K / (loop * loop) / B;
  WorldSettings settings = elastic(K, 10.0, B, loop);
  settings.joint_spring.sensor_offset = 0.7;
  const JointVector none = JointVector::Zero(2);
  JointSprings springs(settings.joint_spring, none, GearFriction({}, none), 1e-3);
  springs.reset(none, none, none);
  for (int i = 0; i < 3000; ++i) {
    springs.begin(JointVector::Constant(2, 5.0), none, none);
    springs.finish(none);
  }
  EXPECT_NEAR(springs.torque()[0], 5.0 - 0.7 * (1.0 - share), 1e-6);
  EXPECT_NEAR(springs.torque()[1], 5.0 + 0.7 * (1.0 - share), 1e-6);
}

// Of the scheme: ½ K (δ − h δ̇/2)² beside the kinetic energies. It stays without damping at any
// step, however stiff the spring, and only falls with it, to that of the whole's motion.
TEST(JointSprings, EnergyStaysWithoutDampingAndNeverGrows) {
  for (const double K : {1e3, 1e5, 1e6}) {
    for (const double D : {0.0, 5.0}) {
      const double B = 0.05, h = 1e-3;
      World world(kSlider, nullptr, elastic(K, D, B));
      world.set_state(JointVector::Zero(3), JointVector::Zero(3));
      world.step(40.0 * JointVector::Unit(3, 0), kNoPush);
      const auto energy = [&] {
        const double v = world.state().v[0], w = world.springs()->theta_rate()[0],
                     delta = world.springs()->theta()[0] - world.state().q[0] - 0.5 * h * (w - v);
        return 0.5 * (kMass * v * v + B * w * w + K * delta * delta);
      };
      const double first = energy();
      double last = first;
      for (int i = 0; i < 5000; ++i) {
        world.step(JointVector::Zero(3), kNoPush);
        ASSERT_LE(energy(), last + 1e-9 * first) << i;
        last = energy();
      }
      const double drift = 0.5 * (kMass + B) * std::pow(40.0 * h / (kMass + B), 2);  // of the whole
      EXPECT_NEAR(last, D > 0.0 ? drift : first, 1e-6 * first);
    }
  }
}

TEST(JointSprings, AnArmThatRingsFreelyComesToRest) {
  WorldSettings settings;
  settings.gravity = 0.0;
  for (const SpringsOf arm : {SpringsOf::iiwa, SpringsOf::fr3, SpringsOf::harmonic_drive}) {
    settings.joint_spring.arm = arm;
    World world(kArm, nullptr, settings);
    world.set_state(working_posture(), JointVector::Zero(7));
    std::mt19937 rng(3);
    for (int i = 0; i < 10; ++i) world.step(random_vector(rng, 7, 30.0), kNoPush);
    const auto ringing = [&] { return (world.springs()->theta_rate() - world.state().v).norm(); };
    double early = 0.0, late = 0.0;
    for (int i = 0; i < 3000; ++i) {
      world.step(JointVector::Zero(7), kNoPush);
      if (i < 100) early = std::max(early, ringing());
      if (i >= 2900) late = std::max(late, ringing());
    }
    EXPECT_FALSE(world.failure());
    EXPECT_LT(late, 0.2 * early);
  }
}

TEST(JointSprings, TheSensorsReadTheSideThatIsAskedFor) {
  WorldSettings settings;
  settings.joint_spring.arm = SpringsOf::harmonic_drive;  // publishes the motor's
  for (const SpringSide side : {SpringSide::as_published, SpringSide::motor, SpringSide::link}) {
    settings.joint_spring.reading = side;
    World world(kArm, nullptr, settings);
    world.set_state(working_posture(), JointVector::Zero(7));
    EXPECT_EQ(world.sensed_q() == world.state().q, side == SpringSide::link);
  }
}

TEST(JointSprings, AreRefusedByNameWhatTheyLack) {
  const auto message = [](const WorldSettings& settings, const char* arm) -> std::string {
    try {
      World(arm, nullptr, settings);
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  };
  WorldSettings settings;
  settings.joint_spring.stiffness = {1e4};
  EXPECT_THAT(message(settings, kArm), testing::HasSubstr("rotor_inertia is empty"));
  settings.joint_spring.rotor_inertia = {0.1, 0.2};
  EXPECT_THAT(message(settings, kArm), testing::HasSubstr("rotor_inertia has 2 entries"));
  settings.joint_spring.rotor_inertia = {0.1};
  EXPECT_EQ(message(settings, kArm), "accepted");
  settings.joint_spring.stiffness = {1.0};
  EXPECT_THAT(message(settings, kArm), testing::HasSubstr("stiffness"));
  settings.joint_spring = {};
  settings.joint_spring.arm = SpringsOf::iiwa;
  EXPECT_THAT(message(settings, kSlider), testing::HasSubstr("iiwa, which has 7 joints"));
  settings.errors.rotor_inertia = {0.1};
  EXPECT_THAT(message(settings, kArm), testing::HasSubstr("world.errors.rotor_inertia"));
}

// Stribeck's curve, typed in again, as the speed that a step takes from a slide.
TEST(JointSprings, AMotorThatSticksStandsWhileItsLinkMoves) {
  JointSprings springs(elastic(4e3, 8.0, 1.5).joint_spring, JointVector::Zero(1),
                       GearFriction({}, JointVector::Constant(1, 50.0)), 1e-3);
  const JointVector zero = JointVector::Zero(1), v = JointVector::Constant(1, 0.1);
  springs.reset(zero, zero, zero);
  springs.begin(zero, zero, v);
  springs.finish(v);
  EXPECT_NEAR(springs.theta_rate()[0], 0.0, 1e-15);
}

TEST(GearFriction, FollowsStribecksCurveLoadAndPlace) {
  const double coulomb = 1.5, h = 1e-3;
  for (const double v : {1e-3, 0.01, 0.02, 0.05, 0.5}) {
    for (const double q : {0.0, 0.03, 0.1}) {
      WorldSettings settings;
      settings.errors.stiction = 1.8;
      settings.errors.stribeck_speed = 0.02;
      settings.errors.load_friction = 0.1;
      settings.errors.friction_ripple = 0.3;
      settings.joint_friction = coulomb;
      World world(kSlider, nullptr, settings);
      world.set_state(q * JointVector::Unit(3, 0), v * JointVector::Unit(3, 0));
      world.step(-4.0 * JointVector::Unit(3, 0), kNoPush);
      const double at = std::exp(-v * v / 4e-4);
      const double friction = (coulomb + 0.4) * (1.0 + 0.8 * at) *
                              (1.0 + 0.3 * std::sin(30.0 * q + 2.0 * M_PI * 0.618034));
      const double fall = h * (4.0 + friction) / kMass;
      if (fall < v) {
        EXPECT_NEAR(world.state().v[0], v - fall, 1e-12);
      }
    }
  }
  // At rest it holds the stiction, and no more.
  WorldSettings settings;
  settings.errors.stiction = 1.8;
  settings.joint_friction = coulomb;
  World world(kSlider, nullptr, settings);
  for (const double torque : {1.79 * coulomb, 1.81 * coulomb}) {
    world.set_state(JointVector::Zero(3), JointVector::Zero(3));
    world.step(torque * JointVector::Unit(3, 0), kNoPush);
    EXPECT_EQ(world.state().v[0] > 1e-9, torque > 1.8 * coulomb);
  }
}

class Sliding : public testing::Test {
 protected:
  // 5 N on a level plane at 0.1 m/s for 0.5 s; calls each(contact) after every step.
  template <typename Each>
  void slide(World* world, Each each) {
    world->set_state(-2e-4 * JointVector::Unit(3, 2), 0.1 * JointVector::Unit(3, 0));
    JointVector u = world->terms().bias;
    u[2] -= 5.0;
    for (int i = 0; i < 500; ++i) {
      u[0] = 2000.0 * (0.1 - world->state().v[0]);
      each(world->step(u, kNoPush));
    }
  }
  Canvas canvas_ = plane_under(Eigen::Vector3d::Zero(), 0.0);
};

TEST_F(Sliding, FrictionVariesAlongTheLine) {
  WorldSettings settings;
  settings.tip.friction_change = 0.5;
  settings.tip.friction_length = 0.02;
  World world(kSlider, &canvas_, settings);
  double s = 0.0, least = 1.0, most = 0.0;
  slide(&world, [&](const TipContact& contact) {
    if (!contact.touching) return;
    const double mu = -contact.f_W.x() / contact.f_W.z();
    EXPECT_NEAR(mu, 0.3 * (1.0 + 0.5 * std::sin(2.0 * M_PI * s / 0.02)), 1e-6);
    s += 1e-3 * world.state().v[0];
    least = std::min(least, mu);
    most = std::max(most, mu);
  });
  EXPECT_NEAR(world.line().slid(), s, 1e-9);
  EXPECT_LT(least, 0.16);
  EXPECT_GT(most, 0.44);
}

TEST_F(Sliding, TheTipWearsByForceAndWay) {
  WorldSettings settings;
  settings.tip.wear = 1e-4;
  World world(kSlider, &canvas_, settings);
  double worn = 0.0;
  slide(&world, [&](const TipContact& contact) {
    worn += 1e-4 * contact.f_W.z() * 1e-3 * world.state().v[0];
  });
  EXPECT_NEAR(world.line().worn(), worn, 1e-12);
  EXPECT_NEAR(worn, 1e-4 * 5.0 * 0.05, 0.05 * worn);
  // Worn off, the tip stands lower by as much, pressed in by F/k.
  EXPECT_NEAR(world.state().X_WE.p.z(), -worn - 5.0 / 20e3, 1e-5);
}

}  // namespace
}  // namespace impedraw
