#include "impedraw/arm/arm_model.h"

#include <fmt/format.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody/data.hpp>
#include <pinocchio/multibody/model.hpp>
#include <pinocchio/parsers/urdf.hpp>

#include "impedraw/common/errors.h"

namespace impedraw {

namespace {

struct LinkCapsule {
  std::string link;
  pinocchio::JointIndex joint;
  Eigen::Vector3d a_J, b_J;  // in the joint's frame
  double radius;
};

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

struct ArmModel::Workspace {
  pinocchio::Model model;
  pinocchio::Data data;
  pinocchio::FrameIndex tip;
  std::vector<std::string> joint_names;
  ArmLimits limits;
  std::vector<LinkCapsule> capsules;
  Eigen::VectorXd q, v;  // Pinocchio's prebuilt algorithms take plain VectorXd
};

ArmModel::ArmModel(const std::filesystem::path& urdf, const std::string& tip_frame)
    : workspace_(std::make_unique<Workspace>()) {
  Workspace& w = *workspace_;
  if (!std::filesystem::is_regular_file(urdf))
    throw InputError(fmt::format("arm description {}: no such file", urdf.string()));
  const urdf::ModelInterfaceSharedPtr description = urdf::parseURDFFile(urdf.string());
  if (!description)
    throw InputError(fmt::format("arm description {}: not a valid URDF", urdf.string()));
  try {
    pinocchio::urdf::buildModel(description, w.model);
    w.capsules = link_capsules(*description, w.model);
  } catch (const std::exception& error) {
    throw InputError(fmt::format("arm description {}: {}", urdf.string(), error.what()));
  }
  const int n = w.model.nv;
  if (w.model.nq != n || w.model.njoints != n + 1)
    throw InputError(
        fmt::format("arm description {}: every joint must be revolute with limits, or prismatic",
                    urdf.string()));
  if (n < 6 || n > kMaxJoints)
    throw InputError(fmt::format("arm description {}: {} joints, valid are 6 to {}", urdf.string(),
                                 n, kMaxJoints));
  if (!w.model.existFrame(tip_frame))
    throw InputError(
        fmt::format("arm description {}: no frame named '{}'", urdf.string(), tip_frame));
  w.data = pinocchio::Data(w.model);
  w.tip = w.model.getFrameId(tip_frame);
  for (int i = 1; i <= n; ++i) w.joint_names.push_back(w.model.names[i]);
  w.limits = {w.model.lowerPositionLimit, w.model.upperPositionLimit, w.model.upperEffortLimit,
              w.model.upperVelocityLimit};
  w.q = w.v = Eigen::VectorXd::Zero(n);
}

ArmModel::~ArmModel() = default;
ArmModel::ArmModel(ArmModel&&) noexcept = default;

int ArmModel::joints() const { return workspace_->model.nv; }
const std::vector<std::string>& ArmModel::joint_names() const { return workspace_->joint_names; }
const ArmLimits& ArmModel::limits() const { return workspace_->limits; }

void ArmModel::compute(const JointVector& q, const JointVector& v, ArmTerms* terms) noexcept {
  Workspace& w = *workspace_;
  w.q = q;
  w.v = v;
  ArmTerms& t = *terms;
  t.q = q;
  t.v = v;

  // Two passes over the arm give everything; each algorithm for itself would make five.
  // The mass matrix by composite inertias in the world leaves placements, joint Jacobians and those
  // inertias behind …
  pinocchio::crba(w.model, w.data, w.q, pinocchio::Convention::WORLD);
  t.M = w.data.M.selfadjointView<Eigen::Upper>();  // crba fills the upper triangle only
  for (int i = 0; i < t.g.size(); ++i) {  // … of which gravity's torque is  g_i = −J_iᵀ Y_i a_g
    const pinocchio::Force weight = w.data.oYcrb[i + 1] * w.model.gravity;
    t.g[i] = -w.data.J.col(i).dot(weight.toVector());
  }

  // The bias leaves velocities behind, and accelerations for v̇ = 0 in a frame that rises at g: less
  // gravity, the tip's drift J̇ v.
  t.Cv = pinocchio::nonLinearEffects(w.model, w.data, w.q, w.v) - t.g;
  const pinocchio::Frame& tip = w.model.frames[w.tip];
  const pinocchio::JointIndex link = tip.parentJoint;
  const pinocchio::SE3 X_WE = w.data.oMi[link] * tip.placement;
  const Eigen::Matrix3d& R_WE = X_WE.rotation();
  t.X_WE = {X_WE.translation(), R_WE};
  const pinocchio::Motion V_E = tip.placement.actInv(w.data.v[link]);
  const pinocchio::Motion A_E = tip.placement.actInv(w.data.a_gf[link]);
  t.V_WE << R_WE * V_E.linear(), R_WE * V_E.angular();
  // classical, of E's origin
  const Eigen::Vector3d falling = A_E.linear() + V_E.angular().cross(V_E.linear());
  t.Jdot_v << R_WE * falling + w.model.gravity.linear(), R_WE * A_E.angular();

  // Columns of the world-frame Jacobian, moved to E's origin.
  const auto J_linear = w.data.J.topRows<3>(), J_angular = w.data.J.bottomRows<3>();
  t.J.bottomRows<3>() = J_angular;
  for (int i = 0; i < t.g.size(); ++i)
    t.J.col(i).head<3>() = J_linear.col(i) + J_angular.col(i).cross(X_WE.translation());
}

Pose ArmModel::tip_pose(const JointVector& q) {
  Workspace& w = *workspace_;
  w.q = q;
  pinocchio::forwardKinematics(w.model, w.data, w.q);
  const pinocchio::SE3& X_WE = pinocchio::updateFramePlacement(w.model, w.data, w.tip);
  return {X_WE.translation(), X_WE.rotation()};
}

std::vector<BodyCapsule> ArmModel::body_capsules(const JointVector& q) {
  Workspace& w = *workspace_;
  w.q = q;
  pinocchio::forwardKinematics(w.model, w.data, w.q);
  std::vector<BodyCapsule> bodies;
  for (const LinkCapsule& c : w.capsules) {
    const pinocchio::SE3& X_WJ = w.data.oMi[c.joint];
    bodies.push_back({c.link, X_WJ.act(c.a_J), X_WJ.act(c.b_J), c.radius});
  }
  return bodies;
}

}  // namespace impedraw
