// A pen at rest before a canvas that rises, stands and goes back.
#include "impedraw/run/keep_away.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Eigen::Vector3d;

// Seen `late`; returns the least true distance on the way, and where the reference is at the end.
std::pair<double, double> rise(double speed, double late) {
  KeepAway away;
  double least = 1.0;
  const auto height = [&](double t) {
    return std::min(0.1, speed * std::max(0.0, t - 0.5)) * (t < 4.0 ? 1.0 : 0.0) - 0.05;
  };
  TipReference rest;
  rest.p_WD.setZero();
  rest.v_WD.setZero();
  rest.a_WD.setZero();
  Vector3d p = Vector3d::Zero(), v = Vector3d::Zero();
  for (int i = 0; i < 9000; ++i) {
    const double t = 1e-3 * i, seen = height(t - late);
    SurfaceEstimate surface;
    surface.n_W = Vector3d::UnitZ();
    surface.distance = p.z() - seen;
    surface.status = std::abs(surface.distance) < 0.06 ? SurfaceStatus::ok : SurfaceStatus::too_few;
    const double rate = (height(t - late) - height(t - late - 1e-3)) / 1e-3;
    away.update(surface,
                std::abs(rate) < 1.0 ? Vector3d(rate * Vector3d::UnitZ()) : Vector3d::Zero(), 1e-3);
    const TipReference now = away.of(rest);
    EXPECT_LT((now.p_WD - p - 1e-3 * now.v_WD).norm(), 1e-4) << "the velocity is the position's";
    EXPECT_LT((now.v_WD - v).norm(), 0.0041) << t;
    if (away.shift().norm() > 0.0) {
      EXPECT_LT((now.v_WD - v - 1e-3 * now.a_WD).norm(), 1e-9) << t;
    }
    p = now.p_WD;
    v = now.v_WD;
    least = std::min(least, p.z() - height(t));
  }
  return {least, p.norm()};
}

TEST(KeepAway, LeavesRoom) {
  EXPECT_GT(rise(0.1, 0.0).first, 0.015);
  EXPECT_GT(rise(0.3, 0.0).first, 0.01);
  EXPECT_GT(rise(0.1, 0.07).first, 0.01);
  EXPECT_GT(rise(0.2, 0.07).first, 0.0);
}

TEST(KeepAway, ComesBack) { EXPECT_LT(rise(0.2, 0.0).second, 1e-3); }

TEST(KeepAway, StaysWhereNothingComesNearer) {
  KeepAway away;
  SurfaceEstimate surface;
  surface.status = SurfaceStatus::ok;
  surface.n_W = Vector3d::UnitZ();
  surface.distance = 0.05;
  for (int i = 0; i < 1000; ++i) away.update(surface, {0.1, 0.0, -0.1}, 1e-3);
  EXPECT_EQ(away.shift().norm(), 0.0);
}

// A damped pen takes the retreat alone: it leads away from what comes, and never back.
TEST(KeepAway, RetreatLeadsAwayOnly) {
  KeepAway away;
  SurfaceEstimate surface;
  surface.status = SurfaceStatus::ok;
  surface.n_W = Vector3d::UnitZ();
  surface.distance = 0.01;
  double most = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const bool comes = i < 500;
    if (!comes) surface.distance = 0.3;
    away.update(surface, Vector3d(0.0, 0.0, comes ? 0.3 : 0.0), 1e-3);
    EXPECT_GE(away.retreat().z(), 0.0) << i;
    most = std::max(most, away.retreat().z());
    if (i == 499) {
      EXPECT_GT(away.retreat().z(), 0.29);
    } else if (i > 1000) {
      EXPECT_EQ(away.retreat().norm(), 0.0) << i;
    }
  }
  EXPECT_LT(away.of({}).v_WD.z(), 0.01) << "the reference of a pen at rest returns";
  EXPECT_LT(most, 0.4);
}

}  // namespace
}  // namespace impedraw
