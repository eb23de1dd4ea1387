#include "impedraw/arm/arm_model.h"

#include <fmt/format.h>

#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody/data.hpp>

#include "impedraw/arm/urdf_model.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/per_joint.h"
#include "impedraw/common/range_check.h"

namespace impedraw {
namespace {

// Pinocchio's library is precompiled for this argument type. Any other type instantiates the
// algorithms again, at a cost of 45 s and 1.3 GB.
using PrebuiltVector = Eigen::Ref<const Eigen::VectorXd>;

}  // namespace

struct ArmModel::Description {
  UrdfModel urdf;
  pinocchio::FrameIndex tip;
  std::vector<std::string> joint_names;
  ArmLimits limits;
  bool damped = false;
};

struct ArmModel::Workspace {
  explicit Workspace(const pinocchio::Model& model)
      : data(model), q(Eigen::VectorXd::Zero(model.nv)), v(q) {}

  pinocchio::Data data;
  Eigen::VectorXd q, v;  // PrebuiltVector refers to plain VectorXd without a copy
};

ArmModel::ArmModel(const std::filesystem::path& urdf, const std::string& tip_frame) {
  Description d{read_urdf(urdf, tip_frame), {}, {}, {}};
  const pinocchio::Model& model = d.urdf.model;
  d.tip = model.getFrameId(tip_frame);
  d.joint_names.assign(model.names.begin() + 1, model.names.end());
  d.limits = {model.lowerPositionLimit, model.upperPositionLimit, model.upperEffortLimit,
              model.upperVelocityLimit};
  d.limits.torque_rate = d.urdf.notes.torque_rate;
  workspace_ = std::make_unique<Workspace>(model);
  description_ = std::make_shared<const Description>(std::move(d));
  set_rotor_inertia({});
}

ArmModel::~ArmModel() = default;
ArmModel::ArmModel(ArmModel&&) noexcept = default;
ArmModel::ArmModel(const ArmModel& other)
    : description_(other.description_),
      workspace_(std::make_unique<Workspace>(description_->urdf.model)) {}

int ArmModel::joints() const { return description_->urdf.model.nv; }
const std::vector<std::string>& ArmModel::joint_names() const { return description_->joint_names; }
const ArmLimits& ArmModel::limits() const { return description_->limits; }
const std::vector<double>& ArmModel::rest_posture() const {
  return description_->urdf.notes.rest_posture;
}

const Eigen::VectorXd& ArmModel::rotor_inertia() const { return description_->urdf.model.armature; }

void ArmModel::set_rotor_inertia(const std::vector<double>& values) {
  require_in_range("arm", kRotorInertia, values);
  Description d = *description_;
  d.urdf.model.armature = per_joint(
      "arm.rotor_inertia", values.empty() ? d.urdf.notes.rotor_inertia : values, d.urdf.model.nv);
  description_ = std::make_shared<const Description>(std::move(d));
}

void ArmModel::lengthen_pen(double by) {
  Description d = *description_;
  pinocchio::SE3& X_JE = d.urdf.model.frames[d.tip].placement;
  X_JE.translation() += by * X_JE.rotation().col(2);
  description_ = std::make_shared<const Description>(std::move(d));
}

void ArmModel::expect_damping() {
  Description d = *description_;
  d.damped = true;
  description_ = std::make_shared<const Description>(std::move(d));
}

void ArmModel::compute(const JointVector& q, const JointVector& v, ArmTerms* terms) noexcept {
  const Description& d = *description_;
  Workspace& w = *workspace_;
  w.q = q;
  w.v = v;
  const PrebuiltVector w_q(w.q), w_v(w.v);
  ArmTerms& t = *terms;
  t.q = q;
  t.v = v;

  // Two passes over the arm compute everything; separate algorithms would need five.
  // crba in the world frame also computes placements, joint Jacobians and composite inertias Y_i.
  pinocchio::crba(d.urdf.model, w.data, w_q, pinocchio::Convention::WORLD);
  t.M = w.data.M.selfadjointView<Eigen::Upper>();  // crba fills the upper triangle only
  // Gravity torque: g_i = −J_iᵀ Y_i a_g
  for (int i = 0; i < t.g.size(); ++i) {
    const pinocchio::Force weight = w.data.oYcrb[i + 1] * d.urdf.model.gravity;
    t.g[i] = -w.data.J.col(i).dot(weight.toVector());
  }

  // nonLinearEffects also computes velocities, and accelerations for v̇ = 0 minus gravity. Adding
  // gravity to the tip's acceleration gives its drift J̇ v.
  t.Cv = pinocchio::nonLinearEffects(d.urdf.model, w.data, w_q, w_v) - t.g;
  if (d.damped) t.Cv += d.urdf.model.damping.cwiseProduct(w.v);
  const pinocchio::Frame& tip = d.urdf.model.frames[d.tip];
  const pinocchio::JointIndex link = tip.parentJoint;
  const pinocchio::SE3 X_WE = w.data.oMi[link] * tip.placement;
  const Eigen::Matrix3d& R_WE = X_WE.rotation();
  t.X_WE = {X_WE.translation(), R_WE};
  const pinocchio::Motion V_E = tip.placement.actInv(w.data.v[link]);
  const pinocchio::Motion A_E = tip.placement.actInv(w.data.a_gf[link]);
  t.V_WE << R_WE * V_E.linear(), R_WE * V_E.angular();
  // classical acceleration of E's origin
  const Eigen::Vector3d falling = A_E.linear() + V_E.angular().cross(V_E.linear());
  t.Jdot_v << R_WE * falling + d.urdf.model.gravity.linear(), R_WE * A_E.angular();

  // Columns of the world-frame Jacobian, moved to E's origin.
  const auto J_linear = w.data.J.topRows<3>(), J_angular = w.data.J.bottomRows<3>();
  t.J.bottomRows<3>() = J_angular;
  for (int i = 0; i < t.g.size(); ++i)
    t.J.col(i).head<3>() = J_linear.col(i) + J_angular.col(i).cross(X_WE.translation());
}

Pose ArmModel::tip_pose(const JointVector& q) {
  const Description& d = *description_;
  Workspace& w = *workspace_;
  w.q = q;
  pinocchio::forwardKinematics(d.urdf.model, w.data, PrebuiltVector(w.q));
  const pinocchio::SE3& X_WE = pinocchio::updateFramePlacement(d.urdf.model, w.data, d.tip);
  return {X_WE.translation(), X_WE.rotation()};
}

std::vector<BodyCapsule> ArmModel::body_capsules(const JointVector& q) {
  const Description& d = *description_;
  Workspace& w = *workspace_;
  w.q = q;
  pinocchio::forwardKinematics(d.urdf.model, w.data, PrebuiltVector(w.q));
  std::vector<BodyCapsule> bodies;
  for (const LinkCapsule& c : d.urdf.capsules) {
    const pinocchio::SE3& X_WJ = w.data.oMi[c.joint];
    bodies.push_back({c.link, X_WJ.act(c.a_J), X_WJ.act(c.b_J), c.radius});
  }
  return bodies;
}

}  // namespace impedraw
