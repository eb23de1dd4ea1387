// From a point cloud to torque. An arm read from a URDF draws a star on a saddle that is known only
// by a noisy cloud: the cloud gives normals and height, the strokes on it a timed path, and the
// controller follows that path at 5 N. Prints force and line error. The exit code is 1 if they are
// out of tolerance.
//
// usage: own_surface ARM.urdf [NOISE]    standard deviation of the cloud [mm], default 0.3
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <random>

#include <Eigen/Cholesky>

#include "impedraw/arm/arm_model.h"
#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/control/impedance.h"
#include "impedraw/perception/normals.h"
#include "impedraw/planning/path/tip_planner.h"

using namespace impedraw;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kStep = 1e-3;  // time step of the controller [s]
constexpr int kSubsteps = 10;   // simulator steps per controller step
constexpr double kForce = 5.0;  // [N]

// The true surface: a saddle under the arm. Only the cloud and the contact know it.
struct Saddle {
  double z(double x, double y) const { return 0.10 + 0.8 * (x - 0.6) * (x - 0.6) - 0.5 * y * y; }
  Vector3d n_W(double x, double y) const {
    return Vector3d(-1.6 * (x - 0.6), 1.0 * y, 1.0).normalized();
  }
  double depth(const Vector3d& p_W) const {  // along n, to first order
    return (z(p_W.x(), p_W.y()) - p_W.z()) * n_W(p_W.x(), p_W.y()).z();
  }
  // Spring, damper and Coulomb friction, smoothed below 1 mm/s.
  Vector3d force(const Vector3d& p_W, const Vector3d& v_W) const {
    const Vector3d n = n_W(p_W.x(), p_W.y());
    if (depth(p_W) <= 0.0) return Vector3d::Zero();
    const double f_n = std::max(0.0, 20e3 * depth(p_W) - 50.0 * n.dot(v_W));
    const Vector3d v_t = v_W - n * n.dot(v_W);
    return f_n * (n - 0.25 * v_t / std::hypot(v_t.norm(), 1e-3));
  }
};

// 1. What a depth camera above the surface sees; back_project() makes such a cloud of its images.
PointCloud scan(const Saddle& saddle, double noise) {
  std::mt19937 rng(1);
  std::normal_distribution<double> error(0.0, noise);
  PointCloud cloud;
  cloud.eyes = {Vector3d(0.6, 0.0, 1.0)};
  for (double x = 0.45; x < 0.75; x += 0.0015)
    for (double y = -0.15; y < 0.15; y += 0.0015)
      cloud.points.emplace_back(x, y, saddle.z(x, y) + (noise > 0.0 ? error(rng) : 0.0));
  cloud.camera.assign(cloud.points.size(), 0);
  return thin(cloud, 0.004);
}

// 2. Height and normal over the drawing plane: Newton steps along z onto the fitted surface.
SurfaceHeight height_of(const SurfaceEstimator& cloud) {
  return [&cloud](double x, double y) -> std::optional<SurfaceSample> {
    Vector3d p(x, y, 0.10);
    for (int i = 0; i < 20; ++i) {
      const SurfaceEstimate surface = cloud.estimate(p);
      if (surface.status != SurfaceStatus::ok || surface.n_W.z() < 0.1) return std::nullopt;
      const double step = surface.distance / surface.n_W.z();
      p.z() -= step;
      if (std::abs(step) < 1e-7) return SurfaceSample{p, surface.n_W};
    }
    return std::nullopt;
  };
}

// 3. A star of five corners on a page, placed under the arm, 120 mm wide.
std::vector<PlacedStroke> star() {
  Artwork artwork;
  artwork.name = "star";
  artwork.layers = {"all"};
  Stroke stroke;
  stroke.closed = true;
  for (int i = 0; i <= 5; ++i)
    stroke.points.push_back(Eigen::Rotation2Dd(0.8 * M_PI * i) * Vector2d(0.0, -1.0));
  artwork.strokes = {stroke};
  PlacementSettings placement;
  placement.centre_m = {0.6, 0.0};
  placement.width_mm = 120.0;
  return placed_strokes(artwork, place(artwork, placement));
}

int main(int argc, char** argv) try {
  if (argc < 2) return std::fprintf(stderr, "usage: own_surface ARM.urdf [NOISE]\n"), 2;
  const double noise = argc > 2 ? 1e-3 * std::atof(argv[2]) : 3e-4;  // [m]
  const Saddle saddle;
  NormalSettings normals;
  normals.k = 90;
  const SurfaceEstimator cloud(scan(saddle, noise), normals);

  ArmModel model(argv[1]);
  ArmTerms arm(model.joints());
  JointVector seed(7);
  seed << 0.0, 0.6, 0.0, -1.4, 0.0, 1.1, 0.0;
  PathSettings settings;
  settings.start_p_WE = {0.6, 0.0, 0.2};
  const TipPath path = plan_tip_path(star(), height_of(cloud), settings);

  JointVector q = find_posture(model, {settings.start_p_WE, -Vector3d::UnitZ()}, seed).q;
  JointVector v = JointVector::Zero(q.size());
  ImpedanceSettings control;
  control.timing.dt = kStep;
  control.normal_force = kForce;
  control.tip.radius = 0.0;  // the tip is a point
  control.null_space.q_0 = q;
  control.limits.torque = model.limits().torque;
  control.joint_range.lower = model.limits().lower;
  control.joint_range.upper = model.limits().upper;
  ImpedanceController controller(control, model.joints());

  // 4. The loop: terms, cloud and path in, torque out.
  Wrench F_ext = Wrench::Zero();  // mean over the last step
  double sum = 0.0, sum_2 = 0.0, line_2 = 0.0, normal_max = 0.0;
  int drawn = 0, touching = 0, troubled = 0;
  for (double t = 0.0; t < path.duration(); t += kStep) {
    const PathSample plan = path.at(t);
    model.compute(q, v, &arm);
    const Vector3d p = arm.X_WE.p, n = saddle.n_W(p.x(), p.y());
    const SurfaceEstimate surface = cloud.estimate(p);
    const ImpedanceTorque& out = controller.step(arm, plan.reference, surface, F_ext);
    F_ext.setZero();
    for (int i = 0; i < kSubsteps; ++i) {  // the world: semi-implicit Euler
      if (i > 0) model.compute(q, v, &arm);
      const Vector3d f = saddle.force(arm.X_WE.p, arm.V_WE.head<3>());
      F_ext.head<3>() += f / kSubsteps;
      v += kStep / kSubsteps *
           arm.M.llt().solve(out.tau - arm.Cv - arm.g + arm.J.topRows<3>().transpose() * f);
      q += kStep / kSubsteps * v;
    }

    troubled += !out.status.ok();
    if (plan.phase != Phase::draw) continue;
    const double force = n.dot(F_ext.head<3>());
    ++drawn;
    touching += force > 0.0;
    sum += force;
    sum_2 += force * force;
    const Vector3d ink = p + saddle.depth(p) * n;  // the tip is compliant, the surface rigid
    line_2 += (ink - plan.reference.p_WD).head<2>().squaredNorm();
    normal_max = std::max(normal_max, std::acos(std::min(1.0, n.dot(surface.n_W))));
  }
  const double mean = sum / drawn,
               deviation = std::sqrt(std::max(0.0, sum_2 / drawn - mean * mean));
  const double rms = std::sqrt(line_2 / drawn);
  std::printf("path  %.1f s, %.3f m drawn\n", path.duration(), path.pen_down_length());
  std::printf("force %.4f N, SD %.4f N, touching %.1f %%\n", mean, deviation,
              100.0 * touching / drawn);
  std::printf("line  %.4f mm RMS; normal %.3f deg off at most\n", 1e3 * rms,
              normal_max * 180.0 / M_PI);
  std::printf("steps that reported trouble: %d\n", troubled);
  const bool good = std::abs(mean - kForce) < 0.05 && deviation < 0.1 && touching == drawn &&
                    rms < 0.03e-3 && normal_max < 0.02 && troubled == 0;
  if (!good) std::printf("out of tolerance\n");
  return good ? 0 : 1;
} catch (const InputError& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 2;
}
