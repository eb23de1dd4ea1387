#include "impedraw/arm/urdf_model.h"

#include <string>

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include "impedraw/arm/arm_model.h"
#include "impedraw/arm/kinematic_tree.h"
#include "impedraw/arm/plain_urdf.h"
#include "impedraw/arm/urdf_tree.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/per_joint.h"
#include "impedraw/common/range_check.h"
#include "impedraw/control/arm_terms.h"

namespace impedraw {
namespace {

// Keeps the parser's first complaint, which names the cause, instead of printing all of them.
class ParserMessages : public console_bridge::OutputHandler {
 public:
  ParserMessages() { console_bridge::useOutputHandler(this); }
  ~ParserMessages() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (first_.empty() && level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR)
      first_ = text.substr(0, text.find('\n'));
  }
  const std::string& first() const { return first_; }

 private:
  std::string first_;
};

void check_body(const std::string& link, const urdf::Geometry* body) {
  const auto require = [&link](const char* what, double value) {
    if (!(value > 0.0))
      throw InputError(
          fmt::format("link '{}': {} is {} m; valid is more than 0 m", link, what, value));
  };
  if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(body)) {
    require("a cylinder's radius", cylinder->radius);
    require("a cylinder's length", cylinder->length);
  } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(body)) {
    require("a sphere's radius", sphere->radius);
  } else if (const auto* capsule = dynamic_cast<const urdf::Capsule*>(body)) {
    require("a capsule's radius", capsule->radius);
    require("a capsule's length", capsule->length);
  }
}

// The name of the type of a joint that is neither revolute nor prismatic, else nothing.
const char* unusable_type(const urdf::Joint& joint) {
  switch (joint.type) {
    case urdf::Joint::REVOLUTE:
    case urdf::Joint::PRISMATIC:
    case urdf::Joint::FIXED:
      return nullptr;
    case urdf::Joint::FLOATING:
      return "floating";
    case urdf::Joint::PLANAR:
      return "planar";
    default:
      return "of an unknown type";
  }
}

void check_joint(const urdf::Joint& joint) {
  if (const char* type = unusable_type(joint))
    throw InputError(
        fmt::format("joint '{}' is {}; valid are fixed, continuous, revolute and prismatic joints",
                    joint.name, type));
  if (joint.mimic)
    throw InputError(
        fmt::format("joint '{}' mimics joint '{}'; every joint must have a drive of its own",
                    joint.name, joint.mimic->joint_name));
  if (joint.type == urdf::Joint::FIXED) return;
  const auto& limits = joint.limits;
  if (!limits) throw InputError(fmt::format("joint '{}' has no limits", joint.name));
  if (!(limits->lower < limits->upper))
    throw InputError(fmt::format("joint '{}': the lower limit {} must be below the upper limit {}",
                                 joint.name, limits->lower, limits->upper));
}

void check_description(const urdf::ModelInterface& description) {
  for (const auto& [name, joint] : description.joints_) check_joint(*joint);
  for (const auto& [name, link] : description.links_) {
    for (const auto& body : link->collision_array) check_body(name, body->geometry.get());
    for (const auto& body : link->visual_array) check_body(name, body->geometry.get());
  }
}

std::vector<LinkCapsule> link_capsules(const urdf::ModelInterface& description,
                                       const pinocchio::Model& model) {
  std::vector<LinkCapsule> capsules;
  for (const auto& [name, link] : description.links_) {
    const auto& frame = model.frames[model.getFrameId(name, pinocchio::BODY)];
    for (const auto& body : link->collision_array) {
      const pinocchio::SE3 X_JB = frame.placement * placement_of(body->origin);
      const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(body->geometry.get());
      const auto* capsule = dynamic_cast<const urdf::Capsule*>(body->geometry.get());
      if (cylinder || capsule) {
        const Eigen::Vector3d half(0, 0, 0.5 * (cylinder ? cylinder->length : capsule->length));
        capsules.push_back({name, frame.parentJoint, X_JB.act(Eigen::Vector3d(-half)),
                            X_JB.act(half), cylinder ? cylinder->radius : capsule->radius});
      } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(body->geometry.get())) {
        capsules.push_back(
            {name, frame.parentJoint, X_JB.translation(), X_JB.translation(), sphere->radius});
      } else {
        throw InputError(
            fmt::format("link '{}' has a collision body without a shape; valid are "
                        "cylinder, sphere, capsule, box and mesh",
                        name));
      }
    }
  }
  return capsules;
}

}  // namespace

UrdfModel read_urdf(const std::filesystem::path& urdf, const std::string& tip) {
  return parse_urdf(plain_urdf(urdf, tip).text, urdf);
}

urdf::ModelInterfaceSharedPtr parsed_urdf(const std::string& text,
                                          const std::filesystem::path& file) {
  ParserMessages messages;
  urdf::ModelInterfaceSharedPtr description = urdf::parseURDF(text);
  if (!description || !description->getRoot())
    throw InputError(fmt::format("arm description {}: not a valid URDF{}{}", file.string(),
                                 messages.first().empty() ? "" : ": ", messages.first()));
  return description;
}

UrdfModel parse_urdf(const std::string& text, const std::filesystem::path& urdf) {
  const urdf::ModelInterfaceSharedPtr description = parsed_urdf(text, urdf);
  UrdfModel arm;
  try {
    check_description(*description);
    arm.model = kinematic_tree(*description);
    arm.capsules = link_capsules(*description, arm.model);
  } catch (const std::exception& error) {
    throw InputError(fmt::format("arm description {}: {}", urdf.string(), error.what()));
  }
  const int n = arm.model.nv;
  arm.notes = read_arm_notes(text, urdf);
  const std::size_t rest = arm.notes.rest_posture.size();
  if (rest != 0 && rest != static_cast<std::size_t>(n))
    throw InputError(fmt::format("arm description {}: rest_posture has {} angles for {} joints",
                                 urdf.string(), rest, n));
  per_joint(fmt::format("arm description {}: rotor_inertia", urdf.string()),
            arm.notes.rotor_inertia, n);
  require_in_range(fmt::format("arm description {}", urdf.string()), kRotorInertia,
                   arm.notes.rotor_inertia);
  if (arm.model.nq != n || arm.model.njoints != n + 1)
    throw InputError(
        fmt::format("arm description {}: every joint must have one axis", urdf.string()));
  if (n < 6 || n > kMaxJoints)
    throw InputError(fmt::format("arm description {}: {} joints, valid are 6 to {}", urdf.string(),
                                 n, kMaxJoints));
  return arm;
}

int require_arm(const std::string& text, const std::filesystem::path& name) {
  return parse_urdf(text, name).model.nv;
}

}  // namespace impedraw
