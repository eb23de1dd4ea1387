// A led blade in the closed loop: path, law and arm in MuJoCo, on a bowl that is exactly known. Yaw
// and corners are judged against the strokes themselves.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include <unistd.h>

#include <gtest/gtest.h>

#include "arm_fixture.h"
#include "impedraw/arm/arm_notes.h"
#include "impedraw/canvas/built_in.h"
#include "impedraw/control/heading.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/stroke_part.h"
#include "impedraw/simulation/blade_law.h"
#include "impedraw/simulation/world.h"
#include "planning/surfaces.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;
using namespace testing_arm;

constexpr double kForce = 1.2;  // [N]

struct Cut {
  double yaw_rms = 0.0, yaw_max = 0.0;  // [rad]
  double smear = 0.0;                   // [m]
  double off = 0.0;                     // of the edge's middle, farthest from the line [m]
  double force = 0.0, on_line = 0.0;    // mean [N]; share of the drawing's steps with 0.3 N
};

double distance(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const double share = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - share * (b - a)).norm();
}

struct Arm {
  std::string name;  // empty: the iiwa of the repository
  std::vector<double> seed;
};
const Arm kIiwa{"", {0.1, 0.6, -0.1, -1.4, 0.2, 1.1, 0.3}};
const Arm kFr3{"fr3", {0.0, 0.1, 0.0, -2.2, 0.0, 2.3, 0.0}};
const Arm kUr5e{"ur5e", {0.0, -1.2, 1.8, -2.2, -1.57, 0.0}};

std::filesystem::path urdf_of(const Arm& arm) {
  if (arm.name.empty()) return kArm;
  std::ifstream in("models/arms/" + arm.name + ".urdf");
  std::stringstream text;
  text << in.rdbuf();
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / (arm.name + std::to_string(getpid()) + ".urdf");
  std::ofstream(file) << urdf_with_pen(text.str(), {0.12, 0.05});
  return file;
}

// window: of the line about the plan's place, in which the blade's own is sought [m].
Cut cut(const PlacedStroke& stroke, double trail, bool lifted, double window,
        double heading_stiffness = 30.0, const Arm& of = kIiwa) {
  const std::filesystem::path urdf = urdf_of(of);
  ArmModel arm(urdf);
  const int joints = arm.joints();
  const JointVector seed = Eigen::Map<const Eigen::VectorXd>(of.seed.data(), joints);
  BowlSettings bowl;
  const Canvas canvas(make_bowl(bowl));
  WorldSettings world_settings;
  world_settings.pad = blade_edge({}, 0.0, kForce);
  world_settings.pad->trail = trail;
  World world(urdf, &canvas, world_settings);

  ImpedanceSettings s = shaped_settings(arm);
  s.null_space.q_0 = seed;
  s.tip = {0.0, 0.0};
  s.normal_force = kForce;
  s.contact.deepest += world_settings.pad->thickness;
  s.stability_check.contact_stiffness_max =
      2.0 * world_settings.pad->stiffness * world_settings.pad->area();
  s.stiffness.angular.normal = heading_stiffness;
  s.friction.coefficient = 1.2 * world_settings.pad->friction;
  s.surface.pen_axis = PenAxis::plan;
  s.joint_range.lower = arm.limits().lower;
  s.joint_range.upper = arm.limits().upper;
  s.limits.joint_speed = 0.9 * arm.limits().speed;
  ImpedanceController controller(s, arm.joints());

  const IkResult start = find_posture(arm, {{0.55, 0.0, 0.25}, -Vector3d::UnitZ()}, seed);
  EXPECT_TRUE(start.reached);
  world.set_state(start.q, JointVector::Zero(joints));
  PathSettings path_settings = surfaces::brisk();
  path_settings.start_p_WE = world.state().X_WE.p;
  path_settings.start_n_W = -world.state().X_WE.R.col(2);
  path_settings.draw_speed = 0.03;
  path_settings.turn_speed = 2.0;
  path_settings.turn_acceleration = 10.0;
  ToolHeading& heading = path_settings.heading.emplace();
  heading.trail = trail;
  heading.lifted = lifted;
  heading.start_x_W = world.state().X_WE.R.col(0);
  // The last joint turns about z_E, which is −n.
  const int last = joints - 1;
  heading.least = start.q[last] - arm.limits().upper[last] + 0.25;
  heading.most = start.q[last] - arm.limits().lower[last] - 0.25;
  const TipPath path = plan_tip_path({stroke}, surfaces::bowl, path_settings);

  Cut cut;
  double way = 0.0, square = 0.0, last_along = 0.0, steps = 0.0;
  Wrench F_ext = Wrench::Zero();
  ArmTerms terms(joints);
  for (double t = 0.0; t < path.duration(); t += 1e-3) {
    const PathSample sample = path.at(t);
    arm.compute(world.state().q, world.state().v, &terms);
    const Vector3d p = terms.X_WE.p;
    SurfaceEstimate surface;
    surface.status = SurfaceStatus::ok;
    surface.n_W = (surfaces::kBowlCentre - p).normalized();
    surface.distance = surfaces::kBowlRadius - (surfaces::kBowlCentre - p).norm();
    const ImpedanceTorque& out = controller.step(terms, sample.reference, surface, F_ext);
    const Pose X = world.state().X_WE;
    const TipContact& contact = world.step(out.tau, Vector3d::Zero());
    F_ext.setZero();
    if (contact.touching) {
      F_ext.head<3>() = contact.f_W;
      F_ext.tail<3>() = (contact.p_WC - X.p).cross(contact.f_W) + contact.m_W;
    }
    if (sample.stroke < 0) continue;
    ++steps;
    if (!contact.touching || contact.f_W.norm() < 0.3) continue;
    cut.on_line += 1.0;
    cut.force += contact.n_W.dot(contact.f_W);

    const Vector3d x = X.R.col(0), middle = X.p - trail * x;
    const Vector2d at = middle.head<2>();
    double along = 0.0, nearest = 1.0, corner = 1.0;
    Vector2d tangent = Vector2d::UnitX();
    for (std::size_t i = 1; i < stroke.p_P.size(); ++i) {
      const Vector2d &a = stroke.p_P[i - 1], &b = stroke.p_P[i];
      const double from = along;
      along += (b - a).norm();
      if (along < sample.along - window || from > sample.along + window) continue;
      const double off = distance(at, a, b);
      if (off < nearest) nearest = off, tangent = b - a;
    }
    for (std::size_t i = 1; i + 1 < stroke.p_P.size(); ++i) {
      const Vector2d a = stroke.p_P[i] - stroke.p_P[i - 1], b = stroke.p_P[i + 1] - stroke.p_P[i];
      if (a.dot(b) < std::cos(0.44) * a.norm() * b.norm())
        corner = std::min(corner, (at - stroke.p_P[i]).norm());
    }
    cut.off = std::max(cut.off, nearest);
    const double moved = std::max(0.0, sample.along - last_along);
    last_along = sample.along;
    const Vector3d n = (surfaces::kBowlCentre - middle).normalized();
    const Vector3d t_W(tangent.x(), tangent.y(), -n.head<2>().dot(tangent) / n.z());
    const double error = yaw_between(t_W, x, n);
    if (moved > 1e-6) {  // slower, it is about to stop and turn
      way += moved;
      square += error * error * moved;
      cut.yaw_max = std::max(cut.yaw_max, std::abs(error));
    }
    if (corner > 3e-3) continue;
    for (const double end : {-1.0, 1.0}) {
      const Vector2d q = (middle + end * world_settings.pad->radius * x).head<2>();
      double off = 1.0;
      for (std::size_t i = 1; i < stroke.p_P.size(); ++i)
        off = std::min(off, distance(q, stroke.p_P[i - 1], stroke.p_P[i]));
      cut.smear = std::max(cut.smear, off);
    }
  }
  cut.yaw_rms = std::sqrt(square / std::max(way, 1e-9));
  cut.force /= std::max(1.0, cut.on_line);
  cut.on_line /= std::max(1.0, steps);
  EXPECT_GT(way, 0.95 * plane_length(stroke));
  std::printf("yaw %.3f deg RMS, %.3f most; smear %.3f mm; off %.3f mm; %.3f N; on line %.4f\n",
              cut.yaw_rms * 180.0 / pi, cut.yaw_max * 180.0 / pi, 1e3 * cut.smear, 1e3 * cut.off,
              cut.force, cut.on_line);
  return cut;
}

PlacedStroke sine() {
  std::vector<Vector2d> p;
  for (int i = 0; i <= 640; ++i) {
    const double y = -0.08 + 2.5e-4 * i;
    p.emplace_back(0.6 + 0.03 * std::sin(2.0 * pi * y / 0.08), y);
  }
  return surfaces::line(p);
}

PlacedStroke star() {
  std::vector<Vector2d> p;
  for (int i = 0; i <= 10; ++i) {
    const double r = i % 2 ? 0.022 : 0.05, a = i * pi / 5.0;
    p.emplace_back(0.6 + r * std::cos(a), r * std::sin(a));
  }
  return surfaces::line(p);
}

TEST(BladeLoop, FollowsTheTangentOfASine) {
  const Cut along = cut(sine(), 0.0, false, 4e-3);
  EXPECT_LT(along.yaw_rms, 2.0 * pi / 180.0);
  EXPECT_LT(along.off, 3e-4);
  EXPECT_NEAR(along.force, kForce, 0.05);
  EXPECT_GT(along.on_line, 0.99);
}

TEST(BladeLoop, SwivelsAtTheCornersOfAStar) {
  for (const double trail : {0.0, 1e-3})
    for (const bool lifted : {false, true}) {
      const Cut along = cut(star(), trail, lifted, 1e-6);
      EXPECT_LT(along.yaw_rms, 2.0 * pi / 180.0) << trail << lifted;
      EXPECT_LT(along.smear, 2e-4) << trail << lifted;
    }
}

TEST(BladeLoop, OtherArms) {
  for (const Arm& arm : {kFr3, kUr5e}) {
    std::printf("%s ", arm.name.c_str());
    EXPECT_LT(cut(sine(), 0.0, false, 4e-3, 30.0, arm).yaw_rms, 2.0 * pi / 180.0) << arm.name;
    std::printf("%s ", arm.name.c_str());
    const Cut along = cut(star(), 1e-3, false, 1e-6, 30.0, arm);
    EXPECT_LT(along.yaw_rms, 2.0 * pi / 180.0) << arm.name;
    EXPECT_LT(along.smear, 2e-4) << arm.name;
  }
}

// What the test can see: without stiffness about the normal the yaw drifts off.
TEST(BladeLoop, NeedsItsStiffness) {
  EXPECT_GT(cut(sine(), 0.0, false, 4e-3, 0.0).yaw_rms, 2.0 * pi / 180.0);
}

}  // namespace
}  // namespace impedraw
