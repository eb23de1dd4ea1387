#include "impedraw/simulation/world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "impedraw/common/errors.h"
#include "impedraw/simulation/compiled_arm.h"
#include "impedraw/simulation/flange_balance.h"
#include "impedraw/simulation/link_contact.h"
#include "impedraw/simulation/tip_contact.h"

namespace impedraw {

namespace {

constexpr int kJointSweeps = 200;  // most, of joint friction, joint limits and tip together

using RowMatrix3X = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor, 3, kMaxJoints>;
using RowMatrix6X = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor, 6, kMaxJoints>;
using ImpulseColumns =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxJoints, kMaxJoints>;

// MuJoCo prints warnings at every step by default. This handler keeps the last one for
// World::failure().
thread_local char last_warning[256] = "";
void keep_warning(const char* text) {
  std::snprintf(last_warning, sizeof last_warning, "%s", text);
}

}  // namespace

struct World::Mujoco {
  mjModel* model = nullptr;  // dynamics without body shapes, which would slow every step
  mjData* data = nullptr;
  mjModel* shape = nullptr;  // with body shapes, for the cameras
  mjData* shape_data = nullptr;
  int tip_body = -1;
  std::optional<LinkContact> link_contact;
  std::optional<FlangeBalance> flange;
  CarriedMomentum carried;  // at the present state, if flange_sensor is set

  // A place that the tip touches; C: frame at it, normal along z.
  struct Touch {
    Eigen::Vector3d p_WC;
    Eigen::Matrix3d R_WC;
    RowMatrix3X J_W, J_C;
    Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor, kMaxJoints, 3> M_inverse_Jt;
    TipMaterial tip;  // its share of it
    TipContactStep step;
    Eigen::Vector3d canvas_velocity;  // in C [m/s]
    Eigen::Vector3d impulse;          // in C [N s]
    bool converged;
  };

  // Workspace of the solver, so that a step allocates nothing.
  std::array<Touch, TipTouches::kMost> touches;
  int touched = 0;
  RowMatrix6X J_push;
  ImpulseColumns M_inverse;
  JointVector damping, dry_friction;  // of each joint [Nm s/rad], [Nm]
  JointVector link_damping;           // of each link: of the joint, or of a spring before it
  std::optional<GearFriction> dry;    // of the links; absent: of the rotors, or none
  JointVector v, joint_impulse,
      friction;             // friction: its impulses, the next step's initial guess
  JointVector link_torque;  // of the pushes on links, for the next step [Nm]

  ~Mujoco() {
    mj_deleteData(data);
    mj_deleteModel(model);
    mj_deleteData(shape_data);
    mj_deleteModel(shape);
  }
};

World::World(const std::filesystem::path& urdf, const Canvas* canvas, const WorldSettings& settings)
    : settings_((require_valid(settings), settings)),
      canvas_(canvas),
      h_(settings.dt / settings.substeps),
      mujoco_(std::make_unique<Mujoco>()),
      tool_(settings_, canvas),
      drive_(settings.errors, settings.dt) {
  mju_user_warning = keep_warning;
  const bool elastic = settings.joint_spring.on();
  if (elastic && !settings.errors.rotor_inertia.empty())
    throw InputError(
        "world.errors.rotor_inertia: joints with springs have the rotors of "
        "world.joint_spring.rotor_inertia; valid is []");
  ModelErrors of_links = settings.errors;
  if (elastic) of_links.rotor_inertia = {0.0};
  const CompiledArm arm = compile_arm(urdf, h_, settings.gravity, of_links);
  mujoco_->model = arm.dynamics;
  mujoco_->shape = arm.shape;
  mujoco_->data = mj_makeData(mujoco_->model);
  mujoco_->shape_data = mj_makeData(mujoco_->shape);
  mujoco_->tip_body = mj_name2id(mujoco_->model, mjOBJ_BODY, "tip");
  if (mujoco_->tip_body < 0)
    throw InputError(fmt::format("arm description {}: no link named 'tip'", urdf.string()));
  const int n = mujoco_->model->nv;
  if (n > kMaxJoints || mujoco_->model->nq != n)
    throw InputError(fmt::format("arm description {}: at most {} single-axis joints", urdf.string(),
                                 kMaxJoints));
  mujoco_->damping = arm.damping;
  mujoco_->dry_friction = arm.friction.array() + settings.joint_friction;
  for (Mujoco::Touch& touch : mujoco_->touches) {
    touch.J_W.setZero(3, n);
    touch.J_C.setZero(3, n);
    touch.M_inverse_Jt.setZero(n, 3);
  }
  mujoco_->link_damping = mujoco_->damping;
  const GearFriction friction(settings.errors, mujoco_->dry_friction);
  if (elastic) {
    springs_.emplace(settings.joint_spring, mujoco_->damping, friction, h_);
    mujoco_->link_damping = springs_->link_damping();
    Eigen::Map<Eigen::VectorXd>(mujoco_->model->dof_armature, n) = h_ * mujoco_->link_damping;
  } else if (friction.acts()) {
    mujoco_->dry = friction;
  }
  mujoco_->J_push.setZero(6, n);
  mujoco_->M_inverse.setZero(n, n);
  mujoco_->joint_impulse = mujoco_->friction = mujoco_->link_torque = JointVector::Zero(n);
  mujoco_->flange.emplace(mujoco_->model);
  mujoco_->link_contact.emplace(mujoco_->shape, canvas);
  state_.q = state_.v = JointVector::Zero(n);
  set_state(state_.q, state_.v);
}

World::~World() = default;

int World::joints() const { return mujoco_->model->nv; }
const JointVector& World::damping() const { return mujoco_->damping; }
const JointVector& World::dry_friction() const { return mujoco_->dry_friction; }
bool World::has_flange() const { return mujoco_->flange->has_flange(); }

void World::set_state(const JointVector& q, const JointVector& v) {
  mj_resetData(mujoco_->model, mujoco_->data);
  std::copy_n(q.data(), q.size(), mujoco_->data->qpos);
  std::copy_n(v.data(), v.size(), mujoco_->data->qvel);
  std::copy_n(q.data(), q.size(), mujoco_->shape_data->qpos);
  mj_kinematics(mujoco_->shape, mujoco_->shape_data);
  failure_.reset();
  cutoffs_ = {};
  last_warning[0] = '\0';
  mujoco_->joint_impulse.setZero();
  mujoco_->friction.setZero();
  mujoco_->link_torque.setZero();
  mujoco_->link_contact->reset();
  drive_.reset();
  tip_touches_.reset();
  line_.reset();
  tool_.reset();
  applied_torque_ = JointVector::Zero(joints());
  observe();
  if (springs_)
    springs_->reset(q, v, Eigen::Map<const Eigen::VectorXd>(mujoco_->data->qfrc_bias, q.size()));
  if (settings_.flange_sensor && has_flange())
    flange_wrench_ =
        mujoco_->flange->wrench(mujoco_->carried, mujoco_->carried, Vector6::Zero(), settings_.dt);
  look_for_touching_links();
}

void World::set_pen_longer(double longer) noexcept {
  mjModel* const m = mujoco_->model;
  const double* const turned = m->body_quat + 4 * mujoco_->tip_body;
  const Eigen::Quaterniond R(turned[0], turned[1], turned[2], turned[3]);
  Eigen::Map<Eigen::Vector3d>(m->body_pos + 3 * mujoco_->tip_body) +=
      (longer - settings_.errors.pen_longer) * (R * Eigen::Vector3d::UnitZ());
  mujoco_->link_contact->shifted(std::abs(longer - settings_.errors.pen_longer));
  settings_.errors.pen_longer = longer;
  tip_touches_.reset();
  observe();
}

void World::look_for_touching_links() noexcept {
  mujoco_->link_contact->update(mujoco_->data,
                                motion_.moves() ? canvas_state().X_WK.inverse() : Pose());
}

// Computes all terms that depend only on position and velocity, for the start of a step.
void World::observe() noexcept {
  const mjModel* m = mujoco_->model;
  mjData* d = mujoco_->data;
  mj_step1(m, d);
  const int n = m->nv;
  state_.time = d->time;
  state_.q = Eigen::Map<const Eigen::VectorXd>(d->qpos, n);
  state_.v = Eigen::Map<const Eigen::VectorXd>(d->qvel, n);
  state_.X_WE.p = Eigen::Map<const Eigen::Vector3d>(d->xpos + 3 * mujoco_->tip_body);
  state_.X_WE.R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
      d->xmat + 9 * mujoco_->tip_body);
  double velocity[6];  // angular part first
  mj_objectVelocity(m, d, mjOBJ_XBODY, mujoco_->tip_body, velocity, 0);
  state_.V_WE << Eigen::Map<const Eigen::Vector3d>(velocity + 3),
      Eigen::Map<const Eigen::Vector3d>(velocity);
  if (settings_.flange_sensor && has_flange()) mujoco_->carried = mujoco_->flange->momentum(m, d);
}

const TipContact& World::step(const JointVector& tau, const Eigen::Vector3d& f_push_W) noexcept {
  Vector6 F_push_W;
  F_push_W << f_push_W, Eigen::Vector3d::Zero();
  return advance(tau, F_push_W);
}

const TipContact& World::advance(const JointVector& tau, const Vector6& F_push_W) noexcept {
  const mjModel* m = mujoco_->model;
  applied_torque_ = drive_.act(tau, state_.q);
  for (int j = 0; j < m->nv; ++j)
    if (m->jnt_actfrclimited[j])
      applied_torque_[j] =
          std::clamp(applied_torque_[j], m->jnt_actfrcrange[2 * j], m->jnt_actfrcrange[2 * j + 1]);

  const CarriedMomentum start = mujoco_->carried;
  TipContact whole;                 // of all integration steps
  Vector6 F_env = Vector6::Zero();  // its sum; moment about the c.o.m. of what the flange carries
  const double share = 1.0 / settings_.substeps;
  for (int i = 0; i < settings_.substeps; ++i) {
    const Eigen::Vector3d p_WE = state_.X_WE.p;
    integrate(F_push_W);
    if (contact_.touching && !whole.touching) {
      whole = contact_;
      whole.f_W *= share;
      whole.m_W *= share;
    } else if (contact_.touching) {
      whole.f_W += share * contact_.f_W;
      whole.m_W += share * contact_.m_W;
    } else if (!whole.touching) {
      whole.p_WC = contact_.p_WC;
      whole.n_W = contact_.n_W;
    }
    F_env.head<3>() += contact_.f_W + F_push_W.head<3>();
    F_env.tail<3>() += (contact_.p_WC - start.c_W).cross(contact_.f_W) +
                       (p_WE - start.c_W).cross(F_push_W.head<3>()) + F_push_W.tail<3>();
    if (!contact_.m_W.isZero(0.0)) F_env.tail<3>() += contact_.m_W;
  }
  contact_ = whole;
  mujoco_->link_torque.setZero();
  look_for_touching_links();
  if (settings_.flange_sensor && has_flange())
    flange_wrench_ = mujoco_->flange->wrench(start, mujoco_->carried, share * F_env, settings_.dt);

  const double size = state_.q.cwiseAbs().sum() + state_.v.cwiseAbs().sum();
  if (!(size < 1e4) || last_warning[0] != '\0')
    failure_ = last_warning[0] ? last_warning
                               : fmt::format("joint speeds reached {:.3g} rad/s",
                                             state_.v.cwiseAbs().maxCoeff());
  return contact_;
}

// One integration step under the applied torque.
void World::integrate(const Vector6& F_push_W) noexcept {
  const mjModel* m = mujoco_->model;
  mjData* d = mujoco_->data;
  const int n = m->nv;
  JointVector generalised =
      springs_ ? springs_->begin(applied_torque_, state_.q, state_.v) : applied_torque_;
  Vector6 F_W = F_push_W;
  if (tool_.has_face()) {
    const PadLoad& face = tool_.press(canvas_state(), state_.X_WE, state_.V_WE, h_);
    F_W.head<3>() += face.f;
    F_W.tail<3>() += face.m;
  }
  const Eigen::Vector3d cut_side_W = tool_.side_W();
  if (tool_.has_cutter()) F_W.head<3>() += cut_side_W;
  if (!F_W.isZero(0.0)) {
    mj_jac(m, d, mujoco_->J_push.data(), mujoco_->J_push.data() + 3 * n, state_.X_WE.p.data(),
           mujoco_->tip_body);
    generalised += mujoco_->J_push.transpose().lazyProduct(F_W);
  }
  generalised += mujoco_->link_torque;
  generalised -= mujoco_->link_damping.cwiseProduct(state_.v);  // implicit: see compiled_arm.h
  const Eigen::Map<const Eigen::VectorXd> bias(d->qfrc_bias, n);
  JointVector acceleration(n);
  const JointVector force = generalised - bias;
  mj_solveM(m, d, acceleration.data(), force.data(), 1);
  const Eigen::Vector3d p_WE = state_.X_WE.p;
  solve_impulses(state_.v + h_ * acceleration);

  Eigen::Map<Eigen::VectorXd> applied(d->qfrc_applied, n);
  applied = generalised + mujoco_->joint_impulse / h_;
  if (const PadLoad& face = tool_.load(); face.touching)
    contact_ = {true, face.f, face.m - (face.centre - p_WE).cross(face.f), face.centre, face.n};
  if (tool_.has_cutter() && contact_.touching) contact_.f_W += cut_side_W;
  for (const Mujoco::Touch& touch : std::span(mujoco_->touches).first(mujoco_->touched))
    applied += touch.J_W.transpose().lazyProduct(Eigen::Vector3d(touch.R_WC * touch.impulse / h_));
  mj_step2(m, d);
  observe();
  if (springs_) springs_->finish(state_.v);
}

// Places that the tip's ball touches, and their Jacobians; contact_: where the nearest one is.
void World::find_touches() noexcept {
  Mujoco& w = *mujoco_;
  const double radius = settings_.tip.radius;
  const bool moves = motion_.moves();
  Eigen::Vector3d centre = state_.X_WE.p - (radius + line_.worn()) * state_.X_WE.R.col(2);
  const Pose X_WK = moves ? canvas_state().X_WK : Pose();
  if (moves) centre = X_WK.inverse() * centre;
  for (const TipTouch& place : tip_touches_.update(*canvas_, centre, radius)) {
    Mujoco::Touch& touch = w.touches[w.touched];
    Eigen::Vector3d n_W = place.n;
    touch.p_WC = place.p;
    if (moves) {  // the mesh is in K
      touch.p_WC = X_WK * place.p;
      n_W = X_WK.R * place.n;
    }
    touch.step.penetration = radius - place.clear;
    if (w.touched == 0) {
      contact_.touching = touch.step.penetration > 0.0;
      contact_.p_WC = touch.p_WC;
      contact_.n_W = n_W;
      if (!contact_.touching) return;
    }
    ++w.touched;
    touch.R_WC = contact_frame(n_W);
    mj_jac(w.model, w.data, touch.J_W.data(), nullptr, touch.p_WC.data(), w.tip_body);
    touch.J_C = touch.R_WC.transpose().lazyProduct(touch.J_W);
    for (int i = 0; i < 3; ++i) {
      const JointVector row = touch.J_C.row(i).transpose();
      mj_solveM(w.model, w.data, touch.M_inverse_Jt.col(i).data(), row.data(), 1);
    }
    touch.step.G.noalias() = touch.J_C.lazyProduct(touch.M_inverse_Jt);
    touch.step.dt = h_;
    touch.tip = line_.here(settings_.tip);
    touch.tip.stiffness *= place.share;
    touch.tip.damping *= place.share;
    touch.impulse.setZero();
    touch.canvas_velocity.setZero();
    // at the end of the step, as the tip's velocity
    if (moves)
      touch.canvas_velocity = touch.R_WC.transpose() * canvas_state(h_).velocity_at(touch.p_WC);
  }
}

// Solves for consistent impulses of the tip and the joints. v_free: velocity after the step without
// them.
void World::solve_impulses(const JointVector& v_free) noexcept {
  Mujoco& w = *mujoco_;
  const int n = w.model->nv;
  const double h = h_;
  w.v = v_free;
  contact_ = {};
  w.joint_impulse.setZero();
  const auto invert_inertia = [&] {
    for (int j = 0; j < n; ++j) {
      const JointVector unit = JointVector::Unit(n, j);
      mj_solveM(w.model, w.data, w.M_inverse.col(j).data(), unit.data(), 1);
    }
  };
  const bool dry = w.dry.has_value();
  JointVector most;  // impulses of dry friction
  if (dry) {
    most = h * w.dry->most(state_.v, state_.q, applied_torque_);
    invert_inertia();
    w.v += w.M_inverse.lazyProduct(w.friction);
  }

  w.touched = 0;
  if (canvas_ && !tool_.has_face()) find_touches();
  if (w.touched == 0) tool_.release();
  if (w.touched > 0 && tool_.has_cutter()) {
    Mujoco::Touch& nearest = w.touches[0];
    tool_.engage(canvas_state().X_WK.inverse(), {nearest.p_WC, nearest.R_WC},
                 nearest.J_C.lazyProduct(state_.v) - nearest.canvas_velocity,
                 nearest.step.penetration, h, &nearest.tip);
  }
  const std::span touches = std::span(w.touches).first(w.touched);
  const auto solve = [&w](Mujoco::Touch& touch) {  // returns the largest change
    const Eigen::Vector3d last = touch.impulse;
    touch.step.v_free = touch.J_C.lazyProduct(w.v) - touch.canvas_velocity - touch.step.G * last;
    const TipImpulse found = solve_tip_contact(touch.step, touch.tip, last);
    touch.impulse = found.p;
    touch.converged = found.converged;
    w.v += touch.M_inverse_Jt.lazyProduct(found.p - last);
    return (found.p - last).cwiseAbs().maxCoeff();
  };
  for (Mujoco::Touch& touch : touches) solve(touch);

  // Joints with an impulse: dry friction, or a limit that this step would cross.
  const auto limit_gap = [&](int j, double* sign) {
    const double* range = w.model->jnt_range + 2 * j;
    if (!w.model->jnt_limited[j]) return std::numeric_limits<double>::infinity();
    const double below = state_.q[j] - range[0], above = range[1] - state_.q[j];
    *sign = below < above ? 1.0 : -1.0;
    return std::min(below, above);
  };
  bool joints_act = dry;
  for (int j = 0; j < n && !joints_act; ++j) {
    double sign = 1.0;
    const double gap = limit_gap(j, &sign);
    joints_act = gap + h * sign * w.v[j] < 0.0;
  }
  if (joints_act || touches.size() > 1) {
    if (joints_act && !dry) invert_inertia();
    JointVector limit = JointVector::Zero(n);
    bool converged = false;
    for (int sweep = 0; sweep < kJointSweeps && !converged; ++sweep) {
      double change = 0.0;
      const auto add = [&](int j, double* impulse, double value) {
        const double delta = value - *impulse;
        *impulse = value;
        w.v += w.M_inverse.col(j) * delta;
        change = std::max(change, std::abs(delta));
      };
      for (int j = 0; j < n && joints_act; ++j) {
        const double mobility = w.M_inverse(j, j);
        if (dry)
          add(j, &w.friction[j], std::clamp(w.friction[j] - w.v[j] / mobility, -most[j], most[j]));
        double sign = 1.0;
        const double gap = limit_gap(j, &sign);
        if (std::isfinite(gap))
          add(j, &limit[j],
              sign * std::max(0.0, sign * limit[j] - (sign * w.v[j] + gap / h) / mobility));
      }
      for (Mujoco::Touch& touch : touches) change = std::max(change, solve(touch));
      converged = change < 1e-12;
    }
    cutoffs_.joints += !converged;
    w.joint_impulse = w.friction + limit;
  }
  for (const Mujoco::Touch& touch : touches) {
    const Eigen::Vector3d f_W = touch.R_WC * touch.impulse / h;
    if (&touch == touches.data()) {
      contact_.f_W = f_W;
      continue;
    }
    contact_.f_W += f_W;
    contact_.m_W += (touch.p_WC - contact_.p_WC).cross(f_W);
  }
  cutoffs_.tip += std::any_of(touches.begin(), touches.end(),
                              [](const Mujoco::Touch& touch) { return !touch.converged; });
  if (touches.empty() || (settings_.tip.friction_change == 0.0 && settings_.tip.wear == 0.0))
    return;
  const Mujoco::Touch& nearest = touches.front();
  line_.advance(settings_.tip, nearest.impulse[2] / h,
                (nearest.J_C.lazyProduct(w.v) - nearest.canvas_velocity).head<2>().norm(), h);
}

void World::forget_touching_link() noexcept { mujoco_->link_contact->reset(); }

const std::string& World::touching_link() const { return mujoco_->link_contact->link(); }

std::optional<int> World::link(const std::string& name) const {
  const int body = mj_name2id(mujoco_->model, mjOBJ_BODY, name.c_str());
  if (body < 0) return std::nullopt;
  return body;
}

bool World::below_flange(int link) const {
  const int flange = mj_name2id(mujoco_->model, mjOBJ_BODY, "flange");
  while (link > 0 && link != flange) link = mujoco_->model->body_parentid[link];
  return flange > 0 && link == flange;
}

void World::push_link(int link, const Eigen::Vector3d& f_W) noexcept {
  const mjData* d = mujoco_->data;
  mj_jac(mujoco_->model, d, mujoco_->J_push.data(), nullptr, d->xpos + 3 * link, link);
  mujoco_->link_torque += mujoco_->J_push.topRows<3>().transpose().lazyProduct(f_W);
}

double World::ray_to_arm(const Eigen::Vector3d& origin_W,
                         const Eigen::Vector3d& direction_W) const {
  int geom = -1;
  const double distance = mj_ray(mujoco_->shape, mujoco_->shape_data, origin_W.data(),
                                 direction_W.data(), nullptr, 1, -1, &geom, nullptr);
  return distance < 0.0 ? std::numeric_limits<double>::infinity() : distance;
}

void World::pose_body() noexcept {
  std::copy_n(state_.q.data(), state_.q.size(), mujoco_->shape_data->qpos);
  mj_kinematics(mujoco_->shape, mujoco_->shape_data);
}

void World::copy_body(PosedBody* body) const { body->copy(mujoco_->shape, mujoco_->shape_data); }

World::Terms World::terms() const {
  const mjModel* m = mujoco_->model;
  const mjData* d = mujoco_->data;
  const int n = m->nv;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> M(n, n), J(6, n);
  mj_fullM(m, d, M.data());
  M.diagonal() -= h_ * mujoco_->link_damping;  // the integrator's implicit part (compiled_arm.h)
  mj_jac(m, d, J.data(), J.data() + 3 * n, state_.X_WE.p.data(), mujoco_->tip_body);
  return {M, J, Eigen::Map<const Eigen::VectorXd>(d->qfrc_bias, n)};
}

}  // namespace impedraw
