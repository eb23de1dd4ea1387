// The arm as its URDF describes it to the eye: a tree of links with their joints and the shapes of
// their visuals. For pages that draw the arm; dynamics and collisions: arm_model.h.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "impedraw/common/pose.h"

namespace impedraw {

// One <visual> of a link L.
struct VisualShape {
  enum class Kind { cylinder, sphere, box, mesh };
  Kind kind = Kind::sphere;
  Pose X_LS{};  // a cylinder's axis is z of S
  // [m]; cylinder: radius, length; sphere: radius; box: edges; mesh: scale [1]
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  std::string mesh{};  // the file that the URDF names; of Kind::mesh alone
};

// A link and the joint that carries it. With q of the joint,
//   X_PL(q) = X_PL · rotation about axis_L by q        (revolute)
//   X_PL(q) = X_PL · translation along axis_L by q     (prismatic)
struct DrawnLink {
  enum class Joint { fixed, revolute, prismatic };
  std::string name;
  int parent = -1;  // index of P in the list; −1: the root, which stands at the origin of W
  Joint joint = Joint::fixed;
  std::string joint_name{};
  Pose X_PL{};
  Eigen::Vector3d axis_L = Eigen::Vector3d::UnitZ();  // unit
  std::vector<VisualShape> shapes{};
};

// Parents stand before their children. Throws InputError if the file is missing, malformed or has
// joints of another kind.
std::vector<DrawnLink> read_arm_shapes(const std::filesystem::path& urdf);

}  // namespace impedraw
