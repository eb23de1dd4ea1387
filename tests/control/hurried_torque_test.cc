// A blow that asks the torques to change faster than they may, by itself and in a sampled loop.
#include "impedraw/control/hurried_torque.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

constexpr double kStep = 1e-3, kPush = 5.0;

double step(HurriedTorque* hurried, double force, bool limited,
            ContactMode mode = ContactMode::contact) {
  Contact contact;
  contact.mode = mode;
  contact.force = kPush;
  return hurried->update(contact, force * Wrench::Unit(2), limited);
}

double own_share(int steps, double force, bool limited, ContactMode mode = ContactMode::contact,
                 const ImpedanceSettings& settings = {}) {
  HurriedTorque hurried(settings);
  double s = 0.0;
  for (int i = 0; i < steps; ++i) s = step(&hurried, force, limited, mode);
  return s;
}

TEST(HurriedTorque, GivesTheInertiaBackDuringAHardBlowOnly) {
  EXPECT_GT(own_share(40, 4.0 * kPush, true), 0.95);
  EXPECT_EQ(own_share(HurriedTorque::kPatience - 1, 4.0 * kPush, true), 0.0) << "a touch";
  EXPECT_EQ(own_share(40, 1.5 * kPush, true), 0.0) << "no blow";
  EXPECT_EQ(own_share(40, 4.0 * kPush, false), 0.0) << "torques follow";
  EXPECT_EQ(own_share(40, 4.0 * kPush, true, ContactMode::approach), 0.0);
  ImpedanceSettings natural;
  natural.inertia = InertiaShaping::natural;
  EXPECT_EQ(own_share(40, 4.0 * kPush, true, ContactMode::contact, natural), 0.0);
}

TEST(HurriedTorque, TakesItAgainOnceTheTorquesFollow) {
  HurriedTorque hurried{ImpedanceSettings()};
  for (int i = 0; i < 40; ++i) step(&hurried, 4.0 * kPush, true);
  double s = 1.0;
  for (int i = 0; i < 300; ++i) s = step(&hurried, kPush, false);
  EXPECT_NEAR(s, 1.0 / std::exp(1.0), 0.05);
  for (int i = 0; i < 3000; ++i) s = step(&hurried, kPush, false);
  EXPECT_EQ(s, 0.0);
  for (int i = 0; i < 40; ++i) step(&hurried, 4.0 * kPush, true);
  hurried.reset();
  EXPECT_EQ(step(&hurried, kPush, false), 0.0);
}

// Greatest force from the second half of a second on, after a touch at 0.1 m/s: a tip of 13 kg
// that is to be one of 2.4 kg, by a force that changes by no more than 1.4 kN/s.
double force_after_a_blow(bool bears) {
  constexpr double kMass = 13.0, kDesired = 2.4, kDamping = 190.0, kStiffness = 4e4, kRate = 1400.0;
  HurriedTorque hurried{ImpedanceSettings()};
  std::deque<double> late(3, 0.0);
  double x = 0.0, v = 0.1, u = 0.0, most = 0.0;
  bool limited = false;
  for (int i = 0; i < 2000; ++i) {
    const double f = std::max(0.0, kStiffness * x);
    late.push_back(f);
    late.pop_front();
    const double s = bears ? step(&hurried, late.front(), limited) : 0.0,
                 lighter = (1.0 - s) * kMass / kDesired + s,
                 wish = lighter * (kPush - kDamping * v - late.front()) + late.front(),
                 within = std::clamp(wish, u - kRate * kStep, u + kRate * kStep);
    limited = within != wish;
    u = within;
    v += kStep / kMass * (u - f);
    x += kStep * v;
    if (i >= 500) most = std::max(most, f);
  }
  return most;
}

TEST(HurriedTorque, CalmsTheLoopWhoseTorquesAreTooSlow) {
  EXPECT_GT(force_after_a_blow(false), 2.0 * kPush);
  EXPECT_LT(force_after_a_blow(true), 1.2 * kPush);
}

}  // namespace
}  // namespace impedraw
