// A vendor's arm description in the few words that all readers here share. Pinocchio, MuJoCo and
// the page read what this gives, and so agree on the arm.
//
//  the way      joints from the root to the frame `tip`: driven; a continuous one is revolute, ± 2π
//  off the way  every other joint, fixed where it stands: at 0, or its nearest limit
//  bodies       cylinders, spheres, capsules; boxes and meshes become enclosing capsules
//
// Attributes that need no change keep their text.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "impedraw/arm/arm_notes.h"

namespace impedraw {

struct PlainUrdf {
  std::string text;
  std::vector<std::string> notes;  // what was chosen or filled in, a line each
};

// Throws InputError for what require_urdf() refuses, a frame `tip` that is missing (then it names
// the links that could carry a pen), and a value that cannot be: a limit that is not above 0, a
// mesh that cannot be read, an inertia that breaks the triangle rule, a joint that moves no mass.
PlainUrdf plain_urdf(const std::filesystem::path& file, const std::string& tip = "tip");

// The same with a pen on the link `flange`, along its z; or (empty) on the one that a tool is put
// on where that is clear, away from the arm along the last joint's axis. It begins beyond a
// gripper. A file that has a link `tip` gets no pen. What is missing or cannot be is filled in,
// and notes say with what:
//   effort of a joint    twice what carries the arm beyond it, stretched out, and 10 Nm (50 N)
//   velocity             1.5 rad/s, 0.25 m/s
//   mass of a moved link 1 kg in a ball of 50 mm
//   inertia              of that ball; one that breaks the triangle rule: its least moments raised
//   a mesh               a body of 60 mm around the way to the next joint
// Throws InputError for the rest, and where the flange is not clear: it lists the candidates.
PlainUrdf vendor_urdf_with_pen(const std::filesystem::path& file, const std::string& flange,
                               const PenOnFlange& pen);

// The file of a <mesh filename>: file://, package:// and relative names are looked for beside the
// description and in the folders above it, a package's also without the package's name. Empty:
// there is none.
std::filesystem::path urdf_mesh(const std::filesystem::path& urdf, const std::string& name);

// The number of joints of a plain text that the file `name` holds, or will. Throws InputError as
// ArmModel's constructor does.
int require_arm(const std::string& text, const std::filesystem::path& name);

}  // namespace impedraw
