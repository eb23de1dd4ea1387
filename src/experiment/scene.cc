#include "impedraw/experiment/scene.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/input_files.h"
#include "impedraw/experiment/snapshot.h"
#include "impedraw/experiment/start_posture.h"

namespace impedraw {

namespace {

// one-sidedness: 2 mm within the rim of the standard bowl; the controller's 0.66 is 1 mm beyond it
constexpr double kEdgeOfPlanning = 0.5;

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

void check_pushes(const Scenario& s, const World& world, const SettingErrors& setting_errors) {
  for (const PushSettings& push : s.pushes) {
    if (push.link.empty()) continue;
    const std::optional<int> link = world.link(push.link);
    if (link && !world.below_flange(*link)) continue;
    setting_errors.raise(
        {"pushes"},
        fmt::format("pushes: link is {}; valid are the links of the arm above its flange, or none "
                    "for a push on the pen",
                    push.link));
  }
}

}  // namespace

SurfaceHeight Scene::surface(const Pose& X_WP) const {
  if (planning) return perceived_height(*planning, X_WP);
  if (blind.height == BlindHeight::canvas) return canvas_height(*canvas, X_WP);
  return level_surface(blind.top_z);
}

Scene build_scene(const Scenario& s, const Pose& X_WP, const SettingErrors& setting_errors) {
  std::vector<std::string> notes;
  auto canvas = setting_errors.locate(
      {"canvas"}, [&] { return std::make_unique<Canvas>(make_mesh(s.canvas, &notes)); });
  // The arm model comes before the world: its reader names the joint or link that is at fault.
  const std::filesystem::path urdf = urdf_of(s.arm);
  ArmModel arm = setting_errors.locate({"arm.urdf"}, [&] { return ArmModel(urdf); });
  check_joint_settings(s, urdf, arm, setting_errors);
  WorldSettings settings = s.world;
  settings.flange_sensor = has_sensor(s.control.source);
  auto world = setting_errors.locate(
      {"arm.urdf"}, [&] { return std::make_unique<World>(urdf, canvas.get(), settings); });
  check_pushes(s, *world, setting_errors);
  Scene scene{.canvas = std::move(canvas),
              .arm = std::move(arm),
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
