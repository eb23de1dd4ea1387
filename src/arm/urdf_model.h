// Reads a URDF into Pinocchio's model. Only sources of this folder include this header. Reading has
// a unit of its own because Pinocchio's parser and its algorithms are each slow to compile.
#pragma once

#include <filesystem>
#include <pinocchio/multibody/model.hpp>
#include <string>
#include <vector>

namespace impedraw {

struct LinkCapsule {
  std::string link;
  pinocchio::JointIndex joint;
  Eigen::Vector3d a_J, b_J;  // in the joint's frame
  double radius;
};

struct UrdfModel {
  pinocchio::Model model;  // every joint has one axis
  std::vector<LinkCapsule> capsules;
};

// Throws InputError as ArmModel's constructor does.
UrdfModel read_urdf(const std::filesystem::path& urdf);

}  // namespace impedraw
