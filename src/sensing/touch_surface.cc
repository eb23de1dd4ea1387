#include "impedraw/sensing/touch_surface.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/sensing/describe_touch.h"

namespace impedraw {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

void check(const TouchSettings& s, const TouchModel& m) {
  require_ranges("blind.touch", s);
  if (!(m.dt > 0.0) || !(std::abs(m.drawing_axis_W.norm() - 1.0) < 1e-6) ||
      !(m.tip_radius >= 0.0) || !(m.tip_stiffness >= 0.0) || !(m.friction >= 0.0) ||
      !(m.touch_force >= 0.0))
    throw InputError(
        "touch: the step must be above 0 s, the drawing axis of unit length, and radius, "
        "stiffness, friction and touch force at least 0");
}

// A right-handed frame with the given z, x as near as possible to W's x.
Matrix3d frame_of(const Vector3d& z) {
  Matrix3d R;
  const Vector3d reference =
      std::abs(z.x()) < 0.9 ? Vector3d(Vector3d::UnitX()) : Vector3d(Vector3d::UnitY());
  R.col(2) = z.normalized();
  R.col(0) = (reference - z * z.dot(reference)).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return R;
}

}  // namespace

TouchSurface::TouchSurface(const TouchSettings& settings, const TouchModel& model)
    : s_(settings), m_(model) {
  check(settings, model);
  R_ = frame_of(model.drawing_axis_W);
  n_ = R_.col(2);
  estimate_.n_W = n_;
}

const SurfaceEstimate& TouchSurface::update(const Pose& X_WE, const Vector6& V_WE,
                                            const Vector3d& f_W, bool pen_down) noexcept {
  // All in the axes of the drawing plane from here.
  const Vector3d to_centre_W = -m_.tip_radius * X_WE.R.col(2);
  const Vector3d v_W = V_WE.head<3>(), w_W = V_WE.tail<3>();
  Vector3d c = R_.transpose() * (X_WE.p + to_centre_W);
  const Vector3d v = R_.transpose() * (v_W + w_W.cross(to_centre_W));
  const Vector3d f = f_W.allFinite() ? Vector3d(R_.transpose() * f_W) : Vector3d(Vector3d::Zero());
  if (!c.allFinite() || !v.allFinite()) return estimate_;

  if (pen_down && !down_) begin(c);
  down_ = pen_down;
  p_WE_ = X_WE.p;
  touching_ = pen_down && f.norm() >= m_.touch_force;
  if (touching_) {
    // The centre of a tip that is not compressed.
    const Vector3d n = normal(slope());
    if (m_.tip_stiffness > 0.0) c += n * (std::max(0.0, n.dot(f)) / m_.tip_stiffness);
    learn(c, v, f);
  }

  turn_to(R_ * normal(slope()));
  const Vector3d n = R_.transpose() * n_;
  const double distance = n.z() * (c.z() - height_at(c));
  estimate_.status = touched_ && !touching_ && pen_down && distance < -s_.search
                         ? SurfaceStatus::off_edge
                         : SurfaceStatus::ok;
  estimate_.n_W = n_;
  estimate_.distance = distance;
  return estimate_;
}

SurfaceEstimate TouchSurface::estimate_at(const Vector3d& p_W) const noexcept {
  SurfaceEstimate there = estimate_;
  if (!touched_) return there;
  const Vector3d n = R_.transpose() * n_, d = R_.transpose() * (p_W - p_WE_);
  const Vector2d g = -n.head<2>() / n.z() + curvature() * d.head<2>();
  there.n_W = R_ * normal(g);
  return there;
}

// The reported normal turns no faster than the pen can, and takes up speed and slows down.
void TouchSurface::turn_to(const Vector3d& n_W) noexcept {
  constexpr double kTurnTime = 0.1;  // to `turn_rate` [s]
  const Vector3d across = n_.cross(n_W);
  const double angle = std::atan2(across.norm(), n_.dot(n_W));
  const double acceleration = s_.turn_rate / kTurnTime;
  turning_ = std::min(
      {s_.turn_rate, turning_ + acceleration * m_.dt, std::sqrt(2.0 * acceleration * angle)});
  if (!touched_ || angle <= turning_ * m_.dt || angle < 1e-12) {
    n_ = n_W;
    turning_ = touched_ ? angle / m_.dt : 0.0;
    return;
  }
  n_ = (Eigen::AngleAxisd(turning_ * m_.dt, across.normalized()) * n_).normalized();
}

// The level plane through the tip, until something is touched.
void TouchSurface::begin(const Vector3d& c) noexcept {
  touched_ = stood_ = false;
  since_touch_ = turning_ = 0.0;
  x_.setZero();
  x_[0] = c.z();
  at_ = c.head<2>();
  P_.setZero();
  P_.diagonal() << 1.0, Vector2d::Constant(s_.slope * s_.slope),
      Vector3d::Constant(s_.curvature * s_.curvature);
}

void TouchSurface::learn(const Vector3d& c, const Vector3d& v, const Vector3d& f) noexcept {
  if (!touched_) begin(c);  // here is the surface
  const bool first = !touched_;
  touched_ = true;
  since_touch_ += m_.dt;

  if (!first && (c.head<2>() - at_).norm() < s_.spacing) {
    if (stood_ || since_touch_ < s_.settle_time || f.z() <= 0.0) return;
    stood_ = true;
    const double variance =
        std::max(m_.friction * m_.friction / 3.0, s_.force_noise * s_.force_noise);
    for (int i = 0; i < 2; ++i) correct(Vector6::Unit(1 + i), -f[i] / f.z() - x_[1 + i], variance);
    return;
  }
  if (!first) move_to(c);
  correct(Vector6::Unit(0), c.z() - x_[0], s_.position_noise * s_.position_noise);

  const double speed = v.head<2>().norm();
  if (speed < s_.slip_speed) return;
  const Vector2d d = v.head<2>() / speed, u(-d.y(), d.x());
  const Vector3d t = Vector3d(d.x(), d.y(), slope().dot(d)).normalized();
  const double f_z = f.z() - t.z() * t.dot(f);
  if (f_z < 0.5 * m_.touch_force) return;
  const Vector6 row = (Vector6() << 0.0, u, Vector3d::Zero()).finished();
  correct(row, -f.head<2>().dot(u) / f_z - slope().dot(u), s_.force_noise * s_.force_noise);
}

// Carries state and covariance on to the place of c.
void TouchSurface::move_to(const Vector3d& c) noexcept {
  const Vector2d d = c.head<2>() - at_;
  Matrix6 A = Matrix6::Identity();
  A.row(0) << 1.0, d.x(), d.y(), 0.5 * d.x() * d.x(), d.x() * d.y(), 0.5 * d.y() * d.y();
  A.row(1).tail<3>() << d.x(), d.y(), 0.0;
  A.row(2).tail<3>() << 0.0, d.x(), d.y();
  const double kept = std::exp(-d.norm() / s_.curvature_length);
  A.bottomRightCorner<3, 3>() *= kept;
  x_ = A * x_;
  P_ = A * P_ * A.transpose();
  P_.diagonal().tail<3>().array() += s_.curvature * s_.curvature * (1.0 - kept * kept);
  at_ = c.head<2>();
}

void TouchSurface::correct(const Vector6& row, double innovation, double variance) noexcept {
  const Vector6 P_row = P_ * row;
  const double total = row.dot(P_row) + variance;
  x_ += P_row * (innovation / total);
  P_ -= P_row * P_row.transpose() / total;
  P_ = 0.5 * (P_ + P_.transpose()).eval();
}

Vector3d TouchSurface::normal(const Vector2d& slope) const noexcept {
  return Vector3d(-slope.x(), -slope.y(), 1.0).normalized();
}

double TouchSurface::height_at(const Vector3d& c) const noexcept {
  const Vector2d d = c.head<2>() - at_;
  return x_[0] + slope().dot(d) + 0.5 * d.dot(curvature() * d);
}

Eigen::Matrix2d TouchSurface::curvature() const {
  Eigen::Matrix2d H;
  H << x_[3], x_[4], x_[4], x_[5];
  return H;
}

}  // namespace impedraw
