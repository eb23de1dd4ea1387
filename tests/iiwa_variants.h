// Arms with other numbers of joints, made from the iiwa's description.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace impedraw {

inline std::string iiwa_urdf() {
  std::ostringstream all;
  all << std::ifstream("models/iiwa14_pen.urdf").rdbuf();
  return all.str();
}

// Replaces the first `from` after the first `place`.
inline std::string changed(std::string text, const std::string& place, const std::string& from,
                           const std::string& to) {
  const std::size_t at = text.find(from, text.find(place));
  if (at == std::string::npos) throw std::out_of_range(place + ": no " + from);
  return text.replace(at, from.size(), to);
}

// Six joints: the elbow does not swing, as on an arm with a spherical wrist.
inline std::string six_joint_urdf() {
  return changed(iiwa_urdf(), "<joint name=\"joint_3\"", "revolute", "fixed");
}

// Eight joints: the flange tilts.
inline std::string eight_joint_urdf() {
  const std::string flange = "<joint name=\"flange_joint\"";
  std::string urdf = changed(iiwa_urdf(), flange, "fixed", "revolute");
  urdf = changed(urdf, flange, "</joint>",
                 "<axis xyz=\"1 0 0\"/><limit lower=\"-1.5\" upper=\"1.5\" effort=\"40\" "
                 "velocity=\"2.4\"/></joint>");
  return changed(urdf, "<link name=\"flange\"/>", "<link name=\"flange\"/>",
                 "<link name=\"flange\"><inertial><origin xyz=\"0 0 0\"/><mass value=\"0.3\"/>"
                 "<inertia ixx=\"0.001\" iyy=\"0.001\" izz=\"0.001\" ixy=\"0\" ixz=\"0\" "
                 "iyz=\"0\"/></inertial></link>");
}

}  // namespace impedraw
