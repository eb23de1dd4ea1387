#include "impedraw/experiment/scene.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/snapshot.h"

namespace impedraw {

namespace {

// one-sidedness: 2 mm within the rim of the standard bowl; the controller's 0.66 is 1 mm beyond it
constexpr double kEdgeOfPlanning = 0.5;

std::filesystem::path urdf_of(const ArmSettings& s) {
  return s.urdf.empty() ? std::filesystem::path(IMPEDRAW_ROOT) / "models/iiwa14_pen.urdf" : s.urdf;
}

// Where a mesh from a file stands that nobody has placed: under the drawing's centre, its lowest
// point just above the table, or lower if it is tall.
void put_in_reach(TriangleMesh* mesh, Scenario* s, std::vector<std::string>* notes) {
  constexpr double kFoot = 0.02, kTop = 0.35;  // [m]
  if (s->canvas.kind != CanvasKind::mesh || !s->canvas.move.isZero() ||
      !s->drawing.tilt_deg.isZero())
    return;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh->vertices) box.extend(p);
  const Eigen::Vector2d centre = s->drawing.placement.centre_m;
  const PerceptionSettings& seen = s->perception;
  const bool under = box.min().x() <= centre.x() && centre.x() <= box.max().x() &&
                     box.min().y() <= centre.y() && centre.y() <= box.max().y();
  const bool at_height =
      box.max().z() >= seen.region_lower.z() && box.max().z() <= seen.region_upper.z();
  if (under && at_height) return;
  const Eigen::Vector3d move(centre.x() - box.center().x(), centre.y() - box.center().y(),
                             std::min(kFoot, kTop - box.sizes().z()) - box.min().z());
  for (Eigen::Vector3d& p : mesh->vertices) p += move;
  s->canvas.move = move;
  notes->push_back(fmt::format(
      "the mesh lies out of reach; it was moved by ({:.3f}, {:.3f}, {:.3f}) m to under the "
      "drawing's centre (canvas.move places it elsewhere)",
      move.x(), move.y(), move.z()));
}

JointVector start_posture(const ArmSettings& s, ArmModel& arm, const Pose& X_WP,
                          const SettingErrors& setting_errors) {
  if (s.posture_seed.size() != arm.joints())
    setting_errors.raise({"arm.posture_seed", "arm.urdf"},
                         fmt::format("arm.posture_seed has {} entries, the arm {} joints",
                                     s.posture_seed.size(), arm.joints()));
  const IkResult start =
      find_posture(arm, {s.start_p_WE, -X_WP.R.col(2)}, JointVector(s.posture_seed));
  if (!start.reached)
    setting_errors.raise(
        {"arm.start", "arm"},
        fmt::format("arm.start ({:.3f}, {:.3f}, {:.3f}) m is out of the arm's reach by {:.0f} mm",
                    s.start_p_WE.x(), s.start_p_WE.y(), s.start_p_WE.z(),
                    1e3 * start.position_error));
  return start.q;
}

void look_at_canvas(const Scenario& s, const SettingErrors& setting_errors, Scene* scene) {
  const std::vector<std::string> how_seen = {"perception.region_lower",
                                             "perception.region_upper",
                                             "perception.cameras",
                                             "perception.voxel",
                                             "perception.noise",
                                             "perception",
                                             "canvas"};
  setting_errors.locate(how_seen, [&] {
    scene->perception.emplace(
        take_snapshot(s, *scene->canvas, *scene->world, scene->arm, scene->start_q));
  });
  NormalSettings cautious = s.perception.normals;
  cautious.max_one_sidedness = std::min(cautious.max_one_sidedness, kEdgeOfPlanning);
  scene->planning.emplace(PointCloud(scene->perception->cloud()), cautious);
}

}  // namespace

SurfaceHeight Scene::surface(const Pose& X_WP) const {
  if (planning) return perceived_height(*planning, X_WP);
  if (blind.height == BlindHeight::canvas) return canvas_height(*canvas, X_WP);
  return [z = blind.plane_z](double x, double y) {
    return SurfaceSample{{x, y, z}, Eigen::Vector3d::UnitZ()};
  };
}

Scene build_scene(Scenario& s, const Pose& X_WP, const SettingErrors& setting_errors) {
  std::vector<std::string> notes;
  auto canvas = setting_errors.locate({"canvas"}, [&] {
    TriangleMesh mesh = make_mesh(s.canvas, &notes);
    put_in_reach(&mesh, &s, &notes);
    return std::make_unique<Canvas>(std::move(mesh));
  });
  // Build the world before the arm model: its URDF reader reports errors, the arm model's reader
  // prints its own lines.
  WorldSettings settings = s.world;
  settings.flange_sensor = has_sensor(s.control.source);
  auto world = setting_errors.locate({"arm.urdf"}, [&] {
    return std::make_unique<World>(urdf_of(s.arm), canvas.get(), settings);
  });
  Scene scene{.canvas = std::move(canvas),
              .arm = setting_errors.locate({"arm.urdf"}, [&] { return ArmModel(urdf_of(s.arm)); }),
              .start_q = {},
              .world = std::move(world),
              .perception = {},
              .planning = {},
              .blind = s.blind,
              .notes = std::move(notes)};
  scene.start_q = start_posture(s.arm, scene.arm, X_WP, setting_errors);
  scene.world->set_state(scene.start_q, JointVector::Zero(scene.arm.joints()));
  if (s.perception.enabled) look_at_canvas(s, setting_errors, &scene);
  return scene;
}

}  // namespace impedraw
