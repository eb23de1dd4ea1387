#include "impedraw/arm/kinematic_tree.h"

namespace impedraw {
namespace {

using pinocchio::FrameIndex;
using pinocchio::Inertia;
using pinocchio::SE3;

Inertia inertia_of(const urdf::Link& link) {
  if (!link.inertial) return Inertia::Zero();
  const urdf::Inertial& Y = *link.inertial;
  const SE3 X = placement_of(Y.origin);
  Eigen::Matrix3d I;
  I << Y.ixx, Y.ixy, Y.ixz, Y.ixy, Y.iyy, Y.iyz, Y.ixz, Y.iyz, Y.izz;
  return {Y.mass, X.translation(), X.rotation() * I * X.rotation().transpose()};
}

// An axis of the joint's frame has a type of its own, which costs fewer operations.
template <typename AlongX, typename AlongY, typename AlongZ, typename Along>
pinocchio::JointModel along(const Eigen::Vector3d& axis) {
  if (axis == Eigen::Vector3d::UnitX()) return AlongX();
  if (axis == Eigen::Vector3d::UnitY()) return AlongY();
  if (axis == Eigen::Vector3d::UnitZ()) return AlongZ();
  return Along(axis.normalized());
}

pinocchio::JointModel joint_model(const urdf::Joint& joint) {
  const Eigen::Vector3d axis(joint.axis.x, joint.axis.y, joint.axis.z);
  if (joint.type == urdf::Joint::PRISMATIC)
    return along<pinocchio::JointModelPX, pinocchio::JointModelPY, pinocchio::JointModelPZ,
                 pinocchio::JointModelPrismaticUnaligned>(axis);
  return along<pinocchio::JointModelRX, pinocchio::JointModelRY, pinocchio::JointModelRZ,
               pinocchio::JointModelRevoluteUnaligned>(axis);
}

Eigen::VectorXd one(double value) { return Eigen::VectorXd::Constant(1, value); }

pinocchio::JointIndex add_joint(const urdf::Joint& joint, const pinocchio::Frame& parent,
                                const SE3& X, pinocchio::Model* model) {
  const auto& [lower, upper, effort, velocity] = std::tie(
      joint.limits->lower, joint.limits->upper, joint.limits->effort, joint.limits->velocity);
  const double friction = joint.dynamics ? joint.dynamics->friction : 0.0;
  const double damping = joint.dynamics ? joint.dynamics->damping : 0.0;
  return model->addJoint(parent.parentJoint, joint_model(joint), parent.placement * X, joint.name,
                         one(-effort), one(effort), one(-velocity), one(velocity), one(lower),
                         one(upper), one(-friction), one(friction), one(damping));
}

// The link's frame, and those of all that hang on it.
void add_link(const urdf::Link& link, FrameIndex parent, pinocchio::Model* model) {
  const urdf::Joint& joint = *link.parent_joint;
  const SE3 X = placement_of(joint.parent_to_joint_origin_transform);
  const Inertia Y = inertia_of(link);
  FrameIndex joint_frame;
  if (joint.type == urdf::Joint::FIXED) {
    const pinocchio::Frame& p = model->frames[parent];
    joint_frame = model->addFrame(pinocchio::Frame(joint.name, p.parentJoint, parent,
                                                   p.placement * X, pinocchio::FIXED_JOINT, Y));
  } else {
    const pinocchio::JointIndex j = add_joint(joint, model->frames[parent], X, model);
    joint_frame = model->addJointFrame(j, static_cast<int>(parent));
    if (!Y.isZero(0.0)) model->appendBodyToJoint(j, Y);
  }
  const pinocchio::Frame& frame = model->frames[joint_frame];
  const FrameIndex body = model->addBodyFrame(link.name, frame.parentJoint, SE3(frame.placement),
                                              static_cast<int>(joint_frame));
  for (const auto& child : link.child_links) add_link(*child, body, model);
}

}  // namespace

SE3 placement_of(const urdf::Pose& pose) {
  const auto& r = pose.rotation;
  const auto& p = pose.position;
  return {Eigen::Quaterniond(r.w, r.x, r.y, r.z).toRotationMatrix(),
          Eigen::Vector3d(p.x, p.y, p.z)};
}

pinocchio::Model kinematic_tree(const urdf::ModelInterface& description) {
  pinocchio::Model model;
  model.name = description.getName();
  const urdf::Link& root = *description.getRoot();
  const FrameIndex frame = model.addFrame(
      pinocchio::Frame(root.name, 0, 0, SE3::Identity(), pinocchio::BODY, inertia_of(root)));
  for (const auto& child : root.child_links) add_link(*child, frame, &model);
  return model;
}

}  // namespace impedraw
