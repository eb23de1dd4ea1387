#include <numbers>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "canvas/mesh_checks.h"
#include "canvas/mesh_files.h"
#include "impedraw/app/commands.h"
#include "impedraw/common/errors.h"
#include "impedraw/experiment/canvas_settings.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

class MeshCanvas : public MeshFiles {};

TEST_F(MeshCanvas, StandsInItsPoseAndUnitWithTheSideAskedFor) {
  TriangleMesh one;  // its normal along +z, its first corner at the origin, its second along x
  one.vertices = {{0, 0, 0}, {300, 0, 0}, {0, 200, 0}};
  one.triangles = {{0, 1, 2}};
  CanvasSettings s;
  s.kind = CanvasKind::mesh;
  s.mesh.file = write("one.stl", binary_stl(one));
  s.mesh.unit = LengthUnit::mm;
  s.mesh.position = {0.5, 0.1, 0.2};
  // Roll by 90° takes z to −y and y to z; then yaw by 90° takes x to y and −y to x.
  s.mesh.rotation_deg = {90, 0, 90};
  TriangleMesh m = make_mesh(s);
  EXPECT_LT((m.vertices[0] - Vector3d(0.5, 0.1, 0.2)).norm(), 1e-9);
  EXPECT_LT((m.vertices[1] - Vector3d(0.5, 0.4, 0.2)).norm(), 1e-7);
  EXPECT_LT((m.vertices[2] - Vector3d(0.5, 0.1, 0.4)).norm(), 1e-7);
  EXPECT_LT((cross(m, m.triangles[0]).normalized() - Vector3d::UnitX()).norm(), 1e-9);
  s.mesh.side = MeshSettings::Side::inward;
  m = make_mesh(s);
  EXPECT_LT((cross(m, m.triangles[0]).normalized() + Vector3d::UnitX()).norm(), 1e-9);
  // Pitch by 90° takes x to −z and z to x.
  s.mesh = {s.mesh.file, LengthUnit::cm, {0, 0, 0}, {0, 90, 0}, MeshSettings::Side::outward};
  m = make_mesh(s);
  EXPECT_LT((m.vertices[1] - Vector3d(0, 0, -3)).norm(), 1e-6);
}

TEST_F(MeshCanvas, SaysWhatItMendedAndWhatToSetWhereItCannot) {
  CanvasSettings s;
  s.kind = CanvasKind::mesh;
  TriangleMesh m = box(100, 200, 300);
  std::swap(m.triangles[3][0], m.triangles[3][1]);
  s.mesh.file = write("box.obj", obj(m));
  try {
    make_mesh(s);
    FAIL() << "nothing was refused";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("100 × 200 × 300 m"));
    EXPECT_THAT(error.what(), HasSubstr("canvas.mesh.unit"));
  }
  s.mesh.unit = LengthUnit::mm;
  std::vector<std::string> repaired;
  make_mesh(s, &repaired);
  ASSERT_EQ(repaired.size(), 1u);
  EXPECT_THAT(repaired[0], HasSubstr("wrong winding: 1, first triangle 3"));
  s.mesh.file.clear();
  EXPECT_THROW(make_mesh(s), InputError);
}

TEST_F(MeshCanvas, IsTurnedUprightAndRecentredOnRequestAndSaysSoOtherwise) {
  TriangleMesh wall;  // 0.3 m wide, 0.2 m high, far away, facing y
  wall.vertices = {{5000, 7, 9000}, {5000.3, 7, 9000}, {5000.3, 7, 8999.8}, {5000, 7, 8999.8}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  std::string text;
  for (const Vector3d& p : wall.vertices)
    text += fmt::format("v {:.4f} {:.4f} {:.4f}\n", p.x(), p.y(), p.z());
  CanvasSettings s;
  s.kind = CanvasKind::mesh;
  s.mesh.file = write("wall.obj", text + "f 1 2 3 4\n");
  std::vector<std::string> said;
  make_mesh(s, &said);
  EXPECT_THAT(said, ::testing::ElementsAre(HasSubstr("canvas.mesh.up=y"),
                                           HasSubstr("canvas.mesh.recentre=true")));
  EXPECT_EQ(describe_mesh(s.mesh.file, {})["warnings"].size(), 2u);
  s.mesh.up = MeshSettings::Up::y;
  s.mesh.recentre = true;
  s.mesh.position = {0.6, 0, 0.1};
  said.clear();
  const TriangleMesh m = make_mesh(s, &said);
  EXPECT_TRUE(said.empty());
  EXPECT_LT((m.vertices[0] - Vector3d(0.45, -0.1, 0.1)).norm(), 1e-9);
  EXPECT_LT((m.vertices[2] - Vector3d(0.75, 0.1, 0.1)).norm(), 1e-9);
  for (const auto& t : m.triangles) EXPECT_GT(cross(m, t).z(), 0.0);
}

TEST_F(MeshCanvas, InspectDescribesABoxAndARoof) {
  auto found = describe_mesh(write("box.ply", ply(box(100, 200, 300), "ascii")), 1e-3);
  EXPECT_EQ(found["triangles"], 12);
  const auto bounds = found["bbox_m"].get<std::vector<double>>();
  ASSERT_EQ(bounds.size(), 6u);
  EXPECT_THAT(bounds,
              ::testing::Pointwise(::testing::DoubleNear(1e-9), {0.0, 0.0, 0.0, 0.1, 0.2, 0.3}));
  EXPECT_NEAR(found["area_m2"].get<double>(), 0.22, 1e-9);
  EXPECT_EQ(found["closed"], true);
  EXPECT_EQ(found["components"], 1);
  EXPECT_NEAR(found["slope_max_deg"].get<double>(), 180.0, 1e-9);
  EXPECT_TRUE(found["faults"].empty());

  TriangleMesh roof;  // two sides, of 30° and 50°, and a triangle that is given twice
  const double h = 0.1, a = h / std::tan(std::numbers::pi / 6),
               b = h / std::tan(50 * std::numbers::pi / 180);
  roof.vertices = {{0, 0, h}, {0, 1, h}, {-a, 0, 0}, {b, 0, 0}};
  roof.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 3, 1}};
  found = describe_mesh(write("roof.obj", obj(roof)), 1.0);
  EXPECT_NEAR(found["slope_max_deg"].get<double>(), 50.0, 1e-4);
  EXPECT_EQ(found["closed"], false);
  EXPECT_EQ(found["triangles"], 3);
  ASSERT_EQ(found["faults"].size(), 1u);
  EXPECT_EQ(found["faults"][0]["kind"], "duplicate_triangle");
  EXPECT_EQ(found["faults"][0]["count"], 1);
  EXPECT_EQ(found["faults"][0]["first"], 2);
}

}  // namespace
}  // namespace impedraw
