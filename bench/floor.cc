#include "floor.h"

#include <Eigen/Cholesky>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody/data.hpp>

#include "floor_model.h"

namespace impedraw {

struct Floor::Model {
  pinocchio::Model model;
  pinocchio::Data data;
  pinocchio::FrameIndex tip;
  Eigen::VectorXd zero;
  Eigen::Matrix<double, 6, 7> J;
};

Floor::Floor(const char* urdf) : model_(std::make_unique<Model>()) {
  model_->model = floor_model(urdf);
  model_->data = pinocchio::Data(model_->model);
  model_->tip = model_->model.getFrameId("tip");
  model_->zero = Eigen::VectorXd::Zero(7);
}

Floor::~Floor() = default;

double Floor::compute(const Eigen::VectorXd& q, const Eigen::VectorXd& v) {
  using namespace pinocchio;
  Model& m = *model_;
  const auto frame = LOCAL_WORLD_ALIGNED;
  // the argument type that Pinocchio's library is precompiled for
  const Eigen::Ref<const Eigen::VectorXd> q_ref(q), v_ref(v), zero(m.zero);
  crba(m.model, m.data, q_ref, Convention::WORLD);  // mass matrix (and joint Jacobians)
  m.data.M.triangularView<Eigen::StrictlyLower>() = m.data.M.transpose();
  const Eigen::VectorXd& bias = nonLinearEffects(m.model, m.data, q_ref, v_ref);  // bias
  forwardKinematics(m.model, m.data, q_ref, v_ref, zero);
  const Motion drift = getFrameClassicalAcceleration(m.model, m.data, m.tip, frame);  // drift
  updateFramePlacement(m.model, m.data, m.tip);
  getFrameJacobian(m.model, m.data, m.tip, frame, m.J);           // Jacobian
  const Eigen::LLT<Eigen::Matrix<double, 7, 7>> llt_M(m.data.M);  // one 7×7 Cholesky
  const Eigen::Matrix<double, 7, 6> Y = llt_M.matrixL().solve(m.J.transpose());
  const Eigen::Matrix<double, 6, 6> A = Y.transpose() * Y;  // J M⁻¹ Jᵀ
  const Eigen::LLT<Eigen::Matrix<double, 6, 6>> llt_A(A);   // one 6×6 Cholesky
  return llt_A.matrixLLT()(5, 5) + bias[0] + drift.linear()[0];
}

}  // namespace impedraw
