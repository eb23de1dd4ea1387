#include "made_up_run.h"

#include <cmath>
#include <numbers>
#include <random>

#include "impedraw/canvas/built_in.h"

namespace impedraw::testing {
namespace {

constexpr double kPi = std::numbers::pi;
const Eigen::Vector3d kCentre(0.60, 0.0, 0.40);
constexpr double kRadius = 0.30, kSpeed = 0.05, kApproach = 1.5, kLift = 1.2;

Eigen::Vector3d on_bowl(double x, double y) {
  return {
      x, y,
      kCentre.z() - std::sqrt(kRadius * kRadius - (x - kCentre.x()) * (x - kCentre.x()) - y * y)};
}

Eigen::Vector3d sine(double y) {
  return on_bowl(0.60 + 0.05 * std::sin(2 * kPi * (y + 0.15) / 0.15), y);
}

std::vector<Eigen::Vector3d> sine_points(double spacing) {
  std::vector<Eigen::Vector3d> points{sine(-0.15)};
  for (double y = -0.15; y < 0.15 - 1e-6; y += 1e-6) {
    if ((sine(y) - points.back()).norm() >= spacing) points.push_back(sine(y));
  }
  points.push_back(sine(0.15));
  return points;
}

Eigen::Quaterniond facing(const Eigen::Vector3d& normal) {
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), -normal);
}

}  // namespace

RunLogHeader sine_header(const MadeUpSine& settings) {
  RunLogHeader h;
  const Eigen::VectorXd range =
      (Eigen::VectorXd(7) << 2.96706, 2.0944, 2.96706, 2.0944, 2.96706, 2.0944, 3.05433).finished();
  for (int j = 1; j <= 7; ++j) h.joint_names.push_back("joint_a" + std::to_string(j));
  h.joint_lower = -range;
  h.joint_upper = range;
  h.torque_limit = (Eigen::VectorXd(7) << 320, 320, 176, 176, 110, 40, 40).finished();
  h.joint_speed_limit = Eigen::VectorXd::Constant(7, 1.5);
  h.torque_terms = {"gravity",  "impedance", "push",    "null_space",
                    "coriolis", "feedback",  "friction"};
  h.mode_names = {"free", "approach", "contact", "lift"};
  const TriangleMesh bowl = make_bowl({.edge = 0.004});
  h.canvas_vertices = bowl.vertices;
  h.canvas_triangles = bowl.triangles;
  if (settings.perception) {
    std::mt19937 random(settings.seed);
    std::normal_distribution<double> noise(0.02e-3, 0.03e-3);
    for (std::size_t i = 0; i < bowl.vertices.size(); i += 2) {
      const Eigen::Vector3d n = (kCentre - bowl.vertices[i]).normalized();
      h.cloud_points.push_back(bowl.vertices[i] + noise(random) * n);
      h.cloud_normals.push_back(n);
      h.cloud_camera.push_back(static_cast<int>(i % 3));
    }
  }
  for (int s = 0; s < settings.repeat; ++s) {
    for (const Eigen::Vector3d& p : sine_points(0.25e-3)) {
      h.target_points.push_back(p);
      h.target_stroke.push_back(s);
    }
  }
  h.attributes = {{"scenario", settings.perception ? "bowl-sine" : "bowl-sine-blind"},
                  {"seed", std::to_string(settings.seed)}};
  return h;
}

void sine_rows(const MadeUpSine& settings, const std::function<void(const LogRow&)>& take) {
  const std::vector<Eigen::Vector3d> path = sine_points(0.25e-3);
  std::vector<double> length{0.0};
  for (std::size_t i = 1; i < path.size(); ++i)
    length.push_back(length.back() + (path[i] - path[i - 1]).norm());
  const double drawing = length.back() / kSpeed, cycle = kApproach + drawing + kLift;
  std::mt19937 random(settings.seed);
  std::normal_distribution<double> gauss;
  LogRow row(7);
  const auto rows = static_cast<long>(cycle * settings.repeat / settings.time_step);
  for (long i = 0; i < rows; ++i) {
    row.time = static_cast<double>(i) * settings.time_step;
    const int turn = static_cast<int>(row.time / cycle);
    const double t = row.time - turn * cycle,
                 s = std::clamp((t - kApproach) * kSpeed, 0.0, length.back());
    const auto k = std::min<std::size_t>(
        std::upper_bound(length.begin(), length.end(), s) - length.begin(), path.size() - 1);
    const Eigen::Vector3d along = (path[k] - path[k - 1]).normalized();
    const Eigen::Vector3d desired = path[k - 1] + (s - length[k - 1]) * along;
    const Eigen::Vector3d normal = (kCentre - desired).normalized(), across = normal.cross(along);
    const double up = 0.02 * std::max({0.0, (kApproach - 0.15 - t) / kApproach,
                                       (t - kApproach - drawing - 0.1) / kLift});
    const double touch = t - (kApproach - 0.15);  // since the tip came down
    const bool drawn = t >= kApproach && t < kApproach + drawing;

    double f = 0.0, error = 0.0, tilt = 0.002;
    if (up == 0.0) {
      const double wobble = std::sin(9.0 * t) + 0.5 * std::sin(23.0 * t + 1.0);
      f = 5.0 * (1.0 - std::exp(-touch / 0.02) * std::cos(touch / 0.015)) +
          settings.force_noise * gauss(random);
      error = settings.wander * wobble;
      if (!settings.perception) {
        f = std::max(0.0,
                     4.4 + 2.5 * std::sin(7.0 * s / 0.1) + settings.force_noise * gauss(random));
        error = settings.wander * wobble + 0.3e-3 * std::sin(s / 0.03);
        tilt = std::acos(normal.z());
      }
      if (f < 0.0) f = 0.0;
    }
    const Eigen::Vector3d contact = desired + error * across;
    const Eigen::Vector3d true_normal = (kCentre - contact).normalized();
    row.joint_position.setConstant(0.5 + 0.2 * std::sin(t));
    row.joint_velocity.setConstant(0.2 * std::cos(t));
    row.joint_torque.setZero();
    for (int term = 0; term < 7; ++term) {
      for (int j = 0; j < 7; ++j)
        row.torque_terms[term][j] = (j + 1.0) * std::sin(t + term) + 0.01 * gauss(random);
      row.joint_torque += row.torque_terms[term];
    }
    row.tip_position = contact + up * true_normal;
    row.tip_orientation =
        Eigen::AngleAxisd(settings.perception ? tilt * (1.0 + std::sin(3.0 * t)) : 0.0, along) *
        facing(settings.perception ? true_normal : Eigen::Vector3d::UnitZ());
    row.tip_velocity << (drawn ? kSpeed : 0.0) * along, Eigen::Vector3d::Zero();
    row.desired_position = desired + up * normal;
    row.desired_orientation = facing(settings.perception ? normal : Eigen::Vector3d::UnitZ());
    row.contact_force = f > 0.0 ? Eigen::Vector3d(f * true_normal - 0.3 * f * along)
                                : Eigen::Vector3d(Eigen::Vector3d::Zero());
    row.contact_point = f > 0.0 ? contact : LogRow::no_vector();
    row.contact_normal = f > 0.0 ? true_normal : LogRow::no_vector();
    row.wrench_measured << row.contact_force, Eigen::Vector3d::Zero();
    if (settings.perception) {
      row.surface_normal = Eigen::AngleAxisd(0.001 * std::sin(5.0 * t), along) * true_normal;
      row.surface_distance = up + 0.02e-3 * gauss(random);
    }
    row.push = up == 0.0 ? 5.0 : 0.0;
    row.mode = up == 0.0 ? 2 : (t < kApproach ? 1 : 3);
    row.stroke = drawn ? turn : -1;
    row.stroke_along = drawn ? s : LogRow::kNone;
    row.time_scale = i % 100 < 3 ? 0.1 * (i % 100) : 1.0;
    row.step_time = 9e-6 + 0.5e-6 * std::abs(gauss(random)) + (i % 997 == 0 ? 20e-6 : 0.0);
    take(row);
  }
}

RunLogHeader small_header() {
  RunLogHeader h;
  h.joint_names = {"one", "two"};
  h.joint_lower = Eigen::Vector2d(-1.0, -2.0);
  h.joint_upper = Eigen::Vector2d(1.5, 2.5);
  h.torque_limit = Eigen::Vector2d(10.0, 20.0);
  h.torque_terms = {"gravity", "push"};
  h.mode_names = {"free", "contact"};
  h.attributes = {{"seed", "7"}};
  return h;
}

LogRow numbered_row(int i) {
  LogRow row(2);
  double next = 100.0 * i;
  const auto fill = [&next](auto& v) {
    for (Eigen::Index k = 0; k < v.size(); ++k) v[k] = next += 1.0;
  };
  row.time = 1e-3 * i;
  fill(row.joint_position);
  row.joint_position *= 1e-6;  // a log with values beyond sense is refused
  fill(row.joint_velocity);
  fill(row.joint_torque);
  fill(row.torque_terms[0]);
  fill(row.torque_terms[1]);
  fill(row.tip_position);
  fill(row.tip_orientation.coeffs());
  fill(row.tip_velocity);
  fill(row.desired_position);
  fill(row.desired_orientation.coeffs());
  fill(row.contact_force);
  fill(row.contact_point);
  row.contact_point *= 1e-6;
  fill(row.contact_normal);
  fill(row.wrench_measured);
  fill(row.disturbance_force);
  fill(row.surface_normal);
  row.surface_distance = next += 1.0;
  row.push = next += 1.0;
  row.mode = i % 2;
  row.stroke = i % 5 - 1;
  row.stroke_along = 1e-6 * (next += 1.0);
  row.time_scale = next += 1.0;
  row.step_time = next += 1.0;
  return row;
}

}  // namespace impedraw::testing
