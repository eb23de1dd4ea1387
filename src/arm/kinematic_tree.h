// The rigid-body model of an arm, built from what urdfdom has read. Pinocchio's own reader of URDFs
// builds the same model, and brings along a library of collisions that nothing here uses; loading
// it took 9 ms of each command. Only this folder's sources include this header.
//
// A link behind a moving joint adds its inertia to that joint; a fixed link adds it to the joint
// before it. An axis stands in its joint's frame.
#pragma once

#include <urdf_model/model.h>
#include <pinocchio/multibody/model.hpp>

namespace impedraw {

pinocchio::SE3 placement_of(const urdf::Pose& pose);

// Joints are fixed, revolute or prismatic, and the latter two have limits. A joint frame and a body
// frame stand for each joint and link, by name. Throws what Pinocchio throws at a name that comes
// twice.
pinocchio::Model kinematic_tree(const urdf::ModelInterface& description);

}  // namespace impedraw
