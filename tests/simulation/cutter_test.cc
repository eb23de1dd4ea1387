// Forces of a cutter against a sum over its edge, and a slider that cuts against the closed form.
#include "impedraw/simulation/cutter_contact.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "simulation/worlds.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;
using testing_worlds::kSlider;

// Sum over rings of the cone and places of its turn: x along the way, z up. The groove has the
// cone's own shape, with its floor on the way.
Vector3d summed(const CutterSettings& s, double depth, double groove, double speed) {
  const double c = speed / (s.flutes * s.turns), slope = std::tan(s.half_angle);
  constexpr int kRings = 400, kTurns = 4000;
  const double dz = depth / kRings;
  Vector3d f = Vector3d::Zero();
  for (int i = 0; i < kRings; ++i)
    for (int j = 0; j < kTurns; ++j) {
      const double z = (i + 0.5) * dz, phi = 2.0 * pi * (j + 0.5) / kTurns;
      const Vector3d out(std::sin(phi), std::cos(phi), 0.0),
          motion(std::cos(phi), -std::sin(phi), 0);
      if (out.x() <= 0.0) continue;  // behind, all is cut
      if (groove > 0.0 && std::abs(z * slope * out.y()) < (z - (depth - groove)) * slope) continue;
      const double db = dz / std::cos(s.half_angle), h = c * out.x() * std::cos(s.half_angle);
      const Vector3d cone =
          std::cos(s.half_angle) * out - std::sin(s.half_angle) * Vector3d::UnitZ();
      f -= db * ((s.K_tc * h + s.K_te) * motion + (s.K_rc * h + s.K_re) * cone);
    }
  return s.hardness * s.flutes / kTurns * f;
}

TEST(CutForces, AreTheSumOverTheEdge) {
  CutterSettings s;
  for (const double angle : {30.0, 45.0, 60.0})
    for (const double groove : {0.0, 0.75e-4, 2e-4, 2.9e-4}) {
      s.half_angle = angle * pi / 180.0;
      s.flutes = angle > 50.0 ? 2 : 1;
      s.hardness = angle / 45.0;
      const CutForces f = cut_forces(s, 3e-4, groove, 0.03);
      const Vector3d sum = summed(s, 3e-4, groove, 0.03);
      const double near = 0.02 * f.normal;
      EXPECT_NEAR(f.normal, sum.z(), near) << angle << " " << groove;
      EXPECT_NEAR(f.drag, -sum.x(), near) << angle << " " << groove;
      EXPECT_NEAR(f.side, std::abs(sum.y()), near) << angle << " " << groove;
    }
  EXPECT_EQ(cut_forces(s, 2e-4, 2e-4, 0.03).normal, 0.0);
}

struct Slide {
  World world;
  explicit Slide(const Canvas& canvas, double hardness = 1.0)
      : world(kSlider, &canvas, [&] {
          WorldSettings settings;
          settings.gravity = 0.0;
          settings.cutter.emplace().hardness = hardness;
          return settings;
        }()) {}
  // Along x from x0 for 20 mm at 20 mm/s, pressed by `force`; the mean depth of the last quarter.
  double cut(double x0, double y, double force, Vector3d* contact = nullptr) {
    JointVector q(3), v(3);
    q << x0, y, 0.0;
    v << 0.02, 0.0, 0.0;
    world.set_state(q, v);
    double sum = 0.0;
    Vector3d f = Vector3d::Zero();
    for (int i = 0; i < 1000; ++i) {
      const WorldState& now = world.state();
      JointVector tau(3);  // holds the way and its speed
      tau << 5e3 * (x0 + 0.02 * now.time - now.q[0]) + 200.0 * (0.02 - now.v[0]),
          5e5 * (y - now.q[1]) - 2e3 * now.v[1], -force;
      const TipContact& contact_now = world.step(tau, Vector3d::Zero());
      if (i < 750) continue;
      sum -= now.q[2] / 250.0;
      f += contact_now.f_W / 250.0;
    }
    if (contact) *contact = f;
    return sum;
  }
};

TEST(Cutter, SinksAsDeepAsItsForceCuts) {
  const Canvas canvas = testing_worlds::plane_under(Vector3d::Zero(), 0.0);
  for (const double hardness : {1.0, 1.5}) {
    Slide slide(canvas, hardness);
    CutterSettings s;
    s.hardness = hardness;
    const CutForces at = cut_forces(s, 3e-4, 0.0, 0.02);
    Vector3d f;
    EXPECT_NEAR(slide.cut(0.0, 0.0, at.normal, &f), 3e-4, 3e-6);
    EXPECT_NEAR(f.z(), at.normal, 0.01 * at.normal);
    EXPECT_NEAR(f.x(), -at.drag, 0.02 * at.drag);
    EXPECT_NEAR(std::abs(f.y()), at.side, 0.02 * at.side);
  }
}

// The second cut finds the first one's groove, and only where that lies.
TEST(Cutter, DeepensItsGroove) {
  const Canvas canvas = testing_worlds::plane_under(Vector3d::Zero(), 0.0);
  Slide slide(canvas);
  const CutterSettings s;
  const double first = cut_forces(s, 2e-4, 0.0, 0.02).normal,
               second = cut_forces(s, 3e-4, 2e-4, 0.02).normal,
               fresh = cut_forces(s, 3e-4, 0.0, 0.02).normal;
  EXPECT_LT(second, 0.85 * fresh);
  EXPECT_NEAR(slide.cut(0.0, 0.0, first), 2e-4, 2e-6);
  EXPECT_NEAR(slide.cut(0.0, 0.0, second), 3e-4, 1e-5);
  EXPECT_NEAR(slide.cut(0.0, 3e-3, fresh), 3e-4, 3e-6) << "beside it";
}

// However slowly it goes, and what it leaves is the deepest of its cuts.
TEST(CutterContact, DoesNotMeetItsOwnCutBeforeItHasLeft) {
  const CutterSettings s;
  CutterContact cutter(s);
  TipMaterial tip;
  Vector3d side;
  const auto engage = [&](double x, double depth, double speed) {
    cutter.engage({x, 0, 0}, Vector3d::UnitZ(), {speed, 0, 0}, depth, 1e-3, &tip, &side);
    return tip.stiffness * depth;
  };
  const double fresh = cut_forces(s, 3e-4, 0.0, 2e-3).normal;
  for (int i = 0; i < 1000; ++i) ASSERT_NEAR(engage(2e-6 * i, 3e-4, 2e-3), fresh, 1e-9) << i;
  cutter.release();
  EXPECT_EQ(engage(1e-3, 3e-4, 2e-3), 0.0);
  for (const double depth : {1e-4, 4e-4, 2e-4}) engage(0.1, depth, 2e-3);
  cutter.release();
  EXPECT_EQ(engage(0.1, 4e-4, 2e-3), 0.0);
  EXPECT_GT(engage(0.1, 4.1e-4, 2e-3), 0.0);
}

}  // namespace
}  // namespace impedraw
