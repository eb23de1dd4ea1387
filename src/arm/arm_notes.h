// Facts of an arm for which URDF has no word: an element of its own,
//   <impedraw rest_posture="0 0.6 0 -1.4 0 1.1 0" torque_rate="1000"
//             rotor_inertia="0.3 0.3 0.2 0.2 0.1 0.1 0.1"/>
// directly in <robot>. Everyone else ignores it. And the pen on a bare arm's flange.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

namespace impedraw {

struct ArmNotes {
  // A working posture, pen down, from which the inverse kinematics starts [rad]; empty: not given.
  std::vector<double> rest_posture;
  double torque_rate = std::numeric_limits<double>::infinity();  // of every joint [Nm/s]
  // Reflected through the gear, of every joint or of each; empty: not given [kg m²].
  std::vector<double> rotor_inertia;
};

// The notes in a file's text. Throws InputError if a number in the element cannot be read.
ArmNotes read_arm_notes(const std::string& text, const std::filesystem::path& urdf);

struct PenOnFlange {
  double length = 0.12;  // from the flange to the tip's apex, along the flange's z [m]
  double mass = 0.05;    // of the whole tool, evenly along it [kg]
};

// The description of an arm with a link `flange`, z out of it, and a straight tool on it: the links
// `pen` and `tip`. Throws InputError if there is no flange, or a tool already.
std::string urdf_with_pen(const std::string& bare, const PenOnFlange& pen,
                          const std::string& flange = "flange");

}  // namespace impedraw
