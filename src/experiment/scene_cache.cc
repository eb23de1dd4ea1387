#include "impedraw/experiment/scene_cache.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "impedraw/experiment/input_files.h"
#include "impedraw/settings/yaml_write.h"

namespace impedraw {

namespace {

std::string stamp_of(const std::filesystem::path& file) {
  std::error_code error;
  return fmt::format("{} {} {}\n", file.string(), std::filesystem::file_size(file, error),
                     std::filesystem::last_write_time(file, error).time_since_epoch().count());
}

// The text of all settings that build_scene() reads, and the state of its files.
std::string made_of(const Scenario& s) {
  Scenario read;
  read.canvas = s.canvas;
  read.arm = s.arm;
  read.perception = s.perception;
  read.world = s.world;
  read.blind = s.blind;
  read.tool = s.tool;
  if (s.tool.kind == ToolKind::pad) read.control.normal_force = s.control.normal_force;
  read.drawing.tilt_deg = s.drawing.tilt_deg;
  std::string files = stamp_of(urdf_of(s.arm));
  // A mesh may be put under the drawing's centre, and an arm starts where it leads there.
  const bool found = s.perception.source != PerceptionSource::simulated;
  if (found) read.drawing.placement = s.drawing.placement;
  if (s.canvas.kind == CanvasKind::mesh || !s.arm.urdf.empty())
    read.drawing.placement.centre_m = s.drawing.placement.centre_m;
  if (s.canvas.kind == CanvasKind::mesh) files += stamp_of(s.canvas.mesh.file);
  if (s.perception.source == PerceptionSource::capture)
    files += stamp_of(s.perception.capture / "capture.json");
  if (s.perception.source == PerceptionSource::cloud) files += stamp_of(s.perception.cloud);
  if (!s.canvas.motion.file.empty()) files += stamp_of(s.canvas.motion.file);
  read.control.source = s.control.source;  // of the wrench: the world measures it or not
  // Without noise and errors of the cameras, the snapshot has nothing to draw by lot.
  const DepthNoise& noise = s.perception.noise;
  const bool exact = noise.sigma_at_1m == 0.0 && noise.quantum_at_1m == 0.0 &&
                     s.perception.errors.shift == 0.0 && s.perception.errors.turn_deg == 0.0;
  read.seed = exact || !s.perception.enabled ? 0 : s.seed;
  return settings_yaml(read) + files;
}

}  // namespace

Scene SceneCache::take(Scenario& s, const Pose& X_WP, const SettingErrors& setting_errors) {
  made_of_ = made_of(s);
  const auto found = std::find_if(kept_.begin(), kept_.end(),
                                  [&](const Kept& kept) { return kept.made_of == made_of_; });
  if (found == kept_.end()) {
    Scene scene = build_scene(s, X_WP, setting_errors);
    move_ = s.canvas.move;
    start_ = s.arm.start_p_WE;
    ++built_;
    return scene;
  }
  check_scene(s, found->scene, setting_errors);
  Scene scene = std::move(found->scene);
  move_ = s.canvas.move = found->move;
  start_ = s.arm.start_p_WE = found->start;
  kept_.erase(found);
  const Belief& belief = scene.belief;
  scene.truth.world->set_state(belief.start_q, JointVector::Zero(belief.arm.joints()));
  ++reused_;
  return scene;
}

void SceneCache::give_back(Scene scene) {
  kept_.push_front({made_of_, move_, start_, std::move(scene)});
  if (kept_.size() > most_) kept_.pop_back();
}

}  // namespace impedraw
