// The controller in closed loop with a custom simulator. An arm (gantry.h) with a force-torque
// sensor above its pen approaches an inclined canvas, draws a circle at 5 N and retracts. Prints
// statistics of force and line error. The exit code is 1 if they are out of tolerance.
//
// usage: own_simulator [FRICTION]    pen on canvas, default 0.25; the controller assumes 0.3
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "gantry.h"
#include "impedraw/control/impedance.h"
#include "impedraw/sensing/wrench_estimator.h"

using namespace impedraw;
using Eigen::Vector3d;

constexpr double kStep = 1e-3;  // time step of the controller [s]
// simulator steps per controller step: friction on a light tip is stiff
constexpr int kSubsteps = 20;
constexpr double kForce = 5.0;    // [N]
constexpr double kRadius = 0.03;  // of the circle in the x-y plane [m]
constexpr double kPenDown = 0.6, kDraw = 2.8, kDrawn = 8.6, kPenUp = 8.8, kEnd = 9.6;  // [s]

// A plane through W's origin: spring and damper along n, Coulomb friction smoothed below 1 mm/s.
struct Canvas {
  Vector3d n_W = Vector3d(-0.2, 0.1, 1.0).normalized();
  double stiffness = 20e3, damping = 50.0, friction = 0.25;  // [N/m], [N s/m]

  double height(const Vector3d& p_W) const { return n_W.dot(p_W); }
  Vector3d force(const Vector3d& p_W, const Vector3d& v_W) const {
    if (height(p_W) >= 0.0) return Vector3d::Zero();
    const double f_n = std::max(0.0, -stiffness * height(p_W) - damping * n_W.dot(v_W));
    const Vector3d v_t = v_W - n_W * n_W.dot(v_W);
    return f_n * (n_W - friction * v_t / std::hypot(v_t.norm(), 1e-3));
  }
};

// Arm, canvas and sensor. The sensor's frame S stands at the wrist's centre with the axes of E.
struct Simulator {
  Gantry arm;
  Canvas canvas;
  Tool pen{arm.pen_mass, {0.0, 0.0, arm.pen_centre}, Eigen::Matrix3d::Zero()};
  Vector6 bias_S = (Vector6() << 2.0, -1.0, 3.0, 0.05, -0.1, 0.02).finished();
  JointVector q{6}, v = JointVector::Zero(6);
  ArmTerms terms{6};
  Vector6 reading_S;   // sensor reading, mean over the last step
  Vector3d contact_W;  // true force of the canvas, mean over the last step [N]

  explicit Simulator(const Vector3d& p_WE) {  // at rest, the pen along −n
    const Vector3d& n = canvas.n_W;
    q << p_WE + arm.tip * n, std::atan2(-n.y(), n.z()), std::asin(n.x()), 0.0;
    arm.compute(q, v, &terms);
    reading_S = reading(Vector3d::Zero(), v);
  }

  void step(const JointVector& tau) {
    const double h = kStep / kSubsteps;
    reading_S.setZero();
    contact_W.setZero();
    for (int i = 0; i < kSubsteps; ++i) {  // semi-implicit Euler
      const Vector3d f = canvas.force(terms.X_WE.p, terms.V_WE.head<3>());
      const JointVector a =
          terms.M.llt().solve(tau - terms.Cv - terms.g + terms.J.topRows<3>().transpose() * f);
      reading_S += reading(f, a) / kSubsteps;
      contact_W += f / kSubsteps;
      v += h * a;
      q += h * v;
      arm.compute(q, v, &terms);
    }
  }

  Vector6 reading(const Vector3d& f_W, const JointVector& a) const {
    ToolMotion motion;  // of S: translates with the rails, rotates with E
    motion.X_WS = {q.head<3>(), terms.X_WE.R};
    motion.V_WS << v.head<3>(), terms.V_WE.tail<3>();
    motion.A_WS << a.head<3>(), terms.J.bottomRows<3>() * a + terms.Jdot_v.tail<3>();
    const Vector3d f_S = terms.X_WE.R.transpose() * f_W;
    Vector6 contact_S;
    contact_S << f_S, Vector3d(0.0, 0.0, arm.tip).cross(f_S);
    return contact_S + tool_wrench(pen, motion, arm.gravity_W) + bias_S;
  }

  // The pen's tip is compliant, the canvas rigid: the ink lies above E.
  Vector3d ink() const { return terms.X_WE.p - canvas.height(terms.X_WE.p) * canvas.n_W; }
};

// From 0 to 1 within `duration`, at rest before and after; with two derivatives.
struct Smooth {
  double s, rate, acceleration;
  Smooth(double t, double duration) {
    const double x = std::clamp(t / duration, 0.0, 1.0);
    s = x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
    rate = 30.0 * x * x * (1.0 - x) * (1.0 - x) / duration;
    acceleration = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / (duration * duration);
  }
};

// Down from 10 mm, once around, up again. The plan knows the slope but assumes the canvas 2 mm too
// high. Perception finds its true height.
TipReference plan(double t, const Vector3d& n) {
  const Smooth turn(t - kDraw, kDrawn - kDraw), leave(t - kPenUp, kEnd - kPenUp);
  const double phi = 2.0 * M_PI * turn.s, rate = 2.0 * M_PI * turn.rate,
               acceleration = 2.0 * M_PI * turn.acceleration;
  const Vector3d out(std::cos(phi), std::sin(phi), 0.0), ahead(-std::sin(phi), std::cos(phi), 0.0);
  const auto onto_canvas = [&n](const Vector3d& x) -> Vector3d {
    return x - Vector3d::UnitZ() * (n.dot(x) / n.z());
  };
  TipReference reference;
  reference.n_WD = n;
  reference.pen_down = t >= kPenDown && t < kPenUp;
  reference.p_WD = onto_canvas(kRadius * out) + Vector3d(0.0, 0.0, 2e-3) +
                   (t < kPenDown ? 0.008 : 0.02 * leave.s) * n;
  reference.v_WD = onto_canvas(kRadius * rate * ahead) + 0.02 * leave.rate * n;
  reference.a_WD = onto_canvas(kRadius * (acceleration * ahead - rate * rate * out)) +
                   0.02 * leave.acceleration * n;
  return reference;
}

int main(int argc, char** argv) {
  const Vector3d n = Canvas().n_W;
  Simulator world(plan(0.0, n).p_WD);
  if (argc > 1) world.canvas.friction = std::atof(argv[1]);

  Gantry model = world.arm;  // the controller's model of the arm: rails 10 % too light
  model.rail_mass *= 0.9;
  ArmTerms arm(6);

  ImpedanceSettings settings;
  settings.timing.dt = kStep;
  settings.normal_force = kForce;
  settings.tip.radius = 0.0;
  settings.tip.stiffness = world.canvas.stiffness;
  settings.limits.torque = Eigen::VectorXd::Constant(6, 200.0);
  ImpedanceController controller(settings, 6);

  WrenchEstimatorSettings sensing;
  sensing.dt = kStep;
  sensing.tool = world.pen;
  sensing.X_ES.p = {0.0, 0.0, -world.arm.tip};
  sensing.gravity_W = world.arm.gravity_W;
  WrenchEstimator wrench(sensing);  // estimates the bias while the arm is at rest

  double sum = 0.0, sum_2 = 0.0, peak = 0.0, line_2 = 0.0, line_max = 0.0;
  int drawn = 0, touching = 0, troubled = 0;
  for (double t = 0.0; t < kEnd; t += kStep) {
    model.compute(world.q, world.v, &arm);
    const Wrench& F_ext = wrench.update(world.reading_S, arm.X_WE, arm.V_WE);
    const SurfaceEstimate surface{SurfaceStatus::ok, n,
                                  world.canvas.height(arm.X_WE.p)};  // perfect perception
    const ImpedanceTorque& out = controller.step(arm, plan(t, n), surface, F_ext);
    world.step(out.tau);

    const double force = n.dot(world.contact_W), line = world.ink().head<2>().norm() - kRadius;
    troubled += !out.status.ok();
    peak = std::max(peak, force);
    if (t < kDraw || t > kDrawn) continue;
    ++drawn;
    touching += force > 0.0;
    sum += force;
    sum_2 += force * force;
    line_2 += line * line;
    line_max = std::max(line_max, std::abs(line));
  }
  const double mean = sum / drawn,
               deviation = std::sqrt(std::max(0.0, sum_2 / drawn - mean * mean)),
               rms = std::sqrt(line_2 / drawn);
  const double above = world.canvas.height(world.terms.X_WE.p);
  std::printf("force %.4f N, SD %.4f N, peak %.2f N, touching %.1f %%\n", mean, deviation, peak,
              100.0 * touching / drawn);
  std::printf("line  %.4f mm RMS, %.4f mm at most\n", 1e3 * rms, 1e3 * line_max);
  std::printf("steps that reported trouble: %d; %.1f mm above the canvas in the end\n", troubled,
              1e3 * above);
  const bool good = std::abs(mean - kForce) < 0.05 && deviation < 0.1 && touching == drawn &&
                    rms < 0.02e-3 &&  //
                    troubled == 0 && above > 0.015;
  if (!good) std::printf("out of tolerance\n");
  return good ? 0 : 1;
}
