// The model of an arm against the one that Pinocchio's own reader builds, to the bit.
#include <fstream>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <urdf_parser/urdf_parser.h>

#include <pinocchio/parsers/urdf.hpp>

#include "impedraw/arm/kinematic_tree.h"
#include "seeds.h"

namespace impedraw {
namespace {

void expect_as_by_pinocchio(const std::string& text) {
  const urdf::ModelInterfaceSharedPtr description = urdf::parseURDF(text);
  ASSERT_TRUE(description);
  pinocchio::Model theirs;
  pinocchio::urdf::buildModel(description, theirs);
  const pinocchio::Model ours = kinematic_tree(*description);

  EXPECT_EQ(ours.names, theirs.names);
  ASSERT_EQ(ours.njoints, theirs.njoints);
  for (int j = 0; j < ours.njoints; ++j) {
    EXPECT_EQ(ours.joints[j], theirs.joints[j]);
    EXPECT_EQ(ours.jointPlacements[j], theirs.jointPlacements[j]) << ours.names[j];
    EXPECT_EQ(ours.inertias[j], theirs.inertias[j]) << ours.names[j];
  }
  EXPECT_TRUE(ours == theirs);  // limits, damping, frames and all else
}

TEST(KinematicTree, IsPinocchiosForTheModelsHere) {
  for (const char* file :
       {"iiwa14_pen.urdf", "arms/fr3.urdf", "arms/gen3.urdf", "arms/ur5e.urdf"}) {
    SCOPED_TRACE(file);
    std::ifstream in(std::filesystem::path("models") / file);
    expect_as_by_pinocchio({std::istreambuf_iterator<char>(in), {}});
  }
}

// Links of any origin, mass and axis, on any link before them.
TEST(KinematicTree, IsPinocchiosForRandomTrees) {
  std::mt19937 random;
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto three = [&] {
    return fmt::format("{} {} {}", uniform(random), uniform(random), uniform(random));
  };
  const char* const axes[] = {"1 0 0", "0 1 0", "0 0 1", "0 0 -1", "0 -2 0"};
  const char* const types[] = {"fixed", "revolute", "prismatic"};
  for (unsigned seed = 0; seed < seeds(30, 300); ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    random.seed(seed);
    std::string text = "<robot name='r'><link name='l0'/>";
    for (int i = 1; i <= 12; ++i) {
      const int on = std::uniform_int_distribution(0, i - 1)(random), kind = random() % 3;
      const int a = random() % 6;
      text += fmt::format(
          "<joint name='j{0}' type='{1}'><parent link='l{2}'/><child link='l{0}'/><origin "
          "xyz='{3}' rpy='{4}'/><axis xyz='{5}'/><limit lower='-{6}' upper='{6}' effort='{7}' "
          "velocity='2'/>{8}</joint><link name='l{0}'>",
          i, types[kind], on, three(), three(), a < 5 ? axes[a] : three(), 1.5 + uniform(random),
          50.0 + uniform(random), random() % 2 ? "<dynamics damping='0.3' friction='0.1'/>" : "");
      if (random() % 4 != 0)
        text += fmt::format(
            "<inertial><origin xyz='{}' rpy='{}'/><mass value='{}'/><inertia ixx='0.03' "
            "iyy='0.04' izz='0.05' ixy='{}' ixz='0.002' iyz='-0.001'/></inertial>",
            three(), three(), 2.0 + uniform(random), 0.005 * uniform(random));
      text += "</link>";
    }
    expect_as_by_pinocchio(text + "</robot>");
  }
}

}  // namespace
}  // namespace impedraw
