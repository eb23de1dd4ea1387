#include "impedraw/control/tip_target.h"

#include <cmath>

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

TipTarget target_on_plan(const StepInput& in, const Contact& contact,
                         const ImpedanceSettings& settings) noexcept {
  const TipReference& plan = in.reference;
  TipTarget d;
  d.p_WD = plan.p_WD;
  if (contact.mode == ContactMode::retreat) d.p_WD += settings.approach.retreat_height * plan.n_WD;
  d.axis_WD = plan.n_WD;
  d.V = stacked(plan.v_WD + contact.rise * contact.n, plan.w_WD);
  d.Vdot = stacked(plan.a_WD, plan.alpha_WD);
  d.Ke = settings.stiffness.apply(
      plan.n_WD,
      stacked(d.p_WD - in.arm.X_WE.p, smallest_rotation(in.arm.X_WE.R.col(2), -plan.n_WD)));
  return d;
}

TipTarget target_on_surface(const StepInput& in, const Contact& contact, double push,
                            const ImpedanceSettings& settings) noexcept {
  const TipReference& plan = in.reference;
  const FrameMotion* const carrier = in.carrier;
  const Vector3d n = contact.n, z_E = in.arm.X_WE.R.col(2);
  TipTarget d;

  // The plan's motion on the carrier
  const Vector3d z = carrier ? Vector3d(carrier->X_WK.R * settings.surface.drawing_axis_W)
                             : settings.surface.drawing_axis_W;
  Vector3d v_D = plan.v_WD, a_D = plan.a_WD, n_turn = contact.w_T;
  Vector3d v_K = Vector3d::Zero(), a_K = Vector3d::Zero();
  if (carrier) {
    v_K = carrier->velocity_at(plan.p_WD);
    a_K = carrier->acceleration_at(plan.p_WD);
    v_D -= v_K;
    a_D -= a_K + 2.0 * carrier->w.cross(v_D);
    n_turn -= carrier->w;
  }

  // Seen along z, for the ink
  const double give = settings.tip.stiffness > 0.0 ? push / settings.tip.stiffness : 0.0;
  const Vector3d p_EC = give * contact.n_C - settings.tip.radius * (z_E + contact.n_C);
  d.p_WD = plan.p_WD - p_EC;
  const Vector3d e = d.p_WD - in.arm.X_WE.p;
  const double least = settings.surface.min_axis_cosine;
  const bool lift = settings.surface.projection == ErrorProjection::lifted;
  TangentMotion tangent =
      lift ? lifted(e, v_D, a_D, n, n_turn.cross(n), z, least) : projected(e, v_D, a_D, n, z);
  if (carrier) {
    tangent.a += a_K + 2.0 * carrier->w.cross(tangent.v);
    tangent.v += v_K + contact.rise * n;
  }

  // Along the normal
  TipGain K = settings.stiffness;
  if (contact.mode == ContactMode::contact) {
    K.linear.normal = 0.0;
    // A swelling force goes deeper; the damping must not hold it back.
    if (contact.force_rate != 0.0 && settings.tip.stiffness > 0.0)
      tangent.v -= n * (contact.force_rate / settings.tip.stiffness);
  } else {
    const double cosine = n.dot(z);
    tangent.v -= lift && std::abs(cosine) > least ? Vector3d(z * (contact.sinking / cosine))
                                                  : Vector3d(n * contact.sinking);
    tangent.e += n * contact.off_target;
  }

  const bool planned_axis = settings.surface.pen_axis == PenAxis::plan;
  d.axis_WD = planned_axis ? plan.n_WD : contact.n_T;
  d.V = stacked(tangent.v, planned_axis ? plan.w_WD : contact.w_T);
  d.Vdot = stacked(tangent.a, across(d.axis_WD, plan.alpha_WD));
  d.Ke = K.apply(n, stacked(tangent.e, smallest_rotation(z_E, -d.axis_WD)));
  return d;
}

}  // namespace impedraw
