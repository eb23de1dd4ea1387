#include "app/experiment.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/blame.h"
#include "app/on_canvas.h"
#include "app/perceived_surface.h"
#include "arm/inverse_kinematics.h"
#include "common/errors.h"
#include "drawing/artwork_file.h"
#include "drawing/order.h"
#include "drawing/simplify.h"
#include "planning/reach.h"
#include "planning/tip_planner.h"

namespace impedraw {

namespace {

std::filesystem::path urdf_of(const ArmSettings& s) {
  return s.urdf.empty() ? std::filesystem::path(IMPEDRAW_ROOT) / "models/iiwa14_pen.urdf" : s.urdf;
}

std::string joint_text(const JointVector& q) {
  std::string text;
  for (double x : q) text += fmt::format("{}{:.2f}", text.empty() ? "" : ", ", x);
  return text;
}

// What the depth cameras see of canvas and arm, before drawing.
SurfaceEstimator take_snapshot(const Scenario& s, const Canvas& canvas, const World& world, ArmModel& arm, const JointVector& q) {
  const PerceptionSettings& p = s.perception;
  if (p.cameras.empty()) throw InputError("perception.cameras is empty; valid are at least one camera, or perception.enabled: false");
  const Eigen::AlignedBox3d box = canvas.bounds();
  const CastRay cast = [&](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    double distance = world.ray_to_arm(origin, direction);
    if (const auto hit = canvas.ray(origin, direction)) distance = std::min(distance, hit->t);
    return distance;
  };
  std::vector<DepthCamera> cameras;
  std::vector<DepthImage> images;
  for (std::size_t i = 0; i < p.cameras.size(); ++i) {
    const CameraSettings& c = p.cameras[i];
    cameras.push_back({c.width, c.height, c.fov_y_deg, look_at(c.p_WC, c.target_W)});
    images.push_back(render_depth(cameras.back(), cast, p.noise, static_cast<std::uint64_t>(s.seed) * 1000 + i));
  }
  std::vector<Capsule> body;
  for (const BodyCapsule& c : arm.body_capsules(q)) body.push_back({c.a_W, c.b_W, c.radius});
  CloudSettings settings;
  settings.voxel = p.voxel;
  settings.self_padding = p.self_padding;
  settings.region = Eigen::AlignedBox3d(p.region_lower, p.region_upper);
  PointCloud cloud = fuse(images, cameras, settings, body);
  if (cloud.points.size() < static_cast<std::size_t>(p.normals.k))
    throw InputError(fmt::format(
        "the cameras see {} points of the canvas within perception.region ({:.2f} to {:.2f}, {:.2f} to {:.2f}, {:.2f} to {:.2f} m); "
        "at least {} are needed; the canvas fills ({:.2f} to {:.2f}, {:.2f} to {:.2f}, {:.2f} to {:.2f} m)",
        cloud.points.size(), p.region_lower.x(), p.region_upper.x(), p.region_lower.y(), p.region_upper.y(), p.region_lower.z(),
        p.region_upper.z(), p.normals.k, box.min().x(), box.max().x(), box.min().y(), box.max().y(), box.min().z(), box.max().z()));
  return SurfaceEstimator(std::move(cloud), p.normals);
}

// The true canvas, looking along −z.
SurfaceHeight canvas_height(const Canvas& canvas) {
  const double above = canvas.bounds().max().z() + 1.0;
  return [&canvas, above](double x, double y) -> std::optional<SurfaceSample> {
    const auto hit = canvas.ray({x, y, above}, -Eigen::Vector3d::UnitZ());
    if (!hit) return std::nullopt;
    return SurfaceSample{hit->p_W, hit->n_W};
  };
}

// Walks the arm along the path by inverse kinematics, each posture from the last.
ReachProblem arm_reach(ArmModel& arm, const JointVector& start) {
  return [&arm, q = start](const Eigen::Vector3d& p_WD, const Eigen::Vector3d& n_WD) mutable -> std::string {
    IkSettings settings;
    settings.position_tolerance = settings.axis_tolerance = 1e-5;
    const IkResult result = find_posture(arm, {p_WD, -n_WD}, q, settings);
    if (!result.reached)
      return fmt::format("the pen gets no nearer than {:.0f} mm and {:.0f}°", 1e3 * result.position_error,
                         result.axis_error * 180.0 / M_PI);
    q = result.q;
    return {};
  };
}

// How far the tip stays short of a point, each posture from the last that got there.
ShortOf tip_shortfall(ArmModel& arm, const JointVector& start) {
  return [&arm, q = start](const Eigen::Vector3d& p_WD, const Eigen::Vector3d& n_W) mutable {
    IkSettings settings;
    settings.position_tolerance = settings.axis_tolerance = 1e-5;
    const IkResult result = find_posture(arm, {p_WD, -n_W}, q, settings);
    if (!result.reached) return std::max(result.position_error, 1e-9);
    q = result.q;
    return 0.0;
  };
}

// What the controller's checks look at, the likeliest culprit first.
std::vector<std::string> control_settings() {
  std::vector<std::string> names;
  for (const char* name : {"wrench", "inertia", "mass_normal", "mass_tangent", "rotational_inertia_tangent", "rotational_inertia_normal",
                           "contact.leave_distance", "contact.enter_distance", "contact_stiffness_max", "natural_mass_max", "damping_ratio",
                           "stiffness_normal", "stiffness_tangent"})
    names.push_back(std::string("control.") + name);
  names.push_back("control");
  return names;
}

}  // namespace

Experiment prepare(const Scenario& given, const Places& places) {
  const Blame blame(places);
  Scenario s = given;
  const bool seen = s.perception.enabled;

  Shape artwork;
  if (s.drawing.svg.empty()) {
    artwork = make_shape(s.drawing.shape);
    // Built-in shapes have a size of their own, which only a size that is given outright changes.
    PlacementSettings& placing = s.drawing.placement;
    placing.about_page_origin = true;
    if (!placing.scale && !placing.width_mm && !placing.height_mm) placing.scale = 1.0;
  } else {
    blame.on({"drawing.svg"}, [&] { artwork.drawn = read_artwork(s.drawing.svg); });
    std::vector<Stroke>& strokes = artwork.drawn.strokes;
    if (s.drawing.join_gap_mm > 0.0) strokes = joined(strokes, s.drawing.join_gap_mm);
    if (!s.drawing.keep_order) strokes = in_order(strokes, shortest_order(strokes));
    artwork.target = artwork.drawn;
  }
  const std::vector<std::string> where_drawn = {"drawing.placement.scale", "drawing.placement.width", "drawing.placement.height",
                                                "drawing.placement.fit_radius", "drawing.placement.centre", "drawing.placement", "canvas",
                                                "drawing"};
  const Placement placement = blame.on(where_drawn, [&] { return place(artwork.drawn, s.drawing.placement); });
  const auto drawn = placed_strokes(artwork.drawn, placement), wanted = placed_strokes(artwork.target, placement);

  std::vector<std::string> notes;
  auto owned_canvas = blame.on({"canvas"}, [&] { return std::make_unique<Canvas>(make_mesh(s.canvas, &notes)); });
  const Canvas& canvas = *owned_canvas;
  const SurfaceHeight truth = canvas_height(canvas);
  blame.on(where_drawn, [&] { require_on_canvas(drawn, canvas.mesh(), truth); });
  TargetLine target = blame.on(where_drawn, [&] { return project_target(wanted, truth); });

  // A sensor is tared at rest before anything moves.
  const bool sensed = has_sensor(s.control.source);
  s.world.flange_sensor = sensed;
  const WrenchSensorSettings sensor = s.control.source == WrenchSource::realistic ? WrenchSensorSettings::realistic() : s.wrench_sensor;
  const WrenchEstimatorSettings estimator = estimator_settings(s.control.sensing, sensor, s.world.dt, s.world.gravity);
  double wrench_delay = s.world.dt;
  blame.on({"control.sensing", "wrench_sensor", "control.wrench"}, [&] {
    WrenchInput(s.control.source, estimator, sensor, s.world.dt, 0);
    if (sensed) wrench_delay += WrenchEstimator(estimator).group_delay();
  });

  // The world first: its reader of URDF says what is wrong, the arm model's prints lines of its own.
  auto world = blame.on({"arm.urdf"}, [&] { return std::make_unique<World>(urdf_of(s.arm), &canvas, s.world); });
  ArmModel arm = blame.on({"arm.urdf"}, [&] { return ArmModel(urdf_of(s.arm)); });
  const int n = arm.joints();
  if (s.arm.posture_seed.size() != n)
    blame.wrong({"arm.posture_seed", "arm.urdf"},
                fmt::format("arm.posture_seed has {} entries, the arm {} joints", s.arm.posture_seed.size(), n));
  const IkResult start = find_posture(arm, {s.arm.start_p_WE, -Eigen::Vector3d::UnitZ()}, JointVector(s.arm.posture_seed));
  if (!start.reached)
    blame.wrong({"arm.start", "arm"},
                fmt::format("arm.start ({:.3f}, {:.3f}, {:.3f}) m is out of the arm's reach by {:.0f} mm", s.arm.start_p_WE.x(),
                                 s.arm.start_p_WE.y(), s.arm.start_p_WE.z(), 1e3 * start.position_error));
  blame.on(where_drawn, [&] { require_strokes_in_reach(drawn, truth, !seen, tip_shortfall(arm, start.q)); });
  world->set_state(start.q, JointVector::Zero(n));

  std::optional<SurfaceEstimator> perception;
  const std::vector<std::string> how_seen = {"perception.region_lower", "perception.region_upper", "perception.cameras", "perception.voxel",
                                             "perception.noise", "perception", "canvas"};
  if (seen) blame.on(how_seen, [&] { perception.emplace(take_snapshot(s, canvas, *world, arm, start.q)); });

  // Blind, the wanted point lies beneath the surface: the stiffness makes the push.
  SurfaceHeight surface = truth;
  PathSettings path_settings = s.path;
  path_settings.start_p_WE = s.arm.start_p_WE;
  path_settings.start_n_W = Eigen::Vector3d::UnitZ();
  if (sensed) path_settings.start_hold = std::max(path_settings.start_hold, s.control.sensing.tare_time + 1.0);
  if (seen) {
    surface = perceived_height(*perception);
  } else {
    path_settings.vertical_pen = true;
    if (!(s.control.stiffness.linear.normal > 0.0))
      blame.wrong({"control.stiffness_normal"}, "control.stiffness_normal is 0 N/m: blind, it makes the push; valid is more than 0 N/m");
    if (s.blind.height == BlindHeight::canvas) path_settings.sink = s.control.push_force / s.control.stiffness.linear.normal;
    else surface = [z = s.blind.plane_z](double x, double y) { return SurfaceSample{{x, y, z}, Eigen::Vector3d::UnitZ()}; };
    path_settings.highest_z = canvas.bounds().max().z();
  }
  const double start_hold = path_settings.start_hold;
  TipPath path = blame.on({"path"}, [&] {
    try {
      return plan_tip_path(drawn, surface, path_settings);
    } catch (const InputError& error) {
      // The canvas is there: require_on_canvas has looked.
      if (!seen || !std::string_view(error.what()).starts_with("stroke")) throw;
      throw InputError(
          fmt::format("{}, as the cameras see it: perception.cameras, noise, region or normals must let them see more", error.what()));
    }
  });
  blame.on({"drawing.placement.centre", "canvas", "path", "arm"}, [&] { require_reach(path, 0.01, arm_reach(arm, start.q)); });

  ImpedanceSettings control = s.control;
  control.dt = s.world.dt;
  control.wrench = s.control.source == WrenchSource::none ? WrenchFeedback::none : WrenchFeedback::measured;
  control.wrench_delay = wrench_delay;
  control.torque_limit = s.control.torque_share * arm.limits().torque;
  control.torque_rate_limit = Eigen::VectorXd::Constant(n, s.control.torque_rate);
  control.joint_lower = arm.limits().lower;
  control.joint_upper = arm.limits().upper;
  if (s.arm.q_0.empty()) {
    const Eigen::Vector2d c = s.drawing.placement.centre_m;
    const auto middle = surface(c.x(), c.y());
    const Eigen::Vector3d p_WE = middle ? middle->p_W : target.points[target.points.size() / 2];
    const IkResult rest = find_posture(arm, {p_WE, -Eigen::Vector3d::UnitZ()}, start.q);
    control.q_0 = rest.q;
  } else if (static_cast<int>(s.arm.q_0.size()) != n) {
    blame.wrong({"arm.q_0"}, fmt::format("arm.q_0 has {} entries, the arm {} joints", s.arm.q_0.size(), n));
  } else {
    control.q_0 = Eigen::Map<const Eigen::VectorXd>(s.arm.q_0.data(), n);
  }
  if (const JointVector q_0 = control.q_0; ((q_0 - JointVector(arm.limits().lower)).array() < 0.0).any() ||
                                                ((JointVector(arm.limits().upper) - q_0).array() < 0.0).any())
    blame.wrong({"arm.q_0"}, fmt::format("arm.q_0 ({}) rad lies beyond the joint ranges, ({}) to ({}) rad", joint_text(q_0),
                                            joint_text(arm.limits().lower), joint_text(arm.limits().upper)));
  blame.on(control_settings(), [&] { ImpedanceController(control, n); });  // its checks, before anything is written

  return Experiment{std::move(s),    std::move(notes),
                    std::move(artwork),
                    placement,       std::move(owned_canvas),
                    std::move(arm),  std::move(perception),
                    std::move(path), std::move(target),
                    control,         sensor,
                    estimator,       start.q,
                    start_hold,      std::move(world)};
}

}  // namespace impedraw
