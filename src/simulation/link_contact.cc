#include "impedraw/simulation/link_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr double kAhead = 0.05;  // search beyond the body's radius [m]
constexpr double kLonger = 1.1;  // a simulated arm may be longer than the model's shapes

}  // namespace

LinkContact::LinkContact(const mjModel* shape, const Canvas* canvas)
    : canvas_(canvas), q_(Eigen::VectorXd::Zero(shape->nq)) {
  for (int g = 0; g < shape->ngeom; ++g) {
    const int type = shape->geom_type[g];
    Body body;
    body.id = shape->geom_bodyid[g];
    const bool fixed = shape->body_weldid[body.id] == 0;
    if (fixed || (type != mjGEOM_CYLINDER && type != mjGEOM_CAPSULE && type != mjGEOM_SPHERE))
      continue;
    const Vector3d middle(Eigen::Map<const Eigen::Matrix<mjtNum, 3, 1>>(shape->geom_pos + 3 * g));
    const mjtNum* wxyz = shape->geom_quat + 4 * g;
    const Vector3d along =
        Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized() * Vector3d::UnitZ();
    body.radius = shape->geom_size[3 * g];
    const double half = type == mjGEOM_SPHERE ? 0.0 : shape->geom_size[3 * g + 1];
    body.flat = type == mjGEOM_CYLINDER;
    body.a = middle - half * along;
    body.b = middle + half * along;
    body.link = mj_id2name(shape, mjOBJ_BODY, body.id);
    const bool known = std::any_of(bodies_.begin(), bodies_.end(), [&](const Body& other) {
      return other.id == body.id && other.a == body.a && other.b == body.b &&
             other.radius == body.radius && other.flat == body.flat;
    });  // a URDF may list a body as visual and as collision
    if (!known) bodies_.push_back(body);
    length_ = std::max({length_, body.a.norm(), body.b.norm()});
  }
  for (int i = 0; i < shape->nbody; ++i)
    length_ += Eigen::Map<const Eigen::Matrix<mjtNum, 3, 1>>(shape->body_pos + 3 * i).norm();
  for (int j = 0; j < shape->njnt; ++j)  // no bound on what slides
    if (shape->jnt_type[j] != mjJNT_HINGE) length_ = std::numeric_limits<double>::infinity();
  length_ *= kLonger;
  reset();
}

void LinkContact::reset() noexcept {
  link_.clear();
  for (Body& body : bodies_) {
    body.a_K = body.b_K = Vector3d::Zero();
    body.free = -1.0;
    body.due = 0.0;
  }
  way_ = 0.0;
}

void LinkContact::update(const mjData* data, const Pose& X_KW) noexcept {
  if (!canvas_ || !link_.empty()) return;
  const Eigen::Map<const Eigen::VectorXd> q(data->qpos, q_.size());
  const bool stands = X_KW.p == X_KW_.p && X_KW.R == X_KW_.R;
  way_ += stands ? length_ * (q - q_).lpNorm<1>() : std::numeric_limits<double>::infinity();
  q_ = q;
  X_KW_ = X_KW;
  for (Body& body : bodies_) {
    if (way_ < body.due) continue;
    const Eigen::Map<const Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>> R_WL(data->xmat +
                                                                              9 * body.id);
    const Eigen::Map<const Eigen::Matrix<mjtNum, 3, 1>> p_WL(data->xpos + 3 * body.id);
    const Vector3d a_K = X_KW * (p_WL + R_WL * body.a), b_K = X_KW * (p_WL + R_WL * body.b);
    if (!a_K.allFinite() || !b_K.allFinite()) return;
    // No point of the axis moves further than the end that moves most.
    const double moved2 = std::max((a_K - body.a_K).squaredNorm(), (b_K - body.b_K).squaredNorm());
    if (body.free > 0.0 && moved2 < body.free * body.free) {
      body.due = way_ + body.free - std::sqrt(moved2);
      continue;
    }
    body.a_K = a_K;
    body.b_K = b_K;
    if (touches(body, a_K, b_K, &body.free)) {
      link_ = body.link;
      return;
    }
    body.due = way_ + body.free;
  }
}

// free: how far the axis is from having the canvas within the radius.
bool LinkContact::touches(const Body& body, const Vector3d& a_K, const Vector3d& b_K,
                          double* free) const noexcept {
  const double length = (b_K - a_K).norm();
  const Vector3d along = length > 0.0 ? Vector3d((b_K - a_K) / length) : Vector3d::UnitZ();
  const auto inside = [&](const Vector3d& q) {
    const double s = (q - a_K).dot(along);
    if (body.flat) return s >= 0.0 && s <= length && (q - a_K - s * along).norm() <= body.radius;
    return (q - a_K - std::clamp(s, 0.0, length) * along).norm() <= body.radius;
  };
  // Intervals of the axis whose middle is far enough are done; the others are halved. The stack
  // holds one interval of each length.
  struct Interval {
    double begin, end, nearest;  // nearest: its middle is at most so far from the canvas [m]
  };
  Interval open[48];
  int n = 0;
  open[n++] = {0.0, length, std::numeric_limits<double>::infinity()};
  *free = kAhead;
  while (n > 0) {
    const Interval at = open[--n];
    const double half = 0.5 * (at.end - at.begin), middle = at.begin + half;
    const Vector3d p = a_K + middle * along;
    const auto closest = canvas_->closest(p, std::min(body.radius + half + kAhead, at.nearest));
    if (!closest) continue;  // further away than kAhead everywhere
    if (inside(closest->p_W)) return true;
    const double gap = std::abs(closest->distance) - body.radius;
    // With a margin of half the gap, so that `free` lasts.
    if (half <= 0.5 * gap || half <= 0.5 * kAxisStep || n + 2 > 48) {
      *free = std::min(*free, gap - half);
      continue;
    }
    const double nearest = std::abs(closest->distance) + 0.5 * half + 1e-9;
    open[n++] = {at.begin, middle, nearest};
    open[n++] = {middle, at.end, nearest};
  }
  return false;
}

}  // namespace impedraw
