// What a pen feels of a canvas that is jerked, against the canvas's true way since the last frame.
#include "impedraw/perception/felt_motion.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Eigen::Vector3d;

struct Felt {
  double with = 0.0,
         without = 0.0;  // RMS of the canvas's position across the slip, felt or not [m]
  double along_normal = 0.0, across_slip = 0.0;  // shares
  double unfelt = 0.0;
};

// A canvas whose forecast is that it stands sways along y and z; the pen slips along x at 40 mm/s,
// and follows with a lag of its own. tilt: of the normal that is believed, about x [rad].
Felt feel(double amplitude, double tilt) {
  constexpr double kStep = 1e-3, kLate = 0.06, kRate = 9.0;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto at = [&](double t) {
    return Vector3d(0.0, amplitude * std::sin(kRate * t),
                    0.5 * amplitude * std::cos(1.3 * kRate * t));
  };
  const auto velocity = [&](double t) { return Vector3d((at(t + 1e-5) - at(t - 1e-5)) / 2e-5); };
  CanvasBelief belief;
  belief.centre_K = Vector3d(0.6, 0.0, 0.1);
  FeltMotion felt;
  Felt out;
  int n = 0;
  for (int i = 0; i < 8000; ++i) {
    const double t = i * kStep;
    if (i % 33 == 0 && t > kLate) {
      CanvasBelief::Entry& e = belief.last;
      e.time = t - kLate;
      e.X_WK.p = at(e.time) + 1e-4 * Vector3d(normal(random), normal(random), normal(random));
      for (int k = 0; k < 6; ++k) {
        e.x[k] = k < 3 ? (belief.centre_K + e.X_WK.p)[k] : 0.0;
        e.variance[k] = 1e-8;
        for (auto& filters : e.filters) {
          filters[k] = AxisFilter::started(e.x[k], 1e-8, 1);
        }
      }
      ++belief.frames;
      belief.known = true;
    }
    PenTouch pen;
    pen.touches = true;
    pen.p = Vector3d(0.6, 0.0, 0.1);
    const Vector3d slip = Vector3d(0.04, 0.02 * std::sin(3.0 * t), 0.0);
    pen.v = velocity(t) + slip;
    pen.n = Vector3d(0.0, std::sin(tilt), std::cos(tilt));
    pen.force = 5.0 * Vector3d::UnitZ() - 1.5 * slip.normalized();
    felt.update(belief, pen, t);
    if (t < 3.0) continue;
    const double across = at(t).y() - belief.last.X_WK.p.y();
    out.without += across * across;
    out.with += std::pow(across - felt.shift(t).d.y(), 2);
    ++n;
  }
  out.with = std::sqrt(out.with / n);
  out.without = std::sqrt(out.without / n);
  out.along_normal = felt.share(FeltMotion::along_normal);
  out.across_slip = felt.share(FeltMotion::across_slip);
  out.unfelt = felt.shift(8.0).unfelt;
  return out;
}

TEST(FeltMotion, TellsWhereTheCanvasWentSinceTheLastFrame) {
  const Felt f = feel(5e-3, 0.0);
  EXPECT_GT(f.along_normal, 0.95);
  EXPECT_GT(f.across_slip, 0.95);
  EXPECT_NEAR(f.unfelt, 1.0 / 3.0, 0.04) << "one direction of three: along the slip";
  EXPECT_GT(f.without, 1.5e-3);
  EXPECT_LT(f.with, 0.2 * f.without) << "the frames' noise, and what moves along the slip";
}

TEST(FeltMotion, CountsForLittleWhereFramesShowOtherwise) {
  const Felt f = feel(0.0, 0.1);
  EXPECT_LT(f.across_slip, 0.1) << "a wrong normal turns the slip, and nothing moves";
}

TEST(FeltMotion, IsNothingWithoutTouch) {
  FeltMotion felt;
  CanvasBelief belief;
  belief.known = true;
  PenTouch pen;
  pen.v = Vector3d(1.0, 1.0, 1.0);
  for (int i = 0; i < 100; ++i) felt.update(belief, pen, i * 1e-3);
  EXPECT_EQ(felt.shift(0.1).d.norm(), 0.0);
  EXPECT_EQ(felt.shift(0.1).unfelt, 1.0);
}

}  // namespace
}  // namespace impedraw
