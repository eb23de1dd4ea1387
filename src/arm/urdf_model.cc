#include "impedraw/arm/urdf_model.h"

#include <fmt/format.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <pinocchio/parsers/urdf.hpp>

#include "impedraw/arm/urdf_text.h"
#include "impedraw/common/errors.h"
#include "impedraw/control/arm_terms.h"

namespace impedraw {

namespace {

pinocchio::SE3 placement(const urdf::Pose& pose) {
  const auto& r = pose.rotation;
  const auto& p = pose.position;
  return {Eigen::Quaterniond(r.w, r.x, r.y, r.z).toRotationMatrix(),
          Eigen::Vector3d(p.x, p.y, p.z)};
}

std::vector<LinkCapsule> link_capsules(const urdf::ModelInterface& description,
                                       const pinocchio::Model& model) {
  std::vector<LinkCapsule> capsules;
  for (const auto& [name, link] : description.links_) {
    const auto& frame = model.frames[model.getFrameId(name, pinocchio::BODY)];
    for (const auto& body : link->collision_array) {
      const pinocchio::SE3 X_JB = frame.placement * placement(body->origin);
      if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(body->geometry.get())) {
        const Eigen::Vector3d half(0, 0, cylinder->length / 2);
        capsules.push_back({name, frame.parentJoint, X_JB.act(Eigen::Vector3d(-half)),
                            X_JB.act(half), cylinder->radius});
      } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(body->geometry.get())) {
        capsules.push_back(
            {name, frame.parentJoint, X_JB.translation(), X_JB.translation(), sphere->radius});
      } else {
        throw InputError(
            fmt::format("link {}: a collision body that is neither a cylinder nor a sphere", name));
      }
    }
  }
  return capsules;
}

}  // namespace

UrdfModel read_urdf(const std::filesystem::path& urdf) {
  require_urdf_file(urdf);
  const urdf::ModelInterfaceSharedPtr description = urdf::parseURDFFile(urdf.string());
  if (!description)
    throw InputError(fmt::format("arm description {}: not a valid URDF", urdf.string()));
  UrdfModel arm;
  try {
    pinocchio::urdf::buildModel(description, arm.model);
    arm.capsules = link_capsules(*description, arm.model);
  } catch (const std::exception& error) {
    throw InputError(fmt::format("arm description {}: {}", urdf.string(), error.what()));
  }
  const int n = arm.model.nv;
  if (arm.model.nq != n || arm.model.njoints != n + 1)
    throw InputError(
        fmt::format("arm description {}: every joint must be revolute with limits, or prismatic",
                    urdf.string()));
  if (n < 6 || n > kMaxJoints)
    throw InputError(fmt::format("arm description {}: {} joints, valid are 6 to {}", urdf.string(),
                                 n, kMaxJoints));
  return arm;
}

}  // namespace impedraw
