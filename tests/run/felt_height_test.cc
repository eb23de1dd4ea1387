// A pen over a surface that is higher than the cameras saw it.
#include "impedraw/run/felt_height.h"

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Eigen::Vector3d;

// How far the reference is raised after a touch at `touched`, on a slope, and a time at `then`.
double raised(double touched, double slope, double then) {
  FeltHeight felt(Vector3d::UnitZ());
  SurfaceEstimate surface;
  surface.status = SurfaceStatus::ok;
  surface.n_W = Vector3d(std::sin(slope), 0.0, std::cos(slope));
  surface.distance = touched;
  for (int i = 0; i < 1000; ++i) felt.update(surface, ContactMode::contact, 1e-3);
  surface.distance = then;
  for (int i = 0; i < 1000; ++i) felt.update(surface, ContactMode::free, 1e-3);
  TipReference plan;
  plan.p_WD.setZero();
  const Vector3d place = felt.of(plan).p_WD;
  EXPECT_EQ(place.head<2>().norm(), 0.0) << "the ink would be beside its line";
  return place.z();
}

TEST(FeltHeight, RaisesAPlanThatLiesBeneathTheSurface) {
  EXPECT_NEAR(raised(7e-3, 0.0, 1e-2), 3e-3, 1e-9);
  EXPECT_NEAR(raised(7e-3, 1.0, 1e-2), 7e-3 / std::cos(1.0) - 4e-3, 1e-9);
}

TEST(FeltHeight, LeavesAPlanAloneThatHasRoom) {
  EXPECT_EQ(raised(3.9e-3, 0.0, 1e-2), 0.0);
  EXPECT_EQ(raised(-8e-3, 0.0, 1e-2), 0.0);
}

// A hand that lifts the pen for a moment is no surface.
TEST(FeltHeight, LeavesAPlanAloneWhereAHandLiftedThePen) {
  FeltHeight felt(Vector3d::UnitZ());
  SurfaceEstimate surface;
  surface.status = SurfaceStatus::ok;
  surface.distance = 0.0;
  felt.update(surface, ContactMode::contact, 1e-3);
  surface.distance = 8e-3;
  for (int i = 0; i < 100; ++i) felt.update(surface, ContactMode::contact, 1e-3);
  TipReference plan;
  plan.p_WD.setZero();
  EXPECT_EQ(felt.of(plan).p_WD.norm(), 0.0);
}

// A run's next path begins at rest where the tip is measured.
TEST(FeltHeight, EndsFarAboveTheSurface) { EXPECT_EQ(raised(7e-3, 0.0, 0.05), 0.0); }

}  // namespace
}  // namespace impedraw
