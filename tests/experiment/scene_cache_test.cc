// Scenes that are kept between drawings: found where the settings make the same one, and bit for
// bit what a new one is.
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/experiment/prepare.h"

namespace impedraw {
namespace {

Prepared prepared(SceneCache* scenes, const std::vector<std::string>& assignments) {
  DrawOptions options;
  options.assignments = assignments;
  Places places;
  const Scenario scenario = resolve(options, &places);
  return prepare(scenario, places, Unreachable::refuse, {}, scenes);
}

TEST(SceneCache, FindsWhatIsAlikeAndTellsApartWhatIsNot) {
  SceneCache scenes;
  const auto reused = [&](const std::vector<std::string>& assignments) {
    const long before = scenes.reused();
    Prepared e = prepared(&scenes, assignments);
    scenes.give_back(scene_of(std::move(e)));
    return scenes.reused() > before;
  };
  EXPECT_FALSE(reused({}));
  EXPECT_TRUE(reused({"control.normal_force=3"}));
  EXPECT_TRUE(reused({"path.draw_speed=0.02", "name=other"}));
  EXPECT_TRUE(reused({"seed=2"})) << "the cameras have no noise";
  EXPECT_FALSE(reused({"canvas.cap.radius=0.31"}));
  EXPECT_FALSE(reused({"world.tip.friction=0.2"}));
  EXPECT_FALSE(reused({"perception.noise.sigma_at_1m=0.001"}));
  EXPECT_FALSE(reused({"perception.noise.sigma_at_1m=0.001", "seed=2"}));
  EXPECT_FALSE(reused({})) << "the oldest of five was dropped";
}

TEST(SceneCache, GivesTheSamePlan) {
  SceneCache scenes;
  Prepared first = prepared(&scenes, {});
  scenes.give_back(scene_of(std::move(first)));
  const Prepared again = prepared(&scenes, {"path.draw_speed=0.03"}),
                 fresh = prepared(nullptr, {"path.draw_speed=0.03"});
  EXPECT_EQ(scenes.reused(), 1);
  EXPECT_EQ(again.belief.start_q, fresh.belief.start_q);
  EXPECT_EQ(again.belief.perception->cloud().points, fresh.belief.perception->cloud().points);
  ASSERT_EQ(again.plan.path.duration(), fresh.plan.path.duration());
  for (double t = 0.0; t < fresh.plan.path.duration(); t += 0.1)
    EXPECT_EQ(again.plan.path.at(t).reference.p_WD, fresh.plan.path.at(t).reference.p_WD);
}

TEST(SceneCache, KeepsTheSceneOfAPlanThatIsRefused) {
  SceneCache scenes;
  Prepared first = prepared(&scenes, {});
  scenes.give_back(scene_of(std::move(first)));
  EXPECT_THROW(prepared(&scenes, {"drawing.placement.centre=[0.9, 0]"}), InputError);
  EXPECT_THROW(prepared(&scenes, {"control.null_stiffness=[1, 2]"}), InputError);
  Prepared last = prepared(&scenes, {});
  EXPECT_EQ(scenes.built(), 1);
}

}  // namespace
}  // namespace impedraw
