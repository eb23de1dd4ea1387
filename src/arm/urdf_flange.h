// Where a pen goes on a vendor's arm. Only this folder's sources include this header.
//
// The arm ends at its last joint: the sixth or a later one, beyond which no joint moves but those
// of a gripper (several beside each other, mimic or prismatic joints, or one that is named so). Of
// the links fixed to that joint the flange is the one with the first of these names in its own:
// tool0, tcp, flange, eef, ee_link, end_effector, tool, hand, gripper; or the only one.
#pragma once

#include <string>
#include <vector>

#include "impedraw/arm/urdf_tree.h"

namespace impedraw {

struct PenMount {
  std::string link;        // F
  Eigen::Isometry3d X_FM;  // z of M: along the pen
  std::vector<std::string> notes;
};

std::vector<std::string> flange_candidates(const UrdfTree& tree);

// `flange`: a link's name; empty: the one that is clear, with the pen away from the arm along the
// last joint's axis. Throws InputError, which lists the candidates, where it is not clear.
PenMount find_mount(const UrdfTree& tree, const std::string& flange);

// Adds a link at M, or beyond all that the last joint carries beside F's own way;
// bodies must be plain.
// Returns its name: `flange`, unless another link has it.
std::string put_mount(UrdfTree* tree, PenMount* mount);

}  // namespace impedraw
