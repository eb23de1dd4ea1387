// Keeps the scenes of finished drawings for later ones whose settings make the same scene. Canvas,
// arm, world and snapshot take most of a short run's time. The drawing comes out bit for bit as
// with a new scene (tests/experiment).
#pragma once

#include <list>
#include <string>

#include "impedraw/experiment/scene.h"

namespace impedraw {

class SceneCache {
 public:
  // most: scenes kept, the last ones used.
  explicit SceneCache(std::size_t most = 4) : most_(most) {}

  // As build_scene(). A scene that is taken is not in the cache until it is given back.
  Scene take(Scenario& scenario, const Pose& X_WP, const SettingErrors& setting_errors);
  // The scene of the last take(), after its drawing.
  void give_back(Scene scene);

  long built() const { return built_; }    // scenes made so far
  long reused() const { return reused_; }  // times that one was found

 private:
  struct Kept {
    std::string made_of;
    Eigen::Vector3d move;   // CanvasSettings::move, completed [m]
    Eigen::Vector3d start;  // ArmSettings::start_p_WE, completed [m]
    Scene scene;
  };

  std::size_t most_;
  std::list<Kept> kept_;  // the last used first
  std::string made_of_;   // of the scene that is taken
  Eigen::Vector3d move_ = Eigen::Vector3d::Zero(), start_ = Eigen::Vector3d::Zero();
  long built_ = 0, reused_ = 0;
};

}  // namespace impedraw
