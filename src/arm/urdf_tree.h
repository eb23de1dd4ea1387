// A URDF's elements, to be changed in place, the numbers in them, and what urdfdom makes of it. Only this folder's sources
// include this header.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <tinyxml2.h>
#include <urdf_model/types.h>
#include <Eigen/Geometry>

namespace impedraw {

using UrdfElement = tinyxml2::XMLElement;

struct UrdfTree {
  // Reads a file that require_urdf_file() accepts. Throws InputError.
  explicit UrdfTree(const std::filesystem::path& file);

  tinyxml2::XMLDocument document;
  UrdfElement* robot = nullptr;
  std::vector<UrdfElement*> links, joints;   // in the file's order
  std::map<std::string, UrdfElement*> link;  // by name
  std::map<std::string, UrdfElement*> to;    // the joint that carries a link, by the link's name

  // The joints from the root to a link.
  std::vector<UrdfElement*> way_to(const std::string& link_name) const;
  std::string text() const;
};

// What urdfdom reads in the text of a file. Throws InputError with its first complaint.
urdf::ModelInterfaceSharedPtr parsed_urdf(const std::string& text,
                                          const std::filesystem::path& file);

std::string name_of(const UrdfElement* e);
std::string type_of(const UrdfElement* joint);
std::string parent_of(const UrdfElement* joint);  // names of links
std::string child_of(const UrdfElement* joint);
bool is_driven(const UrdfElement* joint);  // neither fixed nor a mimic

// The numbers of an attribute; `otherwise`, n times, where it or the element is missing. Throws
// InputError naming link or joint, attribute and text unless there are n finite numbers.
std::vector<double> numbers_of(const UrdfElement* e, const char* attribute, int n,
                               double otherwise);
double number_of(const UrdfElement* e, const char* attribute, double otherwise);
Eigen::Vector3d vector_of(const UrdfElement* e, const char* attribute, double otherwise = 0.0);

// Of the element's <origin>.
Eigen::Isometry3d placement_of(const UrdfElement* e);
void set_placement(UrdfElement* e, const Eigen::Isometry3d& X);
// A rotation that takes z to the direction d.
Eigen::Quaterniond z_along(const Eigen::Vector3d& d);

}  // namespace impedraw
