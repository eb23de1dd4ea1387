#include "impedraw/arm/arm_shapes.h"

#include <functional>

#include <fmt/format.h>
#include <urdf_model/model.h>

#include "impedraw/arm/plain_urdf.h"
#include "impedraw/arm/urdf_tree.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

Pose pose_of(const urdf::Pose& pose) {
  const auto& r = pose.rotation;
  return {{pose.position.x, pose.position.y, pose.position.z},
          Eigen::Quaterniond(r.w, r.x, r.y, r.z).normalized().toRotationMatrix()};
}

std::vector<VisualShape> shapes_of(const urdf::Link& link) {
  std::vector<VisualShape> shapes;
  for (const auto& visual : link.visual_array) {
    if (!visual || !visual->geometry) continue;
    VisualShape shape;
    shape.X_LS = pose_of(visual->origin);
    const urdf::Geometry* geometry = visual->geometry.get();
    if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(geometry)) {
      shape.kind = VisualShape::Kind::cylinder;
      shape.size = {cylinder->radius, cylinder->length, 0.0};
    } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(geometry)) {
      shape.kind = VisualShape::Kind::sphere;
      shape.size = {sphere->radius, 0.0, 0.0};
    } else if (const auto* box = dynamic_cast<const urdf::Box*>(geometry)) {
      shape.kind = VisualShape::Kind::box;
      shape.size = {box->dim.x, box->dim.y, box->dim.z};
    } else if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(geometry)) {
      shape.kind = VisualShape::Kind::mesh;
      shape.size = {mesh->scale.x, mesh->scale.y, mesh->scale.z};
      shape.mesh = mesh->filename;
    } else {
      continue;
    }
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

}  // namespace

std::vector<DrawnLink> read_arm_shapes(const std::filesystem::path& urdf) {
  const urdf::ModelInterfaceSharedPtr description = parsed_urdf(plain_urdf(urdf).text, urdf);
  std::vector<DrawnLink> links;
  const std::function<void(const urdf::Link&, int)> add = [&](const urdf::Link& link, int parent) {
    DrawnLink drawn;
    drawn.name = link.name;
    drawn.parent = parent;
    if (const auto& joint = link.parent_joint) {
      drawn.joint_name = joint->name;
      drawn.X_PL = pose_of(joint->parent_to_joint_origin_transform);
      if (joint->type == urdf::Joint::REVOLUTE || joint->type == urdf::Joint::CONTINUOUS)
        drawn.joint = DrawnLink::Joint::revolute;
      else if (joint->type == urdf::Joint::PRISMATIC)
        drawn.joint = DrawnLink::Joint::prismatic;
      else if (joint->type != urdf::Joint::FIXED)
        throw InputError(fmt::format("arm description {}: joint '{}' cannot be drawn",
                                     urdf.string(), joint->name));
      const Eigen::Vector3d axis(joint->axis.x, joint->axis.y, joint->axis.z);
      if (axis.norm() > 0.0) drawn.axis_L = axis.normalized();
    }
    drawn.shapes = shapes_of(link);
    links.push_back(std::move(drawn));
    const int self = static_cast<int>(links.size()) - 1;
    for (const auto& child : link.child_links) add(*child, self);
  };
  add(*description->getRoot(), -1);
  return links;
}

}  // namespace impedraw
