#include "impedraw/simulation/pad_contact.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace impedraw {

// Ring j has 6 j cells between the radii r √((3 j² ∓ 3 j + 1)/N), at the radius of gyration between
// them, so that the moments of inertia are those of the disc.
PadContact::PadContact(const PadSettings& settings) : settings_(settings) {
  if (settings.face != PadFace::disc) {
    const bool edge = settings.face == PadFace::edge;
    for (std::size_t i = 0; i < kCells; ++i) {
      const double at = settings.radius * (2.0 * (static_cast<double>(i) + 0.5) / kCells - 1.0);
      cells_[i] = Eigen::Vector2d(edge ? at : 0.0, edge ? 0.0 : at);
      cells_[i].x() -= settings.trail;
    }
    reset();
    return;
  }
  std::size_t cell = 0;
  cells_[cell++] = Eigen::Vector2d::Zero();
  for (int j = 1; j <= kRings; ++j) {
    const double inner2 = 3.0 * j * j - 3.0 * j + 1.0, outer2 = 3.0 * j * j + 3.0 * j + 1.0;
    const double radius = settings.radius * std::sqrt(0.5 * (inner2 + outer2) / kCells);
    for (int i = 0; i < 6 * j; ++i) {
      const double angle = 2.0 * std::numbers::pi * (i + 0.5 * (j % 2)) / (6 * j);
      cells_[cell++] = radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
  }
  reset();
}

void PadContact::reset() noexcept {
  pressure_.fill(0.0);
  shear_.fill(Eigen::Vector3d::Zero());
  tilt_.setZero();
  rate_.setZero();
  load_ = {};
}

const PadLoad& PadContact::press(const Canvas& canvas, const Pose& X_KE, const Vector6& V_KE,
                                 double dt) noexcept {
  if (settings_.joints == 0) {
    press_face(canvas, X_KE, V_KE, dt);
    return load_;
  }
  const Eigen::Vector3d centre_E(0.0, 0.0, -settings_.lever()), turn(tilt_.x(), tilt_.y(), 0.0),
      w_rel = X_KE.R * Eigen::Vector3d(rate_.x(), rate_.y(), 0.0);
  const double angle = turn.norm();
  const Eigen::Matrix3d R_ED = angle > 0.0
                                   ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix()
                                   : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  const Pose X_KD = X_KE * Pose{centre_E - R_ED * centre_E, R_ED};
  const Eigen::Vector3d centre = X_KE * centre_E;
  Vector6 V_KD;
  V_KD << V_KE.head<3>() + V_KE.tail<3>().cross(X_KD.p - X_KE.p) + w_rel.cross(X_KD.p - centre),
      V_KE.tail<3>() + w_rel;
  press_face(canvas, X_KD, V_KD, dt);
  const double inertia = 0.25 * std::numbers::pi * std::pow(settings_.radius, 4),
               damping = load_.touching ? inertia * settings_.damping : 0.0,
               gives = kJointDamping + damping + dt * inertia * settings_.stiffness;
  Eigen::Vector3d moment =
      X_KE.R.transpose() * (load_.m + (X_KD.p - centre).cross(load_.f));  // about the centre, in E
  for (int i = 0; i < settings_.joints; ++i) {
    const double next = tilt_[i] + dt * (moment[i] + damping * rate_[i]) / gives;
    rate_[i] = (std::clamp(next, -kJointEnd, kJointEnd) - tilt_[i]) / dt;
    tilt_[i] = std::clamp(next, -kJointEnd, kJointEnd);
    if (std::abs(next) <= kJointEnd) moment[i] = kJointDamping * rate_[i];
  }
  load_.m = X_KE.R * moment + (centre - X_KE.p).cross(load_.f);
  return load_;
}

void PadContact::press_face(const Canvas& canvas, const Pose& X_KE, const Vector6& V_KE,
                            double dt) noexcept {
  load_ = {};
  const double reach = settings_.rest + settings_.radius + settings_.trail;
  if (!canvas.closest(X_KE.p, reach + settings_.thickness)) {
    pressure_.fill(0.0);
    shear_.fill(Eigen::Vector3d::Zero());
    return;
  }
  const Eigen::Vector3d z = X_KE.R.col(2), v = V_KE.head<3>(), w = V_KE.tail<3>();
  const bool flat = settings_.face == PadFace::disc;
  const double area = settings_.area() / kCells,
               shear_stiffness = (flat ? 0.5 : kLineShear) * settings_.stiffness;
  Eigen::Vector3d normals = Eigen::Vector3d::Zero(), centres = Eigen::Vector3d::Zero();
  double sum = 0.0;
  for (std::size_t i = 0; i < kCells; ++i) {
    const Eigen::Vector3d disc(cells_[i].x(), cells_[i].y(), settings_.rest - settings_.thickness);
    auto hit = canvas.ray(X_KE * disc, z);
    double compression = hit ? settings_.thickness - hit->t : -1.0;
    if (flat && compression <= 0.0) {
      hit = canvas.ray(X_KE * disc - settings_.thickness * z, z);
      const bool behind = hit && hit->t < settings_.thickness && hit->n_W.dot(z) < 0.0;
      if (behind) compression = 2.0 * settings_.thickness - hit->t;
    }
    if (compression <= 0.0) {
      pressure_[i] = 0.0;
      shear_[i].setZero();
      continue;
    }
    // Either side of an open sheet bears the pad.
    const Eigen::Vector3d n = hit->n_W.dot(z) < 0.0 ? hit->n_W : Eigen::Vector3d(-hit->n_W);
    const Eigen::Vector3d arm = hit->p_W - X_KE.p, v_i = v + w.cross(arm);
    const double p = settings_.pressure(compression, -n.dot(v_i));
    pressure_[i] = p;
    Eigen::Vector3d& s = shear_[i];
    s += dt * v_i;
    s -= n * n.dot(s);
    const double most = settings_.friction * p / shear_stiffness, size = s.norm();
    if (!flat) {
      const double across = settings_.friction_across * p / shear_stiffness;
      const Eigen::Vector3d x = X_KE.R.col(0), a = (x - n * n.dot(x)).normalized(), b = n.cross(a);
      s = std::clamp(a.dot(s), -most, most) * a + std::clamp(b.dot(s), -across, across) * b;
    } else if (size > most) {
      s *= most / size;
    }
    const Eigen::Vector3d f = area * (p * n - shear_stiffness * s);
    load_.f += f;
    load_.m += arm.cross(f);
    normals += p * n;
    centres += p * hit->p_W;
    sum += p;
  }
  load_.touching = sum > 0.0;
  if (load_.touching) {
    load_.n = normals.normalized();
    load_.centre = centres / sum;
  }
}

}  // namespace impedraw
