// A pen that hammers, by itself and in the sampled loop of contact_stability.h.
#include "impedraw/control/stiff_contact.h"

#include <cmath>
#include <deque>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "impedraw/control/contact_stability.h"

namespace impedraw {
namespace {

constexpr double kStep = 1e-3, kPush = 5.0;

StiffContact shaped() { return StiffContact(ImpedanceSettings()); }

double step(StiffContact* stiff, double force, ContactMode mode = ContactMode::contact) {
  Contact contact;
  contact.mode = mode;
  contact.force = kPush;
  return stiff->update(contact, force * Wrench::Unit(2));
}

// s after `time` [s] of that force.
double own_share(const std::function<double(double t)>& force, double time = 1.0,
                 StiffContact stiff = shaped()) {
  double s = 0.0;
  for (double t = 0.0; t < time; t += kStep) s = step(&stiff, force(t));
  return s;
}

double wave(double frequency, double t) { return std::sin(2.0 * std::numbers::pi * frequency * t); }

TEST(StiffContact, GivesTheInertiaBackWhileTheForceSwings) {
  EXPECT_GT(own_share([](double t) { return kPush + 2.0 * wave(30.0, t); }), 0.99);
  EXPECT_GT(own_share([](double t) { return std::max(0.0, 30.0 * wave(15.0, t)); }), 0.99)
      << "blows of 33 ms, with as long in the air";
  EXPECT_EQ(own_share([](double t) { return kPush + 1.2 * wave(30.0, t); }), 0.0) << "2.4 N";
}

TEST(StiffContact, LeavesBlowsRoughGroundAndNoiseAlone) {
  constexpr unsigned kSeed = 20261130;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::normal_distribution<double> noise(0.0, 0.3);
  EXPECT_EQ(own_share([&](double) { return kPush + noise(rng); }), 0.0);
  EXPECT_EQ(own_share([](double t) { return kPush + 5.0 * wave(18.0, t); }), 0.0) << "slow";
  EXPECT_EQ(own_share([](double t) {
              return std::max(0.0, kPush + 40.0 * std::exp(-24.0 * t) * wave(30.0, t));
            }),
            0.0)
      << "each swing 0.67 of the one before";
}

TEST(StiffContact, KeepsItWhileThePenIsUp) {
  StiffContact stiff = shaped();
  for (double t = 0.0; t < 0.2; t += kStep) step(&stiff, kPush + 3.0 * wave(30.0, t));
  const double s = stiff.own();
  EXPECT_GT(s, 0.5);
  for (double t = 0.0; t < 1.0; t += kStep) EXPECT_EQ(step(&stiff, 0.0, ContactMode::free), s);
  EXPECT_GE(own_share([](double) { return kPush; }, 1.0, stiff), s);
}

// Greatest force in the last quarter of a second of four, on a spring that the loop is not stable
// with if `bears` is absent.
double force_after(const ContactLoop& loop, bool bears) {
  StiffContact stiff = shaped();
  std::deque<double> late(static_cast<std::size_t>(loop.delay_steps) + 1, 0.0);
  double x = kPush / loop.contact_stiffness, v = 1e-3, most = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double f = std::max(0.0, loop.contact_stiffness * x);
    late.push_back(f);
    late.pop_front();
    const double s = bears ? step(&stiff, late.front()) : 0.0,
                 lighter = (1.0 - s) * loop.natural_mass / loop.desired_mass + s,
                 u = lighter * (kPush - loop.damping * v - late.front()) + late.front();
    v += loop.dt / loop.natural_mass * (u - f);
    x += loop.dt * v;
    if (i >= 3750) most = std::max(most, f);
  }
  return most;
}

TEST(StiffContact, CalmsTheLoopThatItsDelayMakesUnstable) {
  ContactLoop loop{.natural_mass = 8.0,
                   .desired_mass = 2.4,
                   .damping = 100.0,
                   .contact_stiffness = 2e5,
                   .dt = kStep,
                   .delay_steps = 3};
  ASSERT_GT(spectral_radius(loop), 1.0);
  EXPECT_GT(force_after(loop, false), 4.0 * kPush);
  EXPECT_LT(force_after(loop, true), 1.2 * kPush);
  loop.contact_stiffness = 2e4;
  ASSERT_LT(spectral_radius(loop), 1.0);
  EXPECT_EQ(force_after(loop, true), force_after(loop, false));
}

}  // namespace
}  // namespace impedraw
