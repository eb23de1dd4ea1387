// Stage 2 of an experiment, Scenario → Scene: the true canvas in the simulated world, and what the
// controller's arm model and the depth cameras' view of the canvas make of both.
#pragma once

#include <list>
#include <string>

#include "impedraw/experiment/belief.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/experiment/truth.h"
#include "impedraw/settings/setting_error.h"

namespace impedraw {

struct Scene {
  Belief belief;
  Truth truth;
};

// A mesh file that lies nowhere near the drawing, and that the scenario does not place, is put
// under the drawing's centre; scenario.canvas.move is set to what that takes, and a note says so.
// Only the mesh's bounding box is used for it.
//
// The arm starts with the pen normal to the drawing plane of X_WP. `placed`: false where the
// drawing's place on the object is yet to be found (capture/found_canvas.h). Throws InputError for
// an invalid canvas or arm, a start out of reach, or too little of the canvas in view.
Scene build_scene(Scenario& scenario, const Pose& X_WP, const SettingErrors& setting_errors,
                  bool placed = true);

// The posture in which the arm starts before the drawing plane of X_WP; sets what start_posture()
// sets, and the world's state.
JointVector start_before(Scenario& scenario, const Pose& X_WP, const Truth& truth, Belief* belief,
                         const SettingErrors& setting_errors);

// Checks settings that do not make the scene but name its joints and links. Throws InputError.
void check_scene(const Scenario& scenario, const Scene& scene, const SettingErrors& setting_errors);

// Keeps the scenes of finished drawings for later ones whose settings make the same scene. Canvas,
// arm, world and snapshot take most of a short run's time. The drawing comes out bit for bit as
// with a new scene (tests/experiment).

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
