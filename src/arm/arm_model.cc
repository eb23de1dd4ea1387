#include "impedraw/arm/arm_model.h"

#include <array>

#include <fmt/format.h>

#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/multibody/data.hpp>

#include "impedraw/arm/urdf_model.h"
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
      : data(model), q(Eigen::VectorXd::Zero(model.nv)) {}

  pinocchio::Data data;
  Eigen::VectorXd q;  // PrebuiltVector refers to a plain VectorXd without a copy
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
  ArmTerms& t = *terms;
  t.q = q;
  t.v = v;

  // In the world frame it also computes placements, joint Jacobians and composite inertias Y_i.
  pinocchio::crba(d.urdf.model, w.data, PrebuiltVector(w.q), pinocchio::Convention::WORLD);
  t.M = w.data.M.selfadjointView<Eigen::Upper>();  // crba fills the upper triangle only

  // Newton–Euler with v̇ = 0 and no weight, in the world frame, where those serve. Of a link:
  // velocity and acceleration of its point at W's origin, and of its turn.
  struct Motion {
    Eigen::Vector3d v = Eigen::Vector3d::Zero(), w = v, a = v, alpha = v;
    Eigen::Vector3d v_at(const Eigen::Vector3d& p) const { return v + w.cross(p); }
    Eigen::Vector3d a_at(const Eigen::Vector3d& p) const {
      return a + alpha.cross(p) + w.cross(v_at(p));
    }
  } link;
  const int n = static_cast<int>(t.g.size());
  const auto J_linear = w.data.J.topRows<3>(), J_angular = w.data.J.bottomRows<3>();
  std::array<Vector6, kMaxJoints> wrench;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3d by_v = v[i] * J_linear.col(i), by_w = v[i] * J_angular.col(i);
    link.a += link.v.cross(by_w) + link.w.cross(by_v);
    link.alpha += link.w.cross(by_w);
    link.v += by_v;
    link.w += by_w;
    const pinocchio::Inertia& body = d.urdf.model.inertias[i + 1];
    const pinocchio::SE3& X_WL = w.data.oMi[i + 1];
    const Eigen::Matrix3d& R = X_WL.rotation();
    const Eigen::Vector3d c = X_WL.act(body.lever()), f = body.mass() * link.a_at(c);
    const auto turned = [&](const Eigen::Vector3d& x) -> Eigen::Vector3d {
      return R * (body.inertia() * (R.transpose() * x));
    };
    wrench[i] << f, turned(link.alpha) + link.w.cross(turned(link.w)) + c.cross(f);
  }
  Vector6 carried = Vector6::Zero();
  for (int i = n; i-- > 0;) {
    carried += wrench[i];
    t.Cv[i] = w.data.J.col(i).dot(carried);
    // Gravity torque: g_i = −J_iᵀ Y_i a_g
    const pinocchio::Inertia& outward = w.data.oYcrb[i + 1];
    const Eigen::Vector3d weight = outward.mass() * d.urdf.model.gravity.linear();
    t.g[i] = -J_linear.col(i).dot(weight) - J_angular.col(i).dot(outward.lever().cross(weight));
  }
  if (d.damped) t.Cv += d.urdf.model.damping.cwiseProduct(v);

  move_tip(terms);
  t.V_WE << link.v_at(t.X_WE.p), link.w;
  t.Jdot_v << link.a_at(t.X_WE.p), link.alpha;
}

void ArmModel::place(const JointVector& q, ArmTerms* terms) noexcept {
  Workspace& w = *workspace_;
  w.q = q;
  terms->q = q;
  pinocchio::computeJointJacobians(description_->urdf.model, w.data, PrebuiltVector(w.q));
  move_tip(terms);
}

// X_WE and J, of the joints' placements and world-frame Jacobian.
void ArmModel::move_tip(ArmTerms* terms) const noexcept {
  const Workspace& w = *workspace_;
  const pinocchio::Frame& tip = description_->urdf.model.frames[description_->tip];
  const pinocchio::SE3 X_WE = w.data.oMi[tip.parentJoint] * tip.placement;
  terms->X_WE = {X_WE.translation(), X_WE.rotation()};
  // Its columns, moved to E's origin.
  const auto J_linear = w.data.J.topRows<3>(), J_angular = w.data.J.bottomRows<3>();
  terms->J.bottomRows<3>() = J_angular;
  for (Eigen::Index i = 0; i < terms->J.cols(); ++i)
    terms->J.col(i).head<3>() = J_linear.col(i) + J_angular.col(i).cross(X_WE.translation());
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
