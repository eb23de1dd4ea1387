// What the law wants of one step: the motion to follow and the force that acts on M_d, B and K.
#include <algorithm>
#include <cmath>

#include "impedraw/control/impedance.h"

namespace impedraw {

namespace {

Vector6 stacked(const Eigen::Vector3d& linear, const Eigen::Vector3d& angular) {
  Vector6 x;
  x << linear, angular;
  return x;
}

}  // namespace

// Away from the surface: the pose of the plan, in full stiffness.
ImpedanceController::ReferenceMotion ImpedanceController::reference_on_plan(
    const ArmTerms& arm, const TipReference& reference) noexcept {
  ReferenceMotion w;
  Eigen::Vector3d p_WD = reference.p_WD;
  if (out_.mode == ContactMode::retreat) p_WD += settings_.retreat_height * reference.n_WD;
  out_.push = 0.0;
  out_.p_WD = p_WD;
  w.V_d = stacked(reference.v_WD, reference.w_WD);
  w.Vdot_d = stacked(reference.a_WD, reference.alpha_WD);
  const Vector6 e =
      stacked(p_WD - arm.X_WE.p, smallest_rotation(arm.X_WE.R.col(2), -reference.n_WD));
  pull(arm.V_WE, settings_.stiffness.apply(reference.n_WD, e), &w);
  w.push.setZero();
  return w;
}

// Approach and contact: along the tangents the plan as seen along the drawing axis, along the
// normal the estimated surface.
ImpedanceController::ReferenceMotion ImpedanceController::reference_on_surface(
    const ArmTerms& arm, const TipReference& reference, const SurfaceEstimate& surface) noexcept {
  const Eigen::Vector3d& n = tracker_.n();
  const Eigen::Vector3d& z = settings_.drawing_axis_W;
  const Eigen::Vector3d n_dot = tracker_.w().cross(n);
  const bool contact = out_.mode == ContactMode::contact;
  out_.push = contact ? settings_.normal_force : 0.0;

  // The ink lies under the centre of the tip sphere, E sinks with the tip's give: follow the plan
  // with the ink, not with E. The give is that of the push as it builds up, or the tip would be
  // asked aside while friction still holds it.
  const double acting_push =
      contact ? std::max(0.0, out_.push - n.dot(carried_force_.head<3>())) : 0.0;
  const double give = settings_.tip_stiffness > 0.0 ? acting_push / settings_.tip_stiffness : 0.0;
  const Eigen::Vector3d p_EC = give * n - settings_.tip_radius * (arm.X_WE.R.col(2) + n);
  out_.p_WD = reference.p_WD - p_EC;

  const double cosine = n.dot(z);
  const bool lifted = settings_.projection == ErrorProjection::lifted &&
                      std::abs(cosine) > settings_.min_axis_cosine;
  const Eigen::Vector3d e = out_.p_WD - arm.X_WE.p;
  const Eigen::Vector3d& u = reference.v_WD;
  Eigen::Vector3d e_t, v_t, a_t;
  if (lifted) {
    const double rise =
        n.dot(u) /
        // what the plan's own height changes is not followed: the surface is where it is found
        cosine;
    e_t = e - z * (n.dot(e) / cosine);
    v_t = u - z * rise;
    a_t = reference.a_WD -
          z * ((n_dot.dot(u) + n.dot(reference.a_WD) - rise * n_dot.dot(z)) / cosine);
  } else {
    const auto on_page = [&z](const Eigen::Vector3d& x) -> Eigen::Vector3d {
      return x - z * z.dot(x);
    };
    e_t = on_page(e);
    e_t -= n * n.dot(e_t);
    v_t = u - n * n.dot(u);
    a_t = reference.a_WD - n * n.dot(reference.a_WD);
  }

  TipGain K = settings_.stiffness;
  Eigen::Vector3d e_n = Eigen::Vector3d::Zero();
  if (contact) {
    K.linear.normal = 0.0;
  } else {
    // Whoever holds the tip back must not find a spring wound up when they let go.
    const bool held = surface.status == SurfaceStatus::ok &&
                      approach_distance_ < surface.distance - settings_.approach_lag;
    const bool reached_end = approach_distance_ <= -settings_.approach_overtravel;
    if (held)
      approach_distance_ = surface.distance - settings_.approach_lag;
    else if (!reached_end) {
      approach_distance_ -= settings_.approach_speed * settings_.dt;
      v_t -= lifted ? Eigen::Vector3d(z * (settings_.approach_speed / cosine))
                    : Eigen::Vector3d(n * settings_.approach_speed);
    }
    if (surface.status == SurfaceStatus::ok) e_n = n * (approach_distance_ - surface.distance);
  }
  ReferenceMotion w;
  w.V_d = stacked(v_t, tracker_.w());
  w.Vdot_d = stacked(a_t, reference.alpha_WD - n * n.dot(reference.alpha_WD));
  pull(arm.V_WE, K.apply(n, stacked(e_t + e_n, smallest_rotation(arm.X_WE.R.col(2), -n))), &w);
  w.push = stacked(-(out_.push + force_integral_) * n, Eigen::Vector3d::Zero());
  return w;
}

Vector6 ImpedanceController::damp(const Vector6& V) const noexcept {
  if (shaped_) return shaped_damping_.apply(out_.n_WD, V);
  return std::sqrt(scale_) *
         modal_damping_.apply(space_.inertia_factor(), V);  // C and Λ⁻¹ are 1/c of the natural ones
}

void ImpedanceController::pull(const Vector6& V, const Vector6& Ke,
                               ReferenceMotion* desired) noexcept {
  const double limit = settings_.tip_speed_limit;
  const double small_pull =
      2e-3 * settings_.stiffness.linear
                 .tangent;  // what can only be a fraction of any limit is not looked at
  const Vector6& V_d = desired->V_d;
  if (V_d.head<3>().squaredNorm() > 0.64 * limit * limit ||
      Ke.head<3>().squaredNorm() > small_pull * small_pull) {
    const Vector6 follow = shaped_
                               ? shaped_damping_.inverse().apply(out_.n_WD, Ke)
                               : Vector6(modal_damping_.solve(space_.inverse_inertia_factor(), Ke) /
                                         std::sqrt(scale_));
    Vector6 V_end = V_d + follow;
    const double speed = V_end.head<3>().norm();
    if (speed > limit) {
      out_.status.speed_limited = true;
      const Eigen::Vector3d direction = V_end.head<3>() / speed;
      V_end *=
          limit /
          speed;  // turning with it: a coupled inertia would make speed of what is left of that
      auto a = desired->Vdot_d.head<3>();
      a -= std::max(0.0, a.dot(direction)) *
           direction;  // the plan may go faster yet: the tip may not
      desired->force = damp(V_end - V);
      return;
    }
  }
  desired->force = damp(V_d - V) + Ke;
}

// What Coulomb friction at the tip explains of the wrench: along −v_t, up to μ̂ f_n.
Vector6 ImpedanceController::tip_friction(const ArmTerms& arm, const Wrench& F_ext) const noexcept {
  Vector6 friction = Vector6::Zero();
  if (out_.mode != ContactMode::contact || settings_.friction <= 0.0) return friction;
  const Eigen::Vector3d& n = out_.n_WD;
  const double f_n = std::max(0.0, n.dot(F_ext.head<3>()));
  const Eigen::Vector3d v = arm.V_WE.head<3>();
  const Eigen::Vector3d v_t = v - n * n.dot(v);
  const Eigen::Vector3d slip =
      v_t / std::sqrt(v_t.squaredNorm() + settings_.friction_speed * settings_.friction_speed);
  const double against_slip = -F_ext.head<3>().dot(slip);
  friction.head<3>() = -std::clamp(against_slip, 0.0, settings_.friction * f_n) * slip;
  return friction;
}

void ImpedanceController::update_force_integral(const Wrench& F_ext) noexcept {
  const ForceIntegralSettings& s = settings_.force_integral;
  if (!s.enabled || !measured_) return;
  if (out_.mode != ContactMode::contact) {
    force_integral_ = 0.0;  // the hand-over at the switch makes it fade
    return;
  }
  const Eigen::Vector3d& n = tracker_.n();
  const double asked =
      settings_.normal_force -
      n.dot(carried_force_.head<3>());  // while the push builds up, no more than it is
  force_integral_ =
      std::clamp(force_integral_ + s.rate * settings_.dt * (asked - n.dot(F_ext.head<3>())),
                 -s.limit, s.limit);
}

JointVector ImpedanceController::limit_repulsion(const JointVector& q) noexcept {
  JointVector tau = JointVector::Zero(q.size());
  for (int j = 0; j < lower_.size(); ++j) {
    const double above = settings_.limit_margin - (q[j] - lower_[j]),
                 below = settings_.limit_margin - (upper_[j] - q[j]);
    if (above <= 0.0 && below <= 0.0) continue;
    out_.status.joint_limit = true;
    const double into = std::max(above, below) / settings_.limit_margin;
    tau[j] = (above > below ? 1.0 : -1.0) * settings_.limit_torque * into * into;
  }
  return tau;
}

}  // namespace impedraw
