#include "impedraw/simulation/tool_contact.h"

namespace impedraw {

ToolContact::ToolContact(const WorldSettings& settings, const Canvas* canvas) : canvas_(canvas) {
  if (canvas && settings.pad) face_.emplace(*settings.pad);
  if (settings.cutter) cutter_.emplace(*settings.cutter);
}

void ToolContact::reset() noexcept {
  if (face_) face_->reset();
  side_W_.setZero();
}

const PadLoad& ToolContact::press(const CanvasMotion::State& canvas, const Pose& X_WE,
                                  const Vector6& V_WE, double dt) noexcept {
  load_ = {};
  if (!face_) return load_;
  const Pose X_KW = canvas.X_WK.inverse();
  Vector6 V_KE;
  V_KE << X_KW.R * (V_WE.head<3>() - canvas.velocity_at(X_WE.p)),
      X_KW.R * (V_WE.tail<3>() - canvas.w);
  const PadLoad& in_K = face_->press(*canvas_, X_KW * X_WE, V_KE, dt);
  if (!in_K.touching) return load_;
  const Eigen::Matrix3d& R = canvas.X_WK.R;
  load_ = {true, R * in_K.f, R * in_K.m, R * in_K.n, canvas.X_WK * in_K.centre};
  return load_;
}

void ToolContact::engage(const Pose& X_KW, const Pose& X_WC, const Eigen::Vector3d& v_C,
                         double depth, double dt, TipMaterial* tip) noexcept {
  const Eigen::Matrix3d R_KC = X_KW.R * X_WC.R;
  Eigen::Vector3d side_K = Eigen::Vector3d::Zero();
  cutter_->engage(X_KW * X_WC.p, R_KC.col(2), R_KC * v_C, depth, dt, tip, &side_K);
  side_W_ = X_KW.R.transpose() * side_K;
}

void ToolContact::release() noexcept {
  if (cutter_) cutter_->release();
  side_W_.setZero();
}

}  // namespace impedraw
