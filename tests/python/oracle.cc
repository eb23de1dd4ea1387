// The library's own results, for tests of the Python package: called by ctypes, so that nothing of
// the bindings stands between.
// Arrays are of doubles, matrices row by row; results are written to `out`.
#include <algorithm>
#include <cstdint>

#include "impedraw/arm/arm_model.h"
#include "impedraw/control/impedance.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/perception/normals.h"
#include "impedraw/perception/organised_points.h"
#include "impedraw/perception/registration.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/sensing/wrench_estimator.h"
#include "impedraw/simulation/world.h"

namespace {

using namespace impedraw;

JointVector joints_at(const double* x) { return Eigen::Map<const Eigen::Matrix<double, 7, 1>>(x); }
Eigen::Vector3d vector_at(const double* x) { return Eigen::Map<const Eigen::Vector3d>(x); }
Vector6 six_at(const double* x) { return Eigen::Map<const Vector6>(x); }

template <class T>
double* put(const T& x, double* out) {
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    for (Eigen::Index j = 0; j < x.cols(); ++j) *out++ = x(i, j);
  return out;
}

}  // namespace

extern "C" {

// out: M, Cv, g, J, Jdot_v, p_WE, R_WE, V_WE: 129 numbers.
void oracle_arm(const char* urdf, const double* q, const double* v, double* out) {
  ArmModel arm(urdf);
  ArmTerms t(7);
  arm.compute(joints_at(q), joints_at(v), &t);
  out = put(t.Cv, put(t.M, out));
  out = put(t.Jdot_v, put(t.J, put(t.g, out)));
  put(t.V_WE, put(t.X_WE.R, put(t.X_WE.p, out)));
}

// settings: normal force, tangential stiffness, touch force, mass along the normal, inertia
// (number). Each of n steps takes
// q, v, p_WD, n_WD, pen_down, surface's n_W and distance, F_ext: 31 numbers. out, each step: tau,
// terms, mode, push: 65 numbers.
void oracle_control(const char* urdf, const double* settings, int n, const double* steps,
                    double* out) {
  ImpedanceSettings s;
  s.normal_force = settings[0];
  s.stiffness.linear.tangent = settings[1];
  s.contact.touch_force = settings[2];
  s.shaped_inertia.linear.normal = settings[3];
  s.inertia = static_cast<InertiaShaping>(static_cast<int>(settings[4]));
  ImpedanceController controller(s, 7);
  ArmModel arm(urdf);
  ArmTerms t(7);
  for (int k = 0; k < n; ++k) {
    const double* x = steps + 31 * k;
    arm.compute(joints_at(x), joints_at(x + 7), &t);
    TipReference reference;
    reference.p_WD = vector_at(x + 14);
    reference.n_WD = vector_at(x + 17);
    reference.pen_down = x[20] != 0.0;
    SurfaceEstimate surface;
    surface.status = SurfaceStatus::ok;
    surface.n_W = vector_at(x + 21);
    surface.distance = x[24];
    const ImpedanceTorque& made = controller.step(t, reference, surface, six_at(x + 25), {});
    out = put(made.terms, put(made.tau, out));
    *out++ = static_cast<double>(made.mode);
    *out++ = made.push;
  }
}

// out, each of n queries: n_W, distance, status: 5 numbers.
void oracle_surface(const double* points, int count, const double* viewpoint, int k, int n,
                    const double* queries, double* out) {
  PointCloud cloud;
  for (int i = 0; i < count; ++i) cloud.points.push_back(vector_at(points + 3 * i));
  cloud.camera.assign(cloud.points.size(), 0);
  cloud.eyes = {vector_at(viewpoint)};
  NormalSettings settings;
  settings.k = k;
  const SurfaceEstimator estimator(std::move(cloud), settings);
  for (int i = 0; i < n; ++i) {
    const SurfaceEstimate e = estimator.estimate(vector_at(queries + 3 * i));
    out = put(e.n_W, out);
    *out++ = e.distance;
    *out++ = static_cast<double>(e.status);
  }
}

// Samples of a depth image: how many, then p_W, n_W, deviation of each: 7 numbers. X_WC: R, p.
void oracle_depth_samples(const double* depth, int width, int height, double fov_y_deg,
                          const double* X_WC, int most, double* out) {
  DepthImage image{width, height, std::vector<double>(depth, depth + width * height)};
  Pose X;
  X.R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(X_WC);
  X.p = vector_at(X_WC + 9);
  const DepthCamera camera{width, height, fov_y_deg, X};
  const Eigen::Vector3d far = Eigen::Vector3d::Constant(100.0);
  std::vector<SeenPoint> samples;
  OrganisedPoints().find(image, camera, {-far, far}, {}, 0.0, &samples);
  const int count = std::min(most, static_cast<int>(samples.size()));
  *out++ = count;
  for (int i = 0; i < count; ++i) {
    const SeenPoint& s = samples[static_cast<std::size_t>(i)];
    out = put(s.n, put(s.p, out));
    *out++ = s.deviation;
  }
}

// Where the body is whose model the first samples are, from later ones. out: R, p, found, open.
void oracle_registration(const double* model, int model_count, const double* later, int later_count,
                         double* out) {
  const auto samples_of = [](const double* x, int count) {
    std::vector<SeenPoint> samples;
    for (int i = 0; i < count; ++i, x += 7)
      samples.push_back({vector_at(x), vector_at(x + 3), x[6]});
    return samples;
  };
  SurfaceModel surface;
  surface.add(samples_of(model, model_count), {});
  const ShapeRegistration found = register_samples(surface, samples_of(later, later_count), {});
  out = put(found.X_WK.p, put(found.X_WK.R, out));
  *out++ = found.found;
  *out++ = found.open;
}

// One stroke on a level plane. out: duration, then for each of n times p_WD, v_WD, a_WD, n_WD,
// stroke, along: 14 numbers.
void oracle_path(const double* stroke, int count, double height, double draw_speed, int n,
                 const double* times, double* out) {
  PlacedStroke placed;
  for (int i = 0; i < count; ++i) {
    placed.p_P.emplace_back(stroke[2 * i], stroke[2 * i + 1]);
    placed.page.push_back(1e3 * placed.p_P.back());
  }
  PathSettings settings;
  settings.draw_speed = draw_speed;
  const TipPath path = plan_tip_path({placed}, level_surface(height), settings);
  *out++ = path.duration();
  for (int i = 0; i < n; ++i) {
    const PathSample x = path.at(times[i]);
    out = put(x.reference.n_WD,
              put(x.reference.a_WD, put(x.reference.v_WD, put(x.reference.p_WD, out))));
    *out++ = x.stroke;
    *out++ = x.along;
  }
}

// Readings at rest in pose 1. out, each of n readings: F_ext: 6 numbers.
void oracle_wrench(double bandwidth, double tare_time, int n, const double* readings, double* out) {
  WrenchEstimatorSettings settings;
  settings.filter_bandwidth = bandwidth;
  settings.tare_time = tare_time;
  WrenchEstimator estimator(settings);
  for (int i = 0; i < n; ++i)
    out = put(estimator.update(six_at(readings + 6 * i), Pose(), Vector6::Zero()), out);
}

// Each of n steps takes a torque and a push: 10 numbers. out, each step: q, v, f_W: 17 numbers.
void oracle_world(const char* urdf, const double* q, double joint_friction, int n,
                  const double* steps, double* out) {
  WorldSettings settings;
  settings.joint_friction = joint_friction;
  World world(urdf, nullptr, settings);
  world.set_state(joints_at(q), JointVector::Zero(7));
  for (int k = 0; k < n; ++k) {
    const TipContact contact = world.step(joints_at(steps + 10 * k), vector_at(steps + 10 * k + 7));
    out = put(contact.f_W, put(world.state().v, put(world.state().q, out)));
  }
}
}
