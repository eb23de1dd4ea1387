// What lies outside of a box, against points drawn at random on the triangles.
#include "impedraw/canvas/mesh_facing.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "impedraw/canvas/canvas.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

Vector3d normal_of(const TriangleMesh& mesh, const Eigen::Vector3i& t) {
  const Vector3d& a = mesh.vertices[t[0]];
  return (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a) / 2.0;
}

TEST(OutsideBox, KeepsWhatLiesOutsideAndNothingElse) {
  std::mt19937 random(1);
  SCOPED_TRACE("seed 1");
  std::uniform_real_distribution<double> unit(-1.0, 1.0), share(0.0, 1.0);
  const Eigen::AlignedBox3d box(Vector3d(-0.4, -0.5, -0.3), Vector3d(0.5, 0.3, 0.4));
  for (int i = 0; i < 200; ++i) {
    const auto any = [&] { return Vector3d(unit(random), unit(random), unit(random)); };
    const TriangleMesh whole{{any(), any(), any()}, {{0, 1, 2}}};
    const Vector3d area = normal_of(whole, whole.triangles[0]);
    const TriangleMesh parts = outside_box(whole, box);
    Vector3d sum = Vector3d::Zero();
    for (const Eigen::Vector3i& t : parts.triangles) {
      const Vector3d part = normal_of(parts, t);
      EXPECT_GT(part.dot(area), 0.0) << "a front stays one";
      sum += part;
      const Vector3d middle =
          (parts.vertices[t[0]] + parts.vertices[t[1]] + parts.vertices[t[2]]) / 3.0;
      EXPECT_GT(box.exteriorDistance(middle), 0.0);
      EXPECT_NEAR(area.normalized().dot(middle - whole.vertices[0]), 0.0, 1e-12);
    }
    constexpr int kPoints = 4000;
    int outside = 0;
    for (int k = 0; k < kPoints; ++k) {
      double a = share(random), b = share(random);
      if (a + b > 1.0) a = 1.0 - a, b = 1.0 - b;
      const Vector3d& corner = whole.vertices[0];
      outside += !box.contains(
          Vector3d(corner + a * (whole.vertices[1] - corner) + b * (whole.vertices[2] - corner)));
    }
    EXPECT_NEAR(sum.norm() / area.norm(), static_cast<double>(outside) / kPoints, 0.04) << i;
  }
}

TEST(OutsideBox, OfASheetAcrossTheBoxIsASurfaceStill) {
  const TriangleMesh sheet{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}},
                           {{0, 1, 2}, {0, 2, 3}}};
  const Eigen::AlignedBox3d box(Vector3d(-0.5, -0.5, -0.5), Vector3d(0.5, 0.5, 0.5));
  const Canvas canvas(outside_box(sheet, box));
  EXPECT_NEAR(std::abs(canvas.closest({0.0, 0.0, 0.0}).distance), 0.5, 1e-12);
  EXPECT_NEAR(canvas.closest({0.7, 0.1, 0.2}).distance, 0.2, 1e-12);
  EXPECT_TRUE(outside_box(sheet, Eigen::AlignedBox3d(Vector3d::Constant(-2.0).eval(),
                                                     Vector3d::Constant(2.0).eval()))
                  .triangles.empty());
}

}  // namespace
}  // namespace impedraw
