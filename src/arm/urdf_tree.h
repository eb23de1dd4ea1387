// A URDF's elements, to be changed in place. Only this folder's sources include this header.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <tinyxml2.h>
#include <urdf_model/types.h>
#include <Eigen/Geometry>

namespace impedraw {

using UrdfElement = tinyxml2::XMLElement;
using UrdfElements = std::vector<UrdfElement*>;

struct UrdfTree {
  explicit UrdfTree(const std::filesystem::path& file);  // throws as require_urdf_file()
  UrdfElement* link(const std::string& name) const;      // or null
  UrdfElements way_to(const std::string& link) const;    // the joints from the root to it
  std::string text() const;

  tinyxml2::XMLDocument document;
  UrdfElements links, joints;
};

UrdfElements all(UrdfElement* in, const char* name);             // its children of this name
std::string value(const UrdfElement* e, const char* attribute);  // empty: there is none
double number(const UrdfElement* e, const char* attribute);      // 0: there is none
std::string parent_of(const UrdfElement* joint);                 // names of links
std::string child_of(const UrdfElement* joint);
bool is_type(const UrdfElement* joint, const char* type);
Eigen::Vector3d axis_of(const UrdfElement* joint);  // unit
Eigen::Vector3d vector(const UrdfElement* e, const char* attribute, double otherwise);
Eigen::Isometry3d placement_of(const UrdfElement* e);  // its <origin>
void set_placement(UrdfElement* e, const Eigen::Isometry3d& X);
// A link that a joint fixes to another.
void fix_link(UrdfTree* tree, const std::string& to, const Eigen::Isometry3d& X,
              const std::string& name);

// The model that urdfdom reads in a text. Throws InputError with its first complaint.
urdf::ModelInterfaceSharedPtr parsed_urdf(const std::string& text,
                                          const std::filesystem::path& file);

// A place for a pen: the links fixed to the arm's last joint, each with its pose in the link R
// that this joint moves. The last joint is the sixth or a later one, beyond which nothing moves but
// a gripper: several joints side by side, mimic or prismatic ones, or one that is named
// finger, jaw or gripper. A finger or a jaw is no joint of an arm.
struct ArmEnd {
  UrdfElements links;
  std::vector<Eigen::Isometry3d, Eigen::aligned_allocator<Eigen::Isometry3d>> X_RL;
  bool chain = true;                                // each link on the one before it
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  // of the last joint, in R
};
std::vector<ArmEnd> arm_ends(const UrdfTree& tree);
// The link of each end with the first of these in its name: tool0, tcp, flange, eef, ee_link,
// end_effector, tool, hand, gripper; else the furthest of the links without a body or a mass that
// stand on the last joint's axis; the only link; or all of them.
std::vector<std::string> flange_candidates(const std::vector<ArmEnd>& ends);

}  // namespace impedraw
