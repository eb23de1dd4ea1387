// Simulates the controlled arm step by step, in free space or over a plane.
#pragma once

#include "arm_fixture.h"
#include "impedraw/canvas/built_in.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/simulation/world.h"

namespace impedraw::testing_arm {

// Starts at rest at `q`. The reference is the tip's initial pose unless the test changes it. The
// controller receives the wrench of the previous step.
struct FreeArm {
  ArmModel arm;
  World world;
  ArmTerms terms;
  ImpedanceController controller;
  TipReference reference;
  SurfaceEstimate surface;  // blind
  Wrench F_ext = Wrench::Zero();
  InputAges ages;

  static WorldSettings at_step(double dt) {
    WorldSettings settings;
    settings.dt = dt;
    return settings;
  }

  FreeArm(const ImpedanceSettings& settings, const JointVector& q,
          const WorldSettings& world_settings, const Canvas* canvas = nullptr,
          const std::filesystem::path& urdf = kArm)
      : arm(urdf),
        world(urdf, canvas, world_settings),
        terms(arm.joints()),
        controller(settings, arm.joints()) {
    const JointVector rest = JointVector::Zero(arm.joints());
    world.set_state(q, rest);
    arm.compute(q, rest, &terms);
    reference.p_WD = terms.X_WE.p;
    reference.n_WD = -terms.X_WE.R.col(2);
  }
  explicit FreeArm(const ImpedanceSettings& settings, const JointVector& q = working_posture())
      : FreeArm(settings, q, at_step(settings.timing.dt)) {}

  void measure() { arm.compute(world.state().q, world.state().v, &terms); }

  // Runs the controller alone at the measured state. A test may first corrupt its inputs.
  const ImpedanceTorque& control() {
    return controller.step(terms, reference, surface, F_ext, ages);
  }

  const ImpedanceTorque& step_under(const Wrench& push) {
    measure();
    const ImpedanceTorque& out = control();
    move(out.tau, push);
    return out;
  }
  const ImpedanceTorque& step(const Eigen::Vector3d& push = Eigen::Vector3d::Zero()) {
    Wrench F;
    F << push, Eigen::Vector3d::Zero();
    return step_under(F);
  }

  void move(const JointVector& tau, const Wrench& push) {
    const Eigen::Vector3d p_WE = world.state().X_WE.p;
    const TipContact& contact = world.step(tau, push);
    F_ext = push;
    if (!contact.touching) return;
    F_ext.head<3>() += contact.f_W;
    F_ext.tail<3>() += (contact.p_WC - p_WE).cross(contact.f_W);
  }
};

// A pen over an exactly known plane through p_WS with normal n. The tip starts at rest `height`
// above it, with the pen along −n.
struct PlaneArm {
  Eigen::Vector3d p_WS, n_W;
  Canvas canvas;
  FreeArm free;

  static TriangleMesh plane(const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
    PlaneSettings s;
    s.centre = p;
    s.normal = n;
    s.edge = 0.06;
    return make_plane(s);
  }
  static JointVector over(const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
    ArmModel arm(kArm);
    const IkResult ik = find_posture(arm, {p, -n}, working_posture());
    if (!ik.reached) throw std::logic_error("the test's plane is out of reach");
    return ik.q;
  }

  explicit PlaneArm(const ImpedanceSettings& settings, double slope = 0.3,
                    const ModelErrors& errors = {}, double height = 4e-3)
      : p_WS(0.6, 0.0, 0.2),
        n_W(-std::sin(slope), 0.0, std::cos(slope)),
        canvas(plane(p_WS, n_W)),
        free(settings, over(p_WS + height * n_W, n_W), world_settings(settings.timing.dt, errors),
             &canvas) {
    free.reference.n_WD = n_W;
    look();
  }
  static WorldSettings world_settings(double dt, const ModelErrors& errors) {
    WorldSettings s = FreeArm::at_step(dt);
    s.errors = errors;
    return s;
  }

  double height() const { return n_W.dot(free.world.state().X_WE.p - p_WS); }

  // The estimate of perfect perception, unless the test has removed it.
  void look() {
    free.surface.status = SurfaceStatus::ok;
    free.surface.n_W = n_W;
    free.surface.distance = height();
  }
  const ImpedanceTorque& step() {
    if (free.surface.status == SurfaceStatus::ok) look();
    return free.step();
  }
  // Keeps the pen down until the normal force has ramped up.
  void draw(int steps = 1500) {
    free.reference.pen_down = true;
    for (int i = 0; i < steps; ++i) step();
  }
};

}  // namespace impedraw::testing_arm
