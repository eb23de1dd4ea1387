// Contact of what the arm holds with a canvas that may move: the one seam between the world and its
// tools. At most one is set; without one the ball of the tip touches alone.
//
//   face    (pad_contact.h) a pad or an edge. Takes the ball's place: press() gives its wrench.
//   cutter  (cutter_contact.h) makes the ball's nearest place a cut: engage() gives what that place
//           is like, and a force across the way, which acts in the next step.
//
// Both laws are in the canvas's frame K; here all is in W.
#pragma once

#include <optional>

#include "impedraw/simulation/canvas_motion.h"
#include "impedraw/simulation/cutter_contact.h"
#include "impedraw/simulation/pad_contact.h"

namespace impedraw {

class ToolContact {
 public:
  // `canvas` may be null, and must outlive this.
  ToolContact(const WorldSettings& settings, const Canvas* canvas) : canvas_(canvas) {
    if (canvas && settings.pad) face_.emplace(*settings.pad);
    if (settings.cutter) cutter_.emplace(*settings.cutter);
  }

  bool has_face() const noexcept { return face_.has_value(); }
  bool has_cutter() const noexcept { return cutter_.has_value(); }
  void reset() noexcept {
    if (face_) face_->reset();
    side_W_.setZero();
  }

  // The load on the face, whose frame is E, at the start of a step of dt; the canvas is there and
  // moves so. Moment about E. Nothing touches without a face.
  const PadLoad& press(const CanvasMotion::State& canvas, const Pose& X_WE, const Vector6& V_WE,
                       double dt) noexcept {
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

  const PadLoad& load() const noexcept { return load_; }  // of the last press()

  // The cut at the ball's nearest place C, whose velocity relative to the canvas is v_C, in C.
  void engage(const Pose& X_KW, const Pose& X_WC, const Eigen::Vector3d& v_C, double depth,
              double dt, TipMaterial* tip) noexcept {
    const Eigen::Matrix3d R_KC = X_KW.R * X_WC.R;
    Eigen::Vector3d side_K = Eigen::Vector3d::Zero();
    cutter_->engage(X_KW * X_WC.p, R_KC.col(2), R_KC * v_C, depth, dt, tip, &side_K);
    side_W_ = X_KW.R.transpose() * side_K;
  }
  void release() noexcept {
    if (cutter_) cutter_->release();
    side_W_.setZero();
  }  // the cutter touches nothing
  // Across the cutter's way, at E [N].
  const Eigen::Vector3d& side_W() const noexcept { return side_W_; }

 private:
  const Canvas* canvas_;
  std::optional<PadContact> face_;
  std::optional<CutterContact> cutter_;
  PadLoad load_;
  Eigen::Vector3d side_W_ = Eigen::Vector3d::Zero();
};

}  // namespace impedraw
