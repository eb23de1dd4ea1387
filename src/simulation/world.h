// Simulated world: a torque-controlled arm whose pen touches a canvas. MuJoCo simulates the arm;
// tip_contact.h simulates the contact.
//
// One integration step of h = dt / substeps from t_i
//   v⁺ = v + h M⁻¹ (τ_a + Jᵀ F_push − C v − g − b v⁺) + M⁻¹ (Σ J_cᵀ p + p_joint)
//   q⁺ = q + h v⁺
//
// With a tool (tool_contact.h), the wrench of a face at the start of the step is part of F_push,
// and p is zero; of a cutter, the force across its way in the last step is, at E.
//
// The simulated arm can differ from the URDF, and τ_a from the commanded torque: ModelErrors.
// The drives clip τ_a to the URDF's effort limits and hold it for all integration steps of dt.
// Viscous friction b v⁺ is implicit; b and τ_f are those of the settings plus damping and friction
// of the URDF's <dynamics>. The tip's impulses p, one at each place that its ball touches
// (tip_touches.h), and the joints' impulses, dry friction |p_j| ≤ h τ_f and limits p_j ≥ 0, are
// solved together (block Gauss-Seidel). Solved in sequence, the second would change the velocity
// on which the first is based.
//
// With springs in the joints (joint_springs.h), τ_a is what the arm's torque loop is told, and the
// rotors take friction, dry and viscous, and their own inertia from the links.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "impedraw/canvas/canvas.h"
#include "impedraw/common/pose.h"
#include "impedraw/control/arm_terms.h"
#include "impedraw/simulation/canvas_motion.h"
#include "impedraw/simulation/joint_drive.h"
#include "impedraw/simulation/joint_springs.h"
#include "impedraw/simulation/posed_body.h"
#include "impedraw/simulation/tip_line.h"
#include "impedraw/simulation/tip_touches.h"
#include "impedraw/simulation/tool_contact.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

// Contact over the last step: mean force; geometry at the start of the first integration step that
// touched.
struct TipContact {
  bool touching = false;
  Eigen::Vector3d f_W = Eigen::Vector3d::Zero();  // of the canvas on the tip [N]
  // moment about p_WC: of a pad's friction, or of what else a ball touches; zero for one place [Nm]
  Eigen::Vector3d m_W = Eigen::Vector3d::Zero();
  // on the canvas, closest to the centre of the tip's ball; a pad's centre of pressure [m]
  Eigen::Vector3d p_WC = Eigen::Vector3d::Zero();
  // outward normal there; where the tip came from behind an open sheet, towards the tip
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();
};

struct WorldState {
  double time = 0.0;  // [s]
  JointVector q, v;   // [rad], [rad/s]
  Pose X_WE;          // pen tip, true
  Vector6 V_WE = Vector6::Zero();
};

class World {
 public:
  // The URDF's frame `tip` is E. The canvas must outlive the world; nullptr means no canvas. Throws
  // InputError.
  World(const std::filesystem::path& urdf, const Canvas* canvas, const WorldSettings& settings);
  ~World();

  int joints() const;
  // b and τ_f of each joint: of the settings and of the URDF's <dynamics> [Nm s/rad], [Nm].
  const JointVector& damping() const;
  const JointVector& dry_friction() const;
  // The canvas moves from now on as `motion` says at the world's time. Friction acts on the
  // velocity of the tip relative to the canvas, and so does the contact's damper.
  void move_canvas(const CanvasMotion& motion) { motion_ = motion; }
  // Sets tip and canvas together, from the next step on: a canvas whose stiffness changes.
  void set_tip(const TipMaterial& tip) noexcept { settings_.tip = tip; }
  // The true tip's offset along its z from its place in the URDF, as ModelErrors::pen_longer [m].
  void set_pen_longer(double longer) noexcept;
  // Sets the time for which it has moved at the world's time 0, where a run goes on [s].
  void canvas_moved_for(double time) { moved_for_ = time; }
  const CanvasMotion& canvas_motion() const { return motion_; }
  // Its pose and motion at the current state, or so much later [s].
  CanvasMotion::State canvas_state(double later = 0.0) const {
    return motion_.at(moved_for_ + state_.time + later);
  }
  void set_state(const JointVector& q, const JointVector& v);
  const WorldState& state() const { return state_; }

  // Advances by dt under the commanded joint torque τ and a push on the pen at E: a force, or a
  // wrench [force; moment], in W. Returns the contact that acted. Allocates nothing.
  const TipContact& step(const JointVector& tau, const Eigen::Vector3d& f_push_W) noexcept;
  template <typename Push>
  requires(Push::RowsAtCompileTime ==
           6) const TipContact& step(const JointVector& tau,
                                     const Eigen::MatrixBase<Push>& F_push_W) noexcept {
    return advance(tau, F_push_W);
  }

  // The joints' sensors see the links, or with springs maybe the rotors [rad], [rad/s].
  const JointVector& sensed_q() const { return read_rotors() ? springs_->theta() : state_.q; }
  const JointVector& sensed_v() const { return read_rotors() ? springs_->theta_rate() : state_.v; }
  // Null for rigid joints.
  const JointSprings* springs() const { return springs_ ? &*springs_ : nullptr; }
  const TipLine& line() const { return line_; }  // since set_state(), where it matters

  // Number of a link of the URDF, for push_link(); nothing for a name that it does not have.
  std::optional<int> link(const std::string& name) const;
  // True if the link is below the flange, where flange_wrench() would feel a push on it.
  bool below_flange(int link) const;
  // Adds a force at the link's origin, in W [N], to the next step() only.
  void push_link(int link, const Eigen::Vector3d& f_W) noexcept;

  // τ_a over the last step: the commanded torque after delay, clipping, quantisation and ripple,
  // before friction. Zero after set_state().
  const JointVector& applied_torque() const { return applied_torque_; }

  // Wrench [f; m] of pen and environment on link `flange`, taken at its origin S in its axes at the
  // start of the last step. Mean over the step: contact + push + weight of all below the flange −
  // rate of its momentum (flange_balance.h). After set_state(): the weight. Zero without
  // WorldSettings::flange_sensor or without such a link.
  const Vector6& flange_wrench() const { return flange_wrench_; }
  bool has_flange() const;  // a link `flange` exists with `tip` below it

  const SolverCutoffs& cutoffs() const { return cutoffs_; }  // since set_state()

  // Name of the link whose body touches the canvas at the current state (link_contact.h); empty if
  // none does. Bodies and canvas do not push on each other: a run ends there.
  const std::string& touching_link() const;
  // Looks anew after the next step.
  void forget_touching_link() noexcept;

  // Names the cause if the motion became non-finite or MuJoCo warned. The state is then invalid.
  const std::optional<std::string>& failure() const { return failure_; }

  // Distance along a unit ray to the arm's body [m], in the posture of set_state() or of the last
  // pose_body(); infinite if the ray misses. For the cameras; callable from any thread.
  double ray_to_arm(const Eigen::Vector3d& origin_W, const Eigen::Vector3d& direction_W) const;
  // Puts that body where the arm is now. Allocates nothing.
  void pose_body() noexcept;
  // A copy of that body. Allocates nothing where *body is one of an earlier call.
  void copy_body(PosedBody* body) const;

  // MuJoCo's M, C v + g and J of the simulated arm at the current state. Independent reference for
  // tests of the controller's terms.
  struct Terms {
    Eigen::MatrixXd M, J;
    Eigen::VectorXd bias;
  };
  Terms terms() const;

 private:
  struct Mujoco;
  const TipContact& advance(const JointVector& tau, const Vector6& F_push_W) noexcept;
  void integrate(const Vector6& F_push_W) noexcept;
  void observe() noexcept;
  bool read_rotors() const { return springs_ && springs_->motor_side(); }
  void look_for_touching_links() noexcept;
  void find_touches() noexcept;
  void solve_impulses(const JointVector& v_free) noexcept;

  WorldSettings settings_;
  const Canvas* canvas_;
  CanvasMotion motion_;
  double moved_for_ = 0.0;  // at the world's time 0 [s]
  double h_;                // of an integration step [s]
  std::unique_ptr<Mujoco> mujoco_;
  WorldState state_;
  TipContact contact_;
  TipTouches tip_touches_;
  ToolContact tool_;
  JointDrive drive_;
  std::optional<JointSprings> springs_;
  TipLine line_;
  JointVector applied_torque_;
  Vector6 flange_wrench_ = Vector6::Zero();
  SolverCutoffs cutoffs_;
  std::optional<std::string> failure_;
};

}  // namespace impedraw
