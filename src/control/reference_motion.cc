// Reference motion of one step: V_d, V̇_d, K e and F_push of the law in impedance.h.
#include <algorithm>
#include <cmath>

#include "impedraw/control/impedance.h"

namespace impedraw {

namespace {

using Eigen::Vector3d;

Vector6 stacked(const Vector3d& linear, const Vector3d& angular) {
  Vector6 x;
  x << linear, angular;
  return x;
}

// Error, velocity and acceleration of the plan in the tangent plane.
struct TangentMotion {
  Vector3d e, v, a;
};

// Of a point that rests in the carrier.
struct CarrierMotion {
  Vector3d v = Vector3d::Zero(), a = Vector3d::Zero();
};

CarrierMotion carrier_motion(const FrameMotion& carrier, const Vector3d& p_W) {
  const Vector3d r = p_W - carrier.X_WK.p;
  return {carrier.v + carrier.w.cross(r),
          carrier.a + carrier.alpha.cross(r) + carrier.w.cross(carrier.w.cross(r))};
}

Vector3d across(const Vector3d& n, const Vector3d& x) { return x - n * n.dot(x); }

// Projection along z, with full stiffness on any slope: x − z (n·x)/(n·z) and its derivatives. The
// plan's own height is ignored, because perception gives the surface. On a surface along z there is
// no such height: below |n·z| = least, (n·z)/least² takes the quotient's place, and the plan's own
// height returns. A pen that slips over an edge is pulled up again.
TangentMotion lifted(const Vector3d& e, const Vector3d& v, const Vector3d& a, const Vector3d& n,
                     const Vector3d& n_dot, const Vector3d& z, double least) {
  const double cosine = n.dot(z);
  const bool steep = std::abs(cosine) < least;
  const double share = steep ? cosine / (least * least) : 1.0 / cosine;
  const double rise = n.dot(v) * share;
  const TangentMotion motion{e - z * (n.dot(e) * share), v - z * rise,
                             a - z * ((n_dot.dot(v) + n.dot(a) - rise * n_dot.dot(z)) * share)};
  if (!steep) return motion;
  return {across(n, motion.e), across(n, motion.v), across(n, motion.a)};
}

// (13): (z × e) × z, then its component in the tangent plane.
TangentMotion projected(const Vector3d& e, const Vector3d& v, const Vector3d& a, const Vector3d& n,
                        const Vector3d& z) {
  const Vector3d e_page = e - z * z.dot(e);
  return {across(n, e_page), across(n, v), across(n, a)};
}

}  // namespace

// Away from the surface: follows the pose of the plan with full stiffness.
ImpedanceController::ReferenceMotion ImpedanceController::reference_on_plan(
    const ArmTerms& arm, const TipReference& reference) noexcept {
  Vector3d p_WD = reference.p_WD;
  if (out_.mode == ContactMode::retreat) p_WD += settings_.approach.retreat_height * reference.n_WD;
  out_.push = 0.0;
  out_.p_WD = p_WD;
  out_.axis_WD = reference.n_WD;
  const Vector6 e =
      stacked(p_WD - arm.X_WE.p, smallest_rotation(arm.X_WE.R.col(2), -reference.n_WD));
  ReferenceMotion desired;
  desired.V_d = stacked(reference.v_WD, reference.w_WD);
  desired.Vdot_d = stacked(reference.a_WD, reference.alpha_WD);
  desired.Ke = settings_.stiffness.apply(reference.n_WD, e);
  desired.push.setZero();
  return desired;
}

// Approach and contact: follows the plan, projected along the drawing axis, in the tangent plane,
// and the estimated surface along the normal.
ImpedanceController::ReferenceMotion ImpedanceController::reference_on_surface(
    const ArmTerms& arm, const TipReference& reference, const SurfaceEstimate& surface) noexcept {
  const Vector3d& n = out_.n_WD;
  const bool planned_axis = settings_.surface.pen_axis == PenAxis::plan;
  const Vector3d& w = planned_axis ? reference.w_WD : tracker_.w();
  out_.axis_WD = planned_axis ? reference.n_WD : tracker_.n();
  // The plan's motion relative to the carrier is projected, in axes that turn with it.
  const Vector3d z = carrier_ ? Vector3d(carrier_->X_WK.R * settings_.surface.drawing_axis_W)
                              : settings_.surface.drawing_axis_W;
  Vector3d v_D = reference.v_WD, a_D = reference.a_WD, n_turn = tracker_.w();
  CarrierMotion carried;
  if (carrier_) {
    carried = carrier_motion(*carrier_, reference.p_WD);
    v_D -= carried.v;
    a_D -= carried.a + 2.0 * carrier_->w.cross(v_D);
    n_turn -= carrier_->w;
  }
  const bool contact = out_.mode == ContactMode::contact;
  out_.push = contact ? settings_.normal_force : 0.0;

  // The ink, not E, follows the plan. It lies under the centre C of the tip sphere, and E sinks as
  // the tip is compressed. The compression uses the push as it builds up. The full push would
  // command a lateral shift while friction still holds the tip.
  const double acting_push =
      contact ? std::max(0.0, out_.push - n.dot(carried_force_.head<3>())) : 0.0;
  const double give = settings_.tip.stiffness > 0.0 ? acting_push / settings_.tip.stiffness : 0.0;
  const Vector3d p_EC = give * n_C_ - settings_.tip.radius * (arm.X_WE.R.col(2) + n_C_);
  out_.p_WD = reference.p_WD - p_EC;

  const double cosine = n.dot(z), least = settings_.surface.min_axis_cosine;
  const bool lift = settings_.surface.projection == ErrorProjection::lifted;
  const Vector3d e = out_.p_WD - arm.X_WE.p;
  TangentMotion tangent =
      lift ? lifted(e, v_D, a_D, n, n_turn.cross(n), z, least) : projected(e, v_D, a_D, n, z);
  if (carrier_) {
    tangent.a += carried.a + 2.0 * carrier_->w.cross(tangent.v);
    tangent.v += carried.v + rise_ * n;
  }

  TipGain K = settings_.stiffness;
  Vector3d e_n = Vector3d::Zero();
  if (contact) {
    K.linear.normal = 0.0;
  } else {
    const ApproachSettings& approach = settings_.approach;
    const bool known = surface.status == SurfaceStatus::ok;
    // Someone who holds the tip back must not release a wound-up spring.
    const bool held = known && approach_distance_ < surface.distance - approach.lag;
    if (held) {
      approach_distance_ = surface.distance - approach.lag;
    } else if (approach_distance_ > -approach.overtravel) {
      approach_distance_ -= approach.speed * settings_.timing.dt;
      tangent.v -= lift && std::abs(cosine) > least ? Vector3d(z * (approach.speed / cosine))
                                                    : Vector3d(n * approach.speed);
    }
    if (known) e_n = n * (approach_distance_ - surface.distance);
  }
  ReferenceMotion desired;
  const Vector3d& axis = out_.axis_WD;
  desired.V_d = stacked(tangent.v, w);
  desired.Vdot_d = stacked(tangent.a, reference.alpha_WD - axis * axis.dot(reference.alpha_WD));
  desired.Ke = K.apply(n, stacked(tangent.e + e_n, smallest_rotation(arm.X_WE.R.col(2), -axis)));
  desired.push = stacked(-(out_.push * n.dot(n_C_) + force_integral_) * n, Vector3d::Zero());
  return desired;
}

}  // namespace impedraw
