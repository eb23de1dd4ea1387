// Reads a URDF into a Pinocchio model. Only this folder's sources include this header. Reading is a
// separate translation unit because Pinocchio's model and algorithms are each slow to compile.
#pragma once

#include <filesystem>
#include <pinocchio/multibody/model.hpp>
#include <string>
#include <vector>

#include "impedraw/arm/arm_notes.h"

namespace impedraw {

struct LinkCapsule {
  std::string link;
  pinocchio::JointIndex joint;
  Eigen::Vector3d a_J, b_J;  // ends, in the joint's frame
  double radius;
};

struct UrdfModel {
  pinocchio::Model model;  // every joint has one axis
  std::vector<LinkCapsule> capsules;
  ArmNotes notes;
};

// Throws InputError as ArmModel's constructor does.
UrdfModel read_urdf(const std::filesystem::path& urdf, const std::string& tip);
// The same of a plain description (plain_urdf.h) that a file holds.
UrdfModel parse_urdf(const std::string& text, const std::filesystem::path& urdf);

}  // namespace impedraw
