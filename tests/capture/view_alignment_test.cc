// Views with known errors of their cameras' poses, rendered of surfaces that hold all directions,
// and of those that leave some open. Judged by where each view puts points of the true surface.
#include "impedraw/capture/view_alignment.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "impedraw/canvas/built_in.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/capture/capture_cloud.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/seeded_normals.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

Vector3d direction(SeededNormals& random) {
  const double x = random.next(), y = random.next(), z = random.next();
  return Vector3d(x, y, z).normalized();
}

// A camera off by `shift` [m] and `turn_deg` about itself.
Pose off(const Pose& X_WC, double shift, double turn_deg, SeededNormals& random) {
  Pose wrong = X_WC;
  wrong.p += shift * direction(random);
  wrong.R = Eigen::AngleAxisd(turn_deg * std::numbers::pi / 180.0, direction(random)) * wrong.R;
  return wrong;
}

// With a lens that is no DepthCamera's: its own focal lengths, off the middle.
CapturedView rendered(const Canvas& canvas, const Pose& X_WC, double sigma_at_1m,
                      SeededNormals& random, double wider = 1.0) {
  CapturedView view;
  view.lens = {.width = 424, .height = 320, .fx = 381.0, .fy = 379.0, .cx = 215.3, .cy = 157.8};
  view.lens.fx /= wider, view.lens.fy /= wider;
  view.X_WC = X_WC;
  view.quantum = 1e-4;
  view.depth = {view.lens.width, view.lens.height, {}};
  for (int j = 0; j < view.lens.height; ++j)
    for (int i = 0; i < view.lens.width; ++i) {
      const auto hit = canvas.ray(X_WC.p, X_WC.R * *view.lens.direction_C(i, j));
      const double z = hit ? hit->t + sigma_at_1m * hit->t * hit->t * random.next() : NAN;
      view.depth.depth.push_back(1e-4 * std::round(1e4 * z));
    }
  return view;
}

// Three views from 0.9 m that believe in other poses than the true ones.
struct Wrong {
  Capture capture;
  std::vector<Pose> truth;
  CloudSettings settings;
  Eigen::AlignedBox3d box;

  Wrong(const Canvas& canvas, double shift, double turn_deg, double noise, unsigned seed,
        int views = 3, int wrong_ones = 3)
      : box(canvas.bounds()) {
    SeededNormals random(seed);
    settings.region = {Vector3d(0.2, -0.5, -0.05), Vector3d(1.0, 0.5, 0.6)};
    for (int v = 0; v < views; ++v) {
      const double azimuth = 2.0 * std::numbers::pi * v / views;
      truth.push_back(
          look_at({0.6 + 0.5 * std::cos(azimuth), 0.5 * std::sin(azimuth), 0.9}, {0.6, 0.0, 0.1}));
      CapturedView view = rendered(canvas, truth.back(), noise, random);
      view.name = "view_" + std::to_string(v);
      if (v >= views - wrong_ones) view.X_WC = off(view.X_WC, shift, turn_deg, random);
      capture.views.push_back(std::move(view));
    }
  }

  // Root-mean-square distance between where two views put the same points, over points of the box.
  double apart(const std::vector<AlignedView>& views) const {
    double sum = 0.0;
    int n = 0;
    for (int k = 0; k < 8; ++k) {
      const Vector3d p = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k));
      for (std::size_t a = 0; a < views.size(); ++a)
        for (std::size_t b = a + 1; b < views.size(); ++b, ++n)
          sum += (placed(views, a, p) - placed(views, b, p)).squaredNorm();
    }
    return std::sqrt(sum / n);
  }
  Vector3d placed(const std::vector<AlignedView>& views, std::size_t v, const Vector3d& p) const {
    return views[v].T * (capture.views[v].X_WC * (truth[v].inverse() * p));
  }
  ViewAlignment align() const { return cloud_of(capture, settings, {}).alignment; }
};

Canvas terrain() { return Canvas(make_terrain({})); }

TEST(ViewAlignment, ViewsAreFoundAgainToTenthsOfAMillimetre) {
  const Canvas canvas = terrain();
  for (unsigned seed = 1; seed <= 3; ++seed)
    for (const double noise : {0.0, 1.5e-3}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", noise " << noise);
      const Wrong wrong(canvas, 3e-3, 0.8, noise, seed);
      const std::vector<AlignedView> still(3);
      const ViewAlignment found = wrong.align();
      EXPECT_GT(wrong.apart(still), 5e-3);
      EXPECT_LT(wrong.apart(found.views), 0.4e-3);
      for (const AlignedView& view : found.views) EXPECT_TRUE(view.open.empty());
    }
}

// A mug on a table turns about its axis all the same but for its handle, and depths come in steps
// of a millimetre: exact views must not be moved for what the steps seem to tell.
TEST(ViewAlignment, ExactViewsOfAMugStay) {
  TriangleMesh mesh;
  const auto sheet = [&mesh](int n, int m, const auto& at) {
    const int first = static_cast<int>(mesh.vertices.size());
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= m; ++j)
        mesh.vertices.push_back(at(static_cast<double>(i) / n, static_cast<double>(j) / m));
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < m; ++j) {
        const int a = first + i * (m + 1) + j, b = a + m + 1;
        mesh.triangles.insert(mesh.triangles.end(),
                              {Eigen::Vector3i(a, b, b + 1), Eigen::Vector3i(a, b + 1, a + 1)});
      }
  };
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const auto wall = [](double r, double turn, double z) {
    return Vector3d(0.6 + r * std::cos(kTurn * turn), r * std::sin(kTurn * turn), z);
  };
  sheet(96, 20, [&](double u, double v) { return wall(0.05, u, 0.12 * v); });
  sheet(96, 20, [&](double u, double v) { return wall(0.046, -u, 0.12 * v); });
  sheet(96, 4, [&](double u, double v) { return wall(0.05 - 0.004 * v, u, 0.12); });
  sheet(32, 16, [&](double u, double v) {
    const double along = 0.5 * kTurn * u, about = kTurn * v, r = 0.035 + 0.007 * std::cos(about);
    return Vector3d(0.6 + 0.007 * std::sin(about), 0.046 + r * std::sin(along),
                    0.06 + r * std::cos(along));
  });
  sheet(4, 4, [](double u, double v) { return Vector3d(0.3 + 0.6 * u, -0.4 + 0.8 * v, 0.0); });
  const Canvas canvas(std::move(mesh));
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Wrong exact(canvas, 0.0, 0.0, 0.0, seed);
    for (CapturedView& view : exact.capture.views) {
      view.quantum = 1e-3;
      for (double& z : view.depth.depth) z = 1e-3 * std::round(1e3 * z);
    }
    const ViewAlignment found = exact.align();
    for (const AlignedView& view : found.views) {
      EXPECT_LT(view.shift, 0.4e-3);
      EXPECT_LT((view.T * Vector3d(0.6, 0, 0.06) - Vector3d(0.6, 0, 0.06)).norm(), 0.4e-3);
    }
  }
}

// A long, thin body on a table: one view is held along it, and others are not. A turn of all of
// them must not pay for what the one slid.
TEST(ViewAlignment, ATableStaysLevelThoughOneViewSlidAlone) {
  TriangleMesh mesh;
  const auto quad = [&](const Vector3d& p, const Vector3d& a, const Vector3d& b) {
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {p, p + a, p + a + b, p + b});
    mesh.triangles.insert(mesh.triangles.end(), {Eigen::Vector3i(first, first + 1, first + 2),
                                                 Eigen::Vector3i(first, first + 2, first + 3)});
  };
  const Vector3d x = 0.45 * Vector3d::UnitX(), y = 0.08 * Vector3d::UnitY(),
                 z = 0.2 * Vector3d::UnitZ(), p(0.375, -0.04, 0.0);
  quad({0.1, -0.5, 0.0}, Vector3d::UnitX(), Vector3d::UnitY());
  quad(p + z, x, y), quad(p, x, z), quad(p + y, z, x), quad(p, z, y), quad(p + x, y, z);
  const Canvas canvas(mesh);
  const Wrong wrong(canvas, 1e-3, 0.3, 1.5e-3, 4);
  const ViewAlignment found = wrong.align();
  for (std::size_t v = 0; v < 3; ++v) {
    EXPECT_LT(found.views[v].shift, 2.5e-3);
    const Eigen::Matrix3d off =
        found.views[v].T.R * wrong.capture.views[v].X_WC.R * wrong.truth[v].R.transpose();
    EXPECT_LT(std::acos(off(2, 2)) * 180.0 / std::numbers::pi, 0.35);
  }
}

// What most views agree about stays where it is.
TEST(ViewAlignment, OneWrongViewGoesToTheOthers) {
  const Canvas canvas = terrain();
  const Wrong wrong(canvas, 9e-3, 1.8, 0.0, 4, 3, 1);
  const ViewAlignment found = wrong.align();
  EXPECT_LT(wrong.apart(found.views), 0.4e-3);
  const Vector3d c(0.6, 0.0, 0.1);
  EXPECT_LT((found.views[0].T * c - c).norm(), 0.3e-3);
  EXPECT_NEAR(found.views[2].shift, 9e-3, 1e-3);
  EXPECT_NEAR(found.views[2].turn_deg, 1.8, 0.1);
}

TEST(ViewAlignment, AViewThatIsTooFarOffIsRefusedByName) {
  const Canvas canvas = terrain();
  for (const auto& [shift, turn] : {std::pair{16e-3, 0.5}, std::pair{3e-3, 3.5}}) {
    const Wrong wrong(canvas, shift, turn, 0.0, 5, 3, 1);
    try {
      wrong.align();
      FAIL() << shift << " m, " << turn << "°";
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), HasSubstr("view_2: its camera is "));
    }
  }
}

// The shape holds a plane along its normal, a cylinder across its axis, a ball at its centre.
TEST(ViewAlignment, WhatTheShapeLeavesOpenStaysAsCalibrated) {
  struct Case {
    const char* name;
    TriangleMesh mesh;
    std::size_t open;
    Vector3d slide;  // stays
  };
  CylinderSettings pipe;
  CapSettings ball;
  for (const Case& c : {Case{"plane", make_plane({}), 3, Vector3d::UnitX()},
                        Case{"cylinder", make_cylinder(pipe), 2,
                             Vector3d(std::cos(pipe.heading_deg * std::numbers::pi / 180.0),
                                      std::sin(pipe.heading_deg * std::numbers::pi / 180.0), 0.0)},
                        Case{"bowl", make_bowl(ball), 3, Vector3d::Zero()}}) {
    SCOPED_TRACE(c.name);
    const Canvas canvas(c.mesh);
    const Wrong wrong(canvas, 2e-3, 0.3, 0.0, 6);
    const ViewAlignment found = wrong.align();
    EXPECT_LT(found.rms, 0.3 * found.rms_before);
    for (const AlignedView& view : found.views) {
      EXPECT_EQ(view.open.size(), c.open);
      const Vector3d p = canvas.bounds().center();
      EXPECT_LT(std::abs(c.slide.dot(view.T * p - p)), 0.2e-3);
    }
  }
}

TEST(ViewAlignment, ViewsThatDoNotOverlapAreSaid) {
  const Canvas canvas = terrain();
  Wrong wrong(canvas, 3e-3, 0.5, 0.0, 7, 3);
  for (int j = 0; j < 320; ++j)  // the last one sees a corner that the others do not
    for (int i = 0; i < 424; ++i) {
      for (std::size_t v = 0; v < 3; ++v) {
        CapturedView& view = wrong.capture.views[v];
        double& z = view.depth.depth[static_cast<std::size_t>(j) * 424 + i];
        const Vector3d p = wrong.truth[v] * Vector3d(z * *view.lens.direction_C(i, j));
        if (v == 2 ? p.x() < 0.66 : p.x() > 0.64) z = NAN;
      }
    }
  const CaptureCloud seen = cloud_of(wrong.capture, wrong.settings, {});
  EXPECT_EQ(seen.alignment.views[2].matches, 0);
  EXPECT_TRUE(seen.alignment.views[2].T.R.isIdentity());
  EXPECT_GT(seen.alignment.views[0].matches, 0);
  EXPECT_THAT(seen.notes, ::testing::Contains(HasSubstr("view_2: overlaps with no other view")));
}

TEST(ViewAlignment, ACameraInsideOfTheObjectIsRefused) {
  CapSettings half;
  half.centre = Vector3d(0.6, 0.0, 0.2);
  half.radius = half.opening_radius = 0.15;
  TriangleMesh ball = make_dome(half);
  half.opening_radius = 0.149;
  TriangleMesh lower = make_bowl(half);
  for (Eigen::Vector3i& t : lower.triangles) std::swap(t[1], t[2]);
  const int shift = static_cast<int>(ball.vertices.size());
  ball.vertices.insert(ball.vertices.end(), lower.vertices.begin(), lower.vertices.end());
  for (const Eigen::Vector3i& t : lower.triangles) ball.triangles.push_back(t.array() + shift);
  const Canvas canvas(ball);
  Capture capture;
  SeededNormals random(1);
  const std::vector<Pose> inside = {
      look_at({0.6, 0.0, 0.2}, {1.0, 0.0, 0.2}), look_at({0.6, 0.0, 0.2}, {0.2, 0.0, 0.2}),
      look_at({0.6, 0.0, 0.2}, {0.6, 1.0, 0.2}), look_at({0.6, 0.0, 0.2}, {0.6, -1.0, 0.2}),
      look_at({0.6, 0.0, 0.2}, {0.6, 0.0, 1.0}), look_at({0.6, 0.0, 0.2}, {0.6, 0.0, -1.0})};
  for (const Pose& X_WC : inside) capture.views.push_back(rendered(canvas, X_WC, 0.0, random, 2.0));
  try {
    cloud_of(capture, {}, {}, false);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("its camera lies inside"));
  }
}

}  // namespace
}  // namespace impedraw
